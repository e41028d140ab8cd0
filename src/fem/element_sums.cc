#include "element_sums.h"

#include <array>

namespace tetraction {
namespace {

// QuadraticPoints::coefficient(p, k, a) as kCoefficients[p][a][k].
constexpr auto kCoefficients = [] {
  std::array<std::array<std::array<double, 3>, QuadraticPoints::kNodes>, QuadraticPoints::kPoints>
      table{};
  for (int p = 0; p < QuadraticPoints::kPoints; ++p) {
    for (int a = 0; a < QuadraticPoints::kNodes; ++a) {
      for (int k = 0; k < 3; ++k) {
        table[static_cast<std::size_t>(p)][static_cast<std::size_t>(a)]
             [static_cast<std::size_t>(k)] = QuadraticPoints::coefficient(p, k, a);
      }
    }
  }
  return table;
}();

}  // namespace

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
      gradient.col(a) += kCoefficients[static_cast<std::size_t>(p)][static_cast<std::size_t>(a)]
                                      [static_cast<std::size_t>(k)] *
                         g.col(k + 1);
    }
  }
}

// The first node of a point is zero for every motion, so that only the blocks of the others count.
void add_point_matrix(int p, const LinearTetrahedron::DofMatrix& k, ElementMatrix& matrix) {
  if (matrix.rows() == LinearTetrahedron::kDofs) {
    matrix += k;
    return;
  }
  const auto& c = kCoefficients[static_cast<std::size_t>(p)];
  for (int a = 0; a < QuadraticPoints::kNodes; ++a) {
    const auto& own = c[static_cast<std::size_t>(a)];
    const Eigen::Matrix<double, 3, 9> rows =
        own[0] * k.block<3, 9>(3, 3) + own[1] * k.block<3, 9>(6, 3) + own[2] * k.block<3, 9>(9, 3);
    for (int b = 0; b < QuadraticPoints::kNodes; ++b) {
      const auto& other = c[static_cast<std::size_t>(b)];
      matrix.block<3, 3>(3 * a, 3 * b) += other[0] * rows.leftCols<3>() +
                                          other[1] * rows.middleCols<3>(3) +
                                          other[2] * rows.rightCols<3>();
    }
  }
}

}  // namespace tetraction
