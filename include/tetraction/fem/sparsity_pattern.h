// The fixed sparsity pattern of the assembled Hessian: built once, then every element knows where
// its entries go.
#pragma once

#include <array>
#include <vector>

#include "tetraction/fem/dof_constraints.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// Lower triangle of a symmetric matrix over the free DOFs, compressed by columns with ascending
/// rows: what CHOLMOD takes with stype = −1.
class SparsityPattern {
 public:
  using Shape = RestState::Shape;

  SparsityPattern(const RestState& rest, const DofConstraints& constraints);

  /// Number of rows and columns: the free DOFs.
  Index size() const { return static_cast<Index>(column_begin_.size()) - 1; }
  Index nonzeros() const { return static_cast<Index>(row_.size()); }
  /// size() + 1 offsets into rows().
  const std::vector<int>& column_begin() const { return column_begin_; }
  const std::vector<int>& rows() const { return row_; }

  /// Adds the symmetric element matrix of element e to `values` (nonzeros() numbers); entries of
  /// fixed DOFs are left out.
  void scatter(Index e, const Shape::DofMatrix& local, double* values) const;
  /// Adds a full-length diagonal (one number per DOF); fixed DOFs are left out.
  void add_diagonal(const Vector& diagonal, double* values) const;

  /// Elements by colour: no two of a colour share a vertex, so a colour's elements can be scattered
  /// at once; colours come one after the other, so sums do not depend on the number of threads.
  const std::vector<std::vector<Index>>& colors() const { return colors_; }

 private:
  static constexpr int kEntries = Shape::kDofs * (Shape::kDofs + 1) / 2;

  int find(int row, int column) const;

  std::vector<int> column_begin_;
  std::vector<int> row_;
  std::vector<std::array<int, kEntries>> slots_;  // −1: a fixed DOF takes part
  std::vector<int> diagonal_slot_;                // per DOF, −1 if fixed
  std::vector<std::vector<Index>> colors_;
};

}  // namespace tetraction
