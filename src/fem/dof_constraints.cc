#include "tetraction/fem/dof_constraints.h"

#include <limits>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {

DofConstraints::DofConstraints(Index dof_count)
    : DofConstraints(std::vector<std::uint8_t>(static_cast<std::size_t>(dof_count), 0)) {}

DofConstraints::DofConstraints(std::vector<std::uint8_t> fixed)
    : fixed_(std::move(fixed)), reduced_(fixed_.size(), -1) {
  if (fixed_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw InputError("The mesh has more than 2^31 degrees of freedom: that is not supported.");
  }
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    if (fixed_[i] != 0) {
      fixed_dofs_.push_back(static_cast<Index>(i));
    } else {
      reduced_[i] = static_cast<int>(free_count_++);
    }
  }
}

Vector DofConstraints::restrict_to_free(const Vector& full) const {
  Vector free(free_count_);
  for (Index i = 0; i < dof_count(); ++i) {
    if (!is_fixed(i)) free[reduced(i)] = full[i];
  }
  return free;
}

Vector DofConstraints::extend_by_zero(const Vector& free) const {
  Vector full = Vector::Zero(dof_count());
  for (Index i = 0; i < dof_count(); ++i) {
    if (!is_fixed(i)) full[i] = free[reduced(i)];
  }
  return full;
}

void DofConstraints::set_fixed_to_zero(Vector& full) const {
  for (const Index i : fixed_dofs_) full[i] = 0.0;
}

}  // namespace tetraction
