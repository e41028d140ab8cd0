#include "element_sums.h"

namespace tetraction {

void clear(const RestState& rest, bool with_hessian, ElasticPotential::ElementTerms& terms) {
  const int nodes = rest.nodes_per_element();
  terms.energy = 0.0;
  terms.gradient.setZero(3, nodes);
  if (with_hessian) terms.hessian.setZero(3 * nodes, 3 * nodes);
}

void add_point_gradient(int p, const LinearTetrahedron::NodeMatrix& g, NodeGradient& gradient) {
  if (gradient.cols() == LinearTetrahedron::kNodes) {
    gradient += g;
    return;
  }
  for (int a = 0; a < QuadraticPoints::kNodes; ++a) {
    for (int k = 0; k < 3; ++k) {
      gradient.col(a) += QuadraticPoints::coefficient(p, k, a) * g.col(k + 1);
    }
  }
}

// The first node of a point is zero for every motion, so that only the blocks of the others count.
void add_point_matrix(int p, const LinearTetrahedron::DofMatrix& k, ElementMatrix& matrix) {
  if (matrix.rows() == LinearTetrahedron::kDofs) {
    matrix += k;
    return;
  }
  Eigen::Matrix<double, QuadraticPoints::kNodes, 3> c;
  for (int a = 0; a < QuadraticPoints::kNodes; ++a) {
    for (int i = 0; i < 3; ++i) c(a, i) = QuadraticPoints::coefficient(p, i, a);
  }
  for (int a = 0; a < QuadraticPoints::kNodes; ++a) {
    const Eigen::Matrix<double, 3, 9> rows = c(a, 0) * k.block<3, 9>(3, 3) +
                                             c(a, 1) * k.block<3, 9>(6, 3) +
                                             c(a, 2) * k.block<3, 9>(9, 3);
    for (int b = 0; b < QuadraticPoints::kNodes; ++b) {
      matrix.block<3, 3>(3 * a, 3 * b) += c(b, 0) * rows.leftCols<3>() +
                                          c(b, 1) * rows.middleCols<3>(3) +
                                          c(b, 2) * rows.rightCols<3>();
    }
  }
}

}  // namespace tetraction
