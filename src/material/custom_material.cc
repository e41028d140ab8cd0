#include "tetraction/material/custom_material.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "material_parameters.h"
#include "tetraction/core/error.h"

namespace tetraction {

CustomMaterial::CustomMaterial(std::shared_ptr<const Base> model) : model_(std::move(model)) {
  if (name().empty()) throw InputError("A custom material needs a name for messages and reports.");
  check_lame(name().c_str(), model_->initial.mu, model_->initial.lambda);
  if (has_places()) return;
  const Matrix3 rest = Matrix3::Identity();
  const bool is_defined = admissible(rest);
  if (is_defined) energy_at_rest_ = model_->energy_density(rest, nullptr);
  if (!is_defined || !std::isfinite(energy_at_rest_)) {
    throw InputError(
        fmt::format("{}: the energy density is not defined at rest, F = I: a body could not even "
                    "begin. Look at admissible() and energy_density().",
                    name()));
  }
}

void CustomMaterial::evaluate(const MaterialValues& values) const {
  model_->evaluate(values);
  if (!has_places()) {
    for (double& energy : values.energy) energy -= energy_at_rest_;
    return;
  }
  if (values.energy.empty()) return;
  const std::vector<Matrix3> rest(values.f.size(), Matrix3::Identity());
  std::vector<char> admissible(rest.size(), 0);
  std::vector<double> at_rest(rest.size(), 0.0);
  model_->evaluate({rest, admissible, at_rest, {}, {}, values.places});
  for (std::size_t k = 0; k < rest.size(); ++k) values.energy[k] -= at_rest[k];
}

void CustomMaterial::Base::refuse_without_place() const {
  throw InputError(
      fmt::format("{}: the law is not the same everywhere, and a function without a place was "
                  "called. Call at() with the element and its rest position.",
                  name));
}

}  // namespace tetraction
