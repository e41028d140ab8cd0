// The matrix of the coarse level of a two-level preconditioner, and its solution.
#pragma once

#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "sparse_cholesky.h"
#include "tetraction/core/types.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

/// A symmetric positive definite matrix of 6 × 6 blocks, one row and column of blocks for each group of
/// vertices (coarse_space.h).
///
/// For a body in parts (mesh/mesh_part.h) every process adds what its own elements and vertices contribute. A
/// group with vertices that other parts have, too, belongs to the *interface*; all other groups are *inner*
/// ones of their part (I), to which the other parts contribute nothing. So each process eliminates its inner groups,
///
///     S = Σ over parts of (A_BB − A_BI A_II⁻¹ A_IB),
///
/// and every process has the sum S of all interface groups (B) and its factor. In a solution each process
/// computes its inner groups, all of them together those of the interface (substructuring; Smith, Bjørstad &
/// Gropp 1996, ch. 4). The work on inner groups and the memory for them are thus divided between the processes.
/// With A_II = RᵀR and W = R⁻ᵀ A_IB, S is the sum of A_BB − WᵀW, and W is kept for the solutions.
///
/// Without parts there is no interface.
class CoarseMatrix {
 public:
  using Block = Eigen::Matrix<double, 6, 6>;
  using Motion = Eigen::Matrix<double, 6, 1>;
  using GroupPair = std::pair<std::int32_t, std::int32_t>;

  /// `interface_numbers`: the number in the interface of each group of this part, −1 for inner ones. The first `own_groups` groups are the part's own,
  /// the others, all of the interface, are those of other parts that elements of this part have vertices of.
  /// `pairs`: the pairs (i, j), i < j, of groups that an element of this part has vertices of, in any order. Collective.
  CoarseMatrix(const MeshPart* part, Index own_groups,
               const std::vector<std::int32_t>& interface_numbers,
               const std::vector<GroupPair>& pairs);
  CoarseMatrix(const CoarseMatrix&) = delete;
  CoarseMatrix& operator=(const CoarseMatrix&) = delete;

  void set_zero();
  /// Whether the pattern has a block in the row and column of two groups.
  bool has(Index row, Index column) const;
  /// Adds a block and, if row ≠ column, its transpose on the other side of the diagonal.
  void add(Index row, Index column, const Block& block);
  /// Makes the factor, after the last add(). The diagonal is increased by the part `shift` of itself. Where it is
  /// zero, because a group has no such motion, the motion will be zero. Returns false if the matrix is not positive
  /// definite, the same on all processes. Collective.
  bool factorize(double shift);
  /// For every group, x ← A⁻¹ right. `motions`: the right-hand side of own groups; afterwards the solution of all
  /// groups of this part. Returns x · right over the whole body. Collective.
  double solve(std::vector<Motion>& motions);

 private:
  // A symmetric matrix in compressed columns.
  struct Sparse {
    std::vector<int> column_begin;
    std::vector<int> rows;
    std::vector<double> values;
    std::unique_ptr<SparseCholesky> cholesky;

    /// rows_of_column[j]: ascending block rows i ≥ j.
    void make_pattern(const std::vector<std::vector<std::int32_t>>& rows_of_column);
    Index size() const { return static_cast<Index>(column_begin.size()) - 1; }
    Eigen::Map<Motion> column(Index block_column, int j, std::size_t place) {
      return Eigen::Map<Motion>(values.data() +
                                column_begin[static_cast<std::size_t>(6 * block_column + j)] +
                                6 * static_cast<Index>(place));
    }
    void prepare_diagonal(double shift);
    bool factorize() { return cholesky->factorize(values); }
  };
  // A block of A_IB.
  struct Coupling {
    std::int32_t inner;
    std::int32_t boundary;  // number among those that this part touches
    Block block;
    auto key() const { return std::tuple(inner, boundary); }
  };

  bool is_inner(Index group) const { return boundary_of_[static_cast<std::size_t>(group)] < 0; }
  void make_interface(const std::vector<std::int32_t>& interface_numbers);
  void make_coupling_root();
  bool add_complements(double shift);
  double solve_interface(std::vector<Motion>& motions, double product, Vector& y);
  std::vector<Coupling>::const_iterator find_coupling(Index row, Index column) const;

  const MeshPart* part_;
  Index own_groups_;
  std::vector<std::int32_t> inner_of_;  // of each group; −1 on the interface
  std::vector<std::int32_t>
      boundary_of_;  // of each group, among those of the part; −1 for inner ones
  std::vector<std::int32_t> inner_groups_;
  std::vector<std::int32_t> boundary_groups_;  // by ascending interface numbers
  std::vector<std::int32_t> interface_;        // the interface numbers of those
  std::vector<std::vector<std::int32_t>> inner_rows_;
  Sparse inner_;                     // A_II
  std::vector<Coupling> couplings_;  // by inner and boundary numbers
  std::vector<Index> root_rows_;     // the rows of W that are not zero …
  Matrix root_;                      // … and W without the others
  Matrix boundary_;                  // A_BB of this part, lower triangle
  std::vector<std::vector<std::int32_t>> complement_rows_;
  Sparse complement_;  // S, of all parts
  Vector shared_;
};

}  // namespace tetraction
