// Checkpoints of a session: everything that its run needs to go on, bit by bit.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

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

std::uint64_t fingerprint(const MechanicalSystem& system) {
  Fingerprint print;
  const Vector rest = system.mesh().rest_positions();
  print.add(static_cast<std::uint64_t>(rest.size()));
  for (const double x : rest) print.add(x);
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    for (const Index v : system.rest().nodes(e)) print.add(static_cast<std::uint64_t>(v));
    print.add(static_cast<std::uint64_t>(system.region(e)));
  }
  for (Index r = 0; r < system.region_count(); ++r) print.add(system.density(r));
  for (const ForceTerm* term : system.force_terms()) print.add(term->name());
  return print.value();
}

}  // namespace

void Session::Impl::require_own(const Checkpoint& checkpoint) const {
  const Index dofs = system->dof_count();
  const State& state = checkpoint.state;
  if (checkpoint.body != body || state.position.size() != dofs || state.velocity.size() != dofs ||
      state.momentum.size() != dofs || checkpoint.reaction_force.size() != dofs) {
    throw InputError(fmt::format(
        "The checkpoint belongs to another body: it has {} vertices, and this one has {}; mesh, "
        "regions, densities and force terms must be the same.",
        state.position.size() / 3, system->vertex_count()));
  }
  if (static_cast<Index>(checkpoint.settings.materials.size()) != system->region_count()) {
    throw InputError(fmt::format("The checkpoint has {} materials, and the body has {} regions.",
                                 checkpoint.settings.materials.size(), system->region_count()));
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
  if (s.body == 0) s.body = fingerprint(*s.system);
  s.renew_stepper();
  return {s.body,
          s.settings,
          s.progress,
          s.state(),
          s.balance->sums(),
          s.stepper->reaction_force(),
          s.stepper->configuration_force()};
}

void Session::restore(const Checkpoint& checkpoint) {
  Impl& s = *impl_;
  if (s.body == 0) s.body = fingerprint(*s.system);
  s.require_own(checkpoint);
  // Copies, so that nothing can fail any more once the session changes. The system is changed in
  // place and put back if something fails.
  Checkpoint own = checkpoint;
  SystemSettings old_system(*s.system);
  std::optional<Constraints> old_constraints;
  std::unique_ptr<Stepper> stepper;
  const TimeSettings& time = own.settings.time;
  try {
    SystemSettings(own.settings, s.system->mesh()).put_in(*s.system);
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
  s.progress = std::move(own.progress);
  s.balance->restore(std::move(own.balance));
  s.states.set(own.state);
  s.stepper = std::move(stepper);
  s.tracker.reset();
  if (s.keeps_good_states) s.keep_state();
}

}  // namespace tetraction
