#include "quadratic_points.h"

namespace tetraction {

const QuadraticPoints::Table& QuadraticPoints::table() {
  static const Table table = [] {
    using Number = Eigen::Matrix<double, 1, 1>;
    Table result;
    for (int a = 0; a < kNodes; ++a) {
      std::array<Number, kNodes> nodes;
      for (Number& node : nodes) node.setZero();
      nodes[at(a)].setOnes();
      std::array<Number, kEdges> edges;
      edges_of(nodes, edges);
      for (int p = 0; p < kPoints; ++p) {
        for (int k = 0; k < 3; ++k) result[at(p)][at(k)][at(a)] = edges[at(3 * p + k)][0];
      }
    }
    return result;
  }();
  return table;
}

}  // namespace tetraction
