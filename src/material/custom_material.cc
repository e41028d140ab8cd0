#include "tetraction/material/custom_material.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "material_parameters.h"
#include "tetraction/core/error.h"

namespace tetraction {

CustomMaterial::CustomMaterial(std::shared_ptr<const Base> model) : model_(std::move(model)) {
  if (name().empty()) throw InputError("A custom material needs a name for messages and reports.");
  check_lame(name().c_str(), model_->initial.mu, model_->initial.lambda);
  const Matrix3 rest = Matrix3::Identity();
  if (model_->admissible(rest)) energy_at_rest_ = model_->energy_density(rest);
  if (!model_->admissible(rest) || !std::isfinite(energy_at_rest_)) {
    throw InputError(
        fmt::format("{}: the energy density is not defined at rest, F = I: a body could not even "
                    "begin. Look at admissible() and energy_density().",
                    name()));
  }
}

}  // namespace tetraction
