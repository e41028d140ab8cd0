#include "block_stiffness.h"

#include "element_scatter.h"

namespace tetraction {
namespace {

// Adds an element matrix of tangent_stiffness(), with a stride of kBatchLanes, to the sparse matrix.
void scatter_numbers(const SparsityPattern& pattern, const SparsityPattern::ElementEntries& entries,
                     const double* numbers, double* values) {
  constexpr int kLanes = kBatchLanes;
  scatter_element(
      entries, pattern.column_begin(),
      [&](int a, int i, int j) { return numbers[(6 * a + j * (5 - j) / 2 + i) * kLanes]; },
      [&](int k, int, int) {
        return StridedBlock{numbers + (24 + 9 * k) * kLanes, 3 * kLanes, kLanes};
      },
      values);
}

}  // namespace

LinearTetrahedron::DofMatrix lane_matrix(const double* matrices, int lane) {
  constexpr int kPlace[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  const auto number = [&](int i) { return matrices[i * kBatchLanes + lane]; };
  LinearTetrahedron::DofMatrix matrix;
  int pair = 0;
  for (int a = 0; a < 4; ++a) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) matrix(3 * a + i, 3 * a + j) = number(6 * a + kPlace[i][j]);
    }
    for (int c = a + 1; c < 4; ++c, ++pair) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          matrix(3 * a + i, 3 * c + j) = matrix(3 * c + j, 3 * a + i) =
              number(24 + 9 * pair + 3 * i + j);
        }
      }
    }
  }
  return matrix;
}

ElementMatrix quadratic_stiffness(const double* matrices, int lane) {
  ElementMatrix sum = ElementMatrix::Zero(3 * QuadraticPoints::kNodes, 3 * QuadraticPoints::kNodes);
  for (int p = 0; p < QuadraticPoints::kPoints; ++p) {
    add_point_matrix(p, lane_matrix(matrices, lane + p), sum);
  }
  return sum;
}

void add_block_stiffness(const ElementBlocks& blocks, const ElementBlocks::Block& block,
                         TangentForm form, const double* state, const SparsityPattern& pattern,
                         double* values) {
  alignas(64) double matrices[std::size_t{kStiffnessNumbers} * kBatchLanes];
  const Index numbers = Index{tangent_numbers(form)} * kBatchLanes;
  for (Index batch = 0; batch < block.batch_count; ++batch) {
    tangent_stiffness(form, state + batch * numbers, matrices);
    for (int lane = 0; lane < kBatchLanes; lane += blocks.points_per_element()) {
      const Index i = blocks.point(block.first_batch + batch, lane);
      if (i < 0) continue;
      const Index e = i / blocks.points_per_element();
      if (blocks.is_quadratic()) {
        pattern.scatter(e, quadratic_stiffness(matrices, lane), values);
      } else if (const auto entries = pattern.element_entries(e)) {
        scatter_numbers(pattern, *entries, matrices + lane, values);
      } else {
        pattern.scatter(e, lane_matrix(matrices, lane), values);
      }
    }
  }
}

}  // namespace tetraction
