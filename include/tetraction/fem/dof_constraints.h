// Which degrees of freedom are prescribed. They are eliminated: the minimiser sees the free ones
// only, and the assembly leaves the others out while it scatters (deal.II's AffineConstraints).
#pragma once

#include <cstdint>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Fixed DOFs and the numbering of the free ones.
class DofConstraints {
 public:
  /// All free.
  explicit DofConstraints(Index dof_count);
  /// `fixed[i]` tells whether DOF i is prescribed.
  explicit DofConstraints(std::vector<std::uint8_t> fixed);

  Index dof_count() const { return static_cast<Index>(fixed_.size()); }
  Index free_count() const { return free_count_; }
  bool is_fixed(Index dof) const { return fixed_[static_cast<std::size_t>(dof)] != 0; }
  /// Number of the DOF among the free ones, or −1 if it is fixed.
  int reduced(Index dof) const { return reduced_[static_cast<std::size_t>(dof)]; }
  /// The fixed DOFs, ascending.
  const std::vector<Index>& fixed_dofs() const { return fixed_dofs_; }

  /// The free entries of a full vector.
  Vector restrict_to_free(const Vector& full) const;
  /// A full vector with the free entries given and zero elsewhere.
  Vector extend_by_zero(const Vector& free) const;
  /// Sets the fixed entries of a full vector to zero.
  void set_fixed_to_zero(Vector& full) const;

 private:
  std::vector<std::uint8_t> fixed_;
  std::vector<int> reduced_;
  std::vector<Index> fixed_dofs_;
  Index free_count_ = 0;
};

}  // namespace tetraction
