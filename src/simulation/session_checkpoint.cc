// Checkpoints of a session: everything that its run needs to go on, bit by bit.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session_impl.h"
#include "system_settings.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// FNV-1a, 64 bits.
class Fingerprint {
 public:
  void add(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte, value >>= 8) {
      value_ = (value_ ^ (value & 0xff)) * 0x100000001b3ULL;
    }
  }
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  void add(const std::string& text) {
    for (const char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
    add(static_cast<std::uint64_t>(text.size()));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

BodyIdentity make_identity(const MechanicalSystem& system) {
  Fingerprint mesh;
  Fingerprint regions;
  const Vector rest = system.mesh().rest_positions();
  mesh.add(static_cast<std::uint64_t>(rest.size()));
  for (const double x : rest) mesh.add(x);
  for (const auto& [name, values] : system.mesh().cell_arrays) {  // materials may refer to them
    mesh.add(name);
    for (const double x : values.reshaped()) mesh.add(x);
  }
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    for (const Index v : system.rest().nodes(e)) mesh.add(static_cast<std::uint64_t>(v));
    regions.add(static_cast<std::uint64_t>(system.region(e)));
  }
  Fingerprint densities;
  for (Index e = 0; e < system.rest().element_count(); ++e) densities.add(system.density(e));
  Fingerprint terms;
  for (const ForceTerm* term : system.force_terms()) terms.add(term->name());
  return {mesh.value(), regions.value(), densities.value(), terms.value()};
}

// The parts of the identities that differ, as in "the mesh and the densities".
std::string difference(const BodyIdentity& a, const BodyIdentity& b) {
  std::vector<std::string> parts;
  if (a.mesh != b.mesh) parts.emplace_back("the mesh");
  // The regions of another mesh always differ, too.
  if (a.mesh == b.mesh && a.regions != b.regions) parts.emplace_back("the regions of material");
  if (a.densities != b.densities) parts.emplace_back("the densities");
  if (a.force_terms != b.force_terms) parts.emplace_back("the names of the force terms");
  std::string text = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    text += (i + 1 < parts.size() ? ", " : " and ") + parts[i];
  }
  return text;
}

}  // namespace

const BodyIdentity& Session::Impl::identity() {
  if (!body) body = make_identity(*system);
  return *body;
}

void Session::Impl::require_own(const Checkpoint& checkpoint) {
  if (checkpoint.body != identity()) {
    throw InputError(fmt::format(
        "The checkpoint belongs to another body: it differs in {} (the checkpoint has {} "
        "vertices and {} regions, this session {} and {}).",
        difference(checkpoint.body, identity()), checkpoint.state.position.size() / 3,
        checkpoint.settings.materials.size(), system->vertex_count(), system->region_count()));
  }
  const Index dofs = system->dof_count();
  const State& state = checkpoint.state;
  if (state.position.size() != dofs || state.velocity.size() != dofs ||
      state.momentum.size() != dofs || checkpoint.reaction_force.size() != dofs ||
      static_cast<Index>(checkpoint.settings.materials.size()) != system->region_count()) {
    throw InputError(fmt::format(
        "The checkpoint is not complete: a vector or the list of materials has not the size that a "
        "body of {} vertices and {} regions needs.",
        system->vertex_count(), system->region_count()));
  }
  // Edits add forces, fixes and constraints, and remove none: a run never has fewer than its scene.
  const BodyConstraints& constraints = checkpoint.settings.constraints;
  const auto require = [](const std::string& what, std::size_t has, std::size_t scene_has) {
    if (has >= scene_has) return;
    throw InputError(
        fmt::format("The checkpoint belongs to another scene: it has {} {}, and this scene has {}.",
                    has, what, scene_has));
  };
  require("[[fix]]", constraints.fixes.size(), scene.fix.size());
  require("[[constraint]]", constraints.others.size(), scene.constraint.size());
  for (const LoadKind kind : load_kinds()) {
    require(fmt::format("[[{}]]", to_string(kind)), checkpoint.settings.loads.list(kind).size(),
            scene.list(kind).size());
  }
  if (checkpoint.progress.next_event > scene.event.size()) {
    throw InputError(
        fmt::format("The checkpoint belongs to another scene: {} of its events were made, and this "
                    "scene has {}.",
                    checkpoint.progress.next_event, scene.event.size()));
  }
  if (!state.position.allFinite() || !state.momentum.allFinite() || !std::isfinite(state.time)) {
    throw InputError("The state of the checkpoint is not finite.");
  }
}

Checkpoint Session::checkpoint() {
  Impl& s = *impl_;
  s.require_motion("checkpoints");
  s.renew_stepper();
  return {s.identity(),
          s.settings,
          s.progress,
          s.state(),
          s.balance->sums(),
          s.stepper->reaction_force(),
          s.stepper->configuration_force()};
}

void Session::restore(const Checkpoint& checkpoint) {
  Impl& s = *impl_;
  s.require_motion("checkpoints");
  s.require_own(checkpoint);
  // Copies, so that nothing can fail any more once the session changes. The system is changed in
  // place and put back if something fails.
  Checkpoint own = checkpoint;
  SystemSettings old_system(*s.system);
  std::optional<Constraints> old_constraints;
  std::unique_ptr<Stepper> stepper;
  const TimeSettings& time = own.settings.time;
  try {
    SystemSettings(own.settings, *s.system, s.scene.amplitude).put_in(*s.system);
    old_constraints = s.system->set_constraints(
        Constraints(own.settings.constraints.list(), s.system->mesh(), s.system->mass()));
    stepper = make_stepper(time.integrator, own.settings.solver, *s.system);
    stepper->set_reactions(own.reaction_force, own.configuration_force);
    s.inversion_counter = s.make_inversion_counter();
  } catch (...) {
    if (old_constraints) s.system->set_constraints(std::move(*old_constraints));
    old_system.put_in(*s.system);
    throw;
  }
  s.settings = std::move(own.settings);
  s.shared = shared_distances(s.settings.constraints.others);
  s.progress = std::move(own.progress);
  s.balance->restore(std::move(own.balance));
  s.states.set(own.state);
  s.stepper = std::move(stepper);
  s.whole_stepper.reset();
  s.tracker.reset();
  s.failed_step.reset();
  if (s.keeps_good_states) s.keep_state();
}

}  // namespace tetraction
