// Checkpoints of a session: everything that its run needs to go on, bit by bit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/fingerprint.h"
#include "session_impl.h"
#include "simulation/scene/body_loads.h"
#include "simulation/scene/body_obstacles.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

// Made from the vertices and value(e) of each tetrahedron e of the whole body. It is the sum of one number for
// each of them, so that each part can add up those of its own.
template <class ValueOf>
std::uint64_t sum_over_elements(const MechanicalSystem& system, const ValueOf& value) {
  const MeshPart* part = system.part();
  std::uint64_t sum = 0;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    Fingerprint element;
    for (const Index v : system.mesh().tetrahedra[static_cast<std::size_t>(e)]) {
      const Index number = part == nullptr ? v : part->vertex_numbers[static_cast<std::size_t>(v)];
      element.add(static_cast<std::uint64_t>(number));
    }
    element.add(value(e));
    sum += element.value();
  }
  if (part == nullptr) return sum;
  // Parts add floating-point numbers, which have to be exact.
  constexpr int kBits = 16;
  std::array<double, 64 / kBits> digits{};
  for (std::size_t i = 0; i < digits.size(); ++i) {
    digits[i] = static_cast<double>((sum >> (kBits * i)) & ((1U << kBits) - 1));
  }
  part->sum(digits.data(), static_cast<Index>(digits.size()));
  sum = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    sum += static_cast<std::uint64_t>(digits[i]) << (kBits * i);
  }
  return sum;
}

BodyIdentity make_identity(const MechanicalSystem& system) {
  Fingerprint terms;
  for (const ForceTerm* term : system.force_terms()) terms.add(term->name());
  const auto region = [&](Index e) { return static_cast<std::uint64_t>(system.region(e)); };
  const auto density = [&](Index e) { return system.density(e); };
  return {fingerprints_of(system.mesh()).body, sum_over_elements(system, region),
          sum_over_elements(system, density), terms.value()};
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

// Throws InputError if the checkpoint does not belong to this body and scene.
void require_own(const Checkpoint& checkpoint, const RunData& run, const BodyIdentity& body) {
  const MechanicalSystem& system = *run.system;
  const Scene& scene = run.scene;
  if (checkpoint.body != body) {
    throw InputError(fmt::format(
        "The checkpoint belongs to another body: it differs in {} (the checkpoint has {} "
        "vertices and {} regions, this session {} and {}).",
        difference(checkpoint.body, body), checkpoint.state.position.size() / 3,
        checkpoint.settings.materials.size(), system.vertex_count(), system.region_count()));
  }
  const Index dofs = system.dof_count();
  const State& state = checkpoint.state;
  // An obstacle that was taken back has been in this run.
  const std::size_t obstacles =
      std::max(checkpoint.settings.obstacles.size(), run.progress.obstacle_forces.size());
  if (state.position.size() != dofs || state.velocity.size() != dofs ||
      state.momentum.size() != dofs || checkpoint.reactions.force.size() != dofs ||
      checkpoint.reactions.delay.size() != dofs ||
      (checkpoint.progress.external_force.size() != 0 &&
       checkpoint.progress.external_force.size() != dofs) ||
      checkpoint.progress.obstacle_forces.size() > obstacles ||
      static_cast<Index>(checkpoint.settings.materials.size()) != system.region_count()) {
    throw InputError(fmt::format(
        "The checkpoint is not complete: a vector or the list of materials has not the size that a "
        "body of {} vertices, {} regions and {} obstacles needs.",
        system.vertex_count(), system.region_count(), obstacles));
  }
  // Edits add forces, fixes, constraints and obstacles, and remove none: a run never has fewer than its scene.
  const BodyConstraints& constraints = checkpoint.settings.constraints;
  const auto require = [](const std::string& what, std::size_t has, std::size_t scene_has) {
    if (has >= scene_has) return;
    throw InputError(
        fmt::format("The checkpoint belongs to another scene: it has {} {}, and this scene has {}.",
                    has, what, scene_has));
  };
  require("[[fix]]", constraints.fixes.size(), scene.fix.size());
  require("[[constraint]]", constraints.others.size(), scene.constraint.size());
  require("[[obstacle]]", checkpoint.settings.obstacles.size(), scene.obstacle.size());
  for (const LoadKind kind : values_of<LoadKind>()) {
    require(fmt::format("[[{}]]", to_string(kind)), checkpoint.settings.loads.list(kind).size(),
            scene.list(kind).size());
  }
  if (checkpoint.progress.next_event > scene.event.size()) {
    throw InputError(
        fmt::format("The checkpoint belongs to another scene: {} of its events were made, and this "
                    "scene has {}.",
                    checkpoint.progress.next_event, scene.event.size()));
  }
  // Energies are summed by their places.
  const auto has_own_energies = [&](const Energies& energies) {
    return std::ranges::equal(energies.entries(), run.balance->sums().energies.entries(), {},
                              &Energies::Entry::name, &Energies::Entry::name);
  };
  if (!has_own_energies(checkpoint.balance.initial_energies) ||
      !has_own_energies(checkpoint.balance.energies)) {
    throw InputError(
        "The checkpoint belongs to another scene: it has other energies than this session.");
  }
  const bool is_finite = state.position.allFinite() && state.momentum.allFinite();
  if (!everywhere(system.part(), is_finite) || !std::isfinite(state.time)) {
    throw InputError("The state of the checkpoint is not finite.");
  }
}

// The materials and loads of a system, which edits may replace.
struct MaterialsAndLoads {
  std::vector<MaterialField> materials;
  BodyLoads loads;

  // Sets them in a system with as many regions.
  void put_in(MechanicalSystem& system) {
    for (std::size_t i = 0; i < materials.size(); ++i) {
      system.set_material(static_cast<Index>(i), materials[i]);
    }
    system.set_forces(std::move(loads.forces));
    system.set_pressures(std::move(loads.pressures));
  }
};

// Throws InputError.
MaterialsAndLoads make_materials_and_loads(const RunSettings& settings,
                                           const MechanicalSystem& system,
                                           const AmplitudeList& amplitudes) {
  MaterialsAndLoads made{{}, make_loads(settings.loads, system, amplitudes)};
  for (std::size_t i = 0; i < settings.materials.size(); ++i) {
    made.materials.push_back(make_material(settings.materials[i], system, static_cast<Index>(i)));
  }
  return made;
}

}  // namespace

const BodyIdentity& Session::Impl::identity() {
  if (!body) body = make_identity(*run.system);
  return *body;
}

Checkpoint Session::checkpoint() {
  Impl& s = *impl_;
  s.require_motion("checkpoints");
  // An explicit step without equations of constraints remembers only the force at the present
  // positions, which a new stepper computes with the same bits.
  const bool remembers = is_implicit(s.run.settings.time.integrator) ||
                         adapts(s.run.settings.time) || s.run.settings.time.retry > 0 ||
                         s.run.system->constraints().has_equations();
  if (remembers) {
    renew_stepper(s.run);
  } else {
    s.run.memory.tracker.reset();
    s.run.memory.impact = {};
  }
  // The modes are vectors over the free coordinates of a part, which another number of parts could not use.
  if (s.run.system->part() != nullptr) s.run.progress.plan.automatic.modes = {};
  return {s.identity(),  s.run.settings,        s.run.progress,
          s.run.state(), s.run.balance->sums(), s.run.reactions};
}

void Session::restore(const Checkpoint& checkpoint) {
  Impl& s = *impl_;
  s.require_motion("checkpoints");
  require_own(checkpoint, s.run, s.identity());
  // Copies, so that nothing can fail any more once the session changes. The system is changed in
  // place and put back if something fails.
  Checkpoint own = checkpoint;
  MaterialsAndLoads old{s.run.system->materials(),
                        {s.run.system->forces(), s.run.system->pressures()}};
  std::optional<Constraints> old_constraints;
  std::shared_ptr<const Contact> old_contact;
  std::unique_ptr<Stepper> stepper;
  const TimeSettings& time = own.settings.time;
  try {
    if (const Contact* present = s.run.system->contact(); present != nullptr) {
      old_contact = s.run.system->set_contact(
          make_contact(own.settings.obstacles, s.run.scene.amplitude, *s.run.system, present));
    }
    make_materials_and_loads(own.settings, *s.run.system, s.run.scene.amplitude)
        .put_in(*s.run.system);
    put_sections(own.settings, *s.run.system, s.run.scene.amplitude);
    old_constraints = s.run.system->set_constraints(
        Constraints(own.settings.constraints.list(), s.run.system->mesh(), s.run.system->mass()));
    const Index forces = own.reactions.configuration_force.size();
    if (forces != 0 && forces != s.run.system->constraints().configuration_size()) {
      throw InputError("The checkpoint is not complete: forces of its constraints are missing.");
    }
    stepper = make_stepper(time.integrator, own.settings.solver, *s.run.system);
    s.inversions.renew(*s.run.system);
  } catch (...) {
    if (old_constraints) s.run.system->set_constraints(std::move(*old_constraints));
    if (old_contact) s.run.system->set_contact(std::move(old_contact));
    old.put_in(*s.run.system);
    put_sections(s.run.settings, *s.run.system, s.run.scene.amplitude);
    throw;
  }
  s.run.settings = std::move(own.settings);
  s.shared = shared_distances(s.run.settings.constraints.others);
  s.run.progress = std::move(own.progress);
  // An obstacle that came after the last step has had no force yet, and one that was taken back has none.
  s.run.progress.obstacle_forces.resize(s.run.settings.obstacles.size());
  s.run.balance->restore(std::move(own.balance));
  s.run.states.set(own.state);
  s.run.memory = {std::move(stepper), nullptr, nullptr, {}};
  s.run.reactions = std::move(own.reactions);
  s.strategy = make_step_strategy(s.run);
  s.failed_step.reset();
  if (s.keeps_good_states) s.keep_state();
}

}  // namespace tetraction
