#include "inversion_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace tetraction {
namespace {

bool is_defined_inside_out(const MaterialField& material) {
  // A law that depends on the place may be somewhere.
  const auto* custom = std::get_if<CustomMaterial>(&material.model());
  if (custom != nullptr && custom->has_places()) return true;
  const Matrix3 mirrored = Vector3(-1.0, 1.0, 1.0).asDiagonal();
  return std::visit([&](const auto& m) { return m.admissible(mirrored); }, material.model());
}
bool law_is_defined_inside_out(const MaterialSettings& material) {
  if (material.custom) return is_defined_inside_out(MaterialField(*material.custom));
  return std::ranges::any_of(material_choices(), [&](const MaterialChoice& choice) {
    return choice.name == material.model && choice.defined_for_any_jacobian;
  });
}

}  // namespace

void InversionWatch::renew(const MechanicalSystem& system) {
  counter_.reset();
  if (std::ranges::any_of(system.elastic().materials(), is_defined_inside_out)) {
    counter_ = std::make_unique<InversionCounter>(system.elastic());
  }
}

void InversionWatch::update(RunData& run, const double* energy_after_step) {
  RunProgress& progress = run.progress;
  const MechanicalSystem& system = *run.system;
  const TimeSettings& time = run.settings.time;
  InvertedElements& inverted = progress.inverted;
  if (energy_after_step == nullptr) renew(system);
  if (!counter_) {
    inverted.now = 0;
    return;
  }
  const bool is_one_step = time.adapt == StepAdaptation::kNone && time.retry == 0;
  const bool is_small_step = energy_after_step != nullptr && inverted.now == 0 && is_one_step &&
                             !is_implicit(time.integrator) && system.part() == nullptr;
  inverted.now = is_small_step
                     ? counter_->count_after_step(run.states.other().position, run.state().position,
                                                  *energy_after_step)
                     : counter_->count(run.state().position);
  const bool is_here = inverted.now > 0;
  inverted.now =
      static_cast<Index>(sum_over_parts(system.part(), static_cast<double>(inverted.now)));
  if (inverted.now > inverted.most) {
    inverted.most = inverted.now;
    inverted.most_step = run.state().step;
  }
  if (inverted.now == 0 || inverted.first >= 0) return;
  inverted.first = static_cast<std::int64_t>(
      least_of_parts(system.part(), is_here ? static_cast<double>(system.mesh().tetrahedron_id(
                                                  counter_->first(run.state().position)))
                                            : std::numeric_limits<double>::infinity()));
  inverted.first_time = run.state().time;
  progress.warnings.push_back(fmt::format(
      "element {} is turned inside out (J < 0) at t = {:.6g} s, which its material does not "
      "resist: from there on the result is no deformation of a body. history.csv counts such "
      "elements. Take neo-hookean, a smaller time.step or a finer mesh, or check the loads.",
      inverted.first, inverted.first_time));
}

bool may_invert(const Scene& scene, const MechanicalSystem& system) {
  if (std::ranges::any_of(system.elastic().materials(), is_defined_inside_out)) return true;
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetMaterial>(&edit);
      if (change != nullptr && law_is_defined_inside_out(change->material)) return true;
    }
  }
  return false;
}

}  // namespace tetraction
