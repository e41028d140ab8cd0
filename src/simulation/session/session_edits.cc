#include "session_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "mesh/shared_error.h"
#include "run_warnings.h"
#include "simulation/facts/obstacle_checks.h"
#include "simulation/scene/body_loads.h"
#include "simulation/scene/body_obstacles.h"
#include "simulation/scene/initial_state.h"
#include "simulation/scene/setting_keys.h"
#include "simulation/stepping/limit_estimates.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/fem/step_length.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

constexpr const char* kNoSuch = "{} number {} does not exist: there are {}, counted from 0.";

template <class List>
void require_index(const List& list, std::size_t index, const char* what) {
  if (index >= list.size()) {
    throw InputError(fmt::format(kNoSuch, what, index, list.size()));
  }
}

// The parts of the session that must be made again after an edit.
struct Renewal {
  bool stepper = false;  // integrator, solver or constraints have changed
  bool constraints = false;
  bool step = false;   // step or end have changed
  bool limit = false;  // the stability limit may have changed
};

// Puts back what an edit has changed. Only this is remembered: copies of all settings would make each of many edits
// more expensive than the one before.
class Undo {
 public:
  void add(std::function<void()> step) { steps_.push_back(std::move(step)); }
  // Keeps a value of the settings that is about to change.
  template <class Value>
  void keep(Value& value) {
    add([&value, old = value] { value = old; });
  }
  template <class List>
  void keep_entry(List& list, std::size_t index) {
    add([&list, index, old = list[index]] { list[index] = old; });
  }
  template <class List>
  void remove_last(List& list) {
    add([&list] { list.pop_back(); });
  }
  void undo() {
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) (*step)();
    steps_.clear();
  }

 private:
  std::vector<std::function<void()>> steps_;
};

// Whether a law may be undefined where the present one is defined. The domain of a law that does not limit the
// stretch is the same for all parameters.
bool may_be_undefined(const MaterialModel& next, const MaterialModel& present) {
  return next.index() != present.index() || std::visit(
                                                []<class M>(const M&) {
                                                  return HasStretchLimit<M> ||
                                                         std::is_same_v<M, CustomMaterial>;
                                                },
                                                next);
}

// Changes the settings, the system and a copy of the state. apply_edit() puts the first two
// back with `undo` if the edit cannot be made.
struct Editor {
  MechanicalSystem& system;
  RunSettings& settings;
  State& state;
  const AmplitudeList& amplitudes;
  Undo& undo;
  BodyConstraints& constraints = settings.constraints;
  Renewal renewal{};
  std::string warning{};

  void operator()(const SetMaterial& edit) {
    if (edit.region < 0 || edit.region >= system.region_count()) {
      throw InputError(fmt::format(kNoSuch, "material region", edit.region, system.region_count()));
    }
    const MaterialSettings& now = settings.materials[static_cast<std::size_t>(edit.region)];
    if (density_array(edit.material) != density_array(now)) {
      throw InputError(
          "The density cannot be changed during a run: mass would appear from nowhere, and "
          "momentum and energy with it. Change it before the start.");
    }
    const double density = now.density;
    if (edit.material.density != density) {
      throw InputError(fmt::format(
          "The density cannot be changed during a run ({} to {} kg/m3): mass would appear from "
          "nowhere, and momentum and energy with it. Change it before the start.",
          density, edit.material.density));
    }
    const bool built_in = all_built_in();
    const bool locked = !locking_warning(system).empty();
    const bool unstable = !instability_warning(system).empty();
    MaterialField made = make_material(edit.material, system, edit.region);
    const auto region = static_cast<std::size_t>(edit.region);
    const bool may_be_refused =
        may_be_undefined(made.model(), system.materials()[region].model()) &&
        system.elastic().admissible(state.position).ok();
    undo.add([this_system = &system, region = edit.region, old = system.materials()[region]] {
      this_system->set_material(region, old);
    });
    undo.keep_entry(settings.materials, region);
    system.set_material(edit.region, std::move(made));
    settings.materials[region] = edit.material;
    do_in_all_parts(system.part(), [&] {
      if (!may_be_refused) return;
      const EvaluationStatus status = system.elastic().admissible(state.position);
      if (status.ok()) return;
      throw InputError(
          fmt::format("{}{}with these parameters the energy is not defined in the present state, "
                      "which {}: change the material while the body is strained less.",
                      edit.material.where, edit.material.where.empty() ? "" : ": ",
                      change_by(state.position, status)));
    });
    if (!locked) warning = locking_warning(system);
    if (!unstable) {
      const std::string more = instability_warning(system);
      warning += (warning.empty() || more.empty() ? "" : " ") + more;
    }
    // A solver determines when it is made whether it can work without a matrix.
    renewal.stepper = all_built_in() != built_in;
    renewal.limit = true;
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) {
    Section& present = settings.section<Section>();
    undo.keep(present);
    if (const SceneSection& section = section_of<Section>(); section.put_into) {
      undo.add([this_system = &system, &section, old = present, list = &amplitudes] {
        section.put_into(&old, *this_system, *list);
      });
      section.put_into(&edit.settings, system, amplitudes);
    }
    renew(present, edit.settings);
    present = edit.settings;
  }
  // The parts to make again after an edit of a section. A solver takes the terms of a body as they are
  // when it is made.
  template <class Section>
  void renew(const Section&, const Section&) {
    renewal.stepper = renewal.limit = true;
  }
  void renew(const TimeSettings& present, const TimeSettings& next) {
    renewal.stepper = next.integrator != present.integrator;
    renewal.step = renewal.limit = true;
  }
  void renew(const SolverSettings&, const SolverSettings& next) {
    check_settings(next);
    renewal.stepper = true;
  }
  // The target moves with the mouse, which must not cost a new solver.
  void renew(const PullSettings& present, const PullSettings& next) {
    renewal.stepper = renewal.limit = next.vertices != present.vertices ||
                                      next.stiffness != present.stiffness ||
                                      next.damping != present.damping;
  }
  void renew(const Damping&, const Damping&) { renewal.limit = true; }
  void renew(const EnvironmentSettings&, const EnvironmentSettings&) {
    renewal.limit = !system.environment().is_uniform();
  }
  void operator()(const SetForce& edit) {
    undo.add(set_load(edit.entry, edit.index, settings.loads, system, amplitudes));
    renewal.limit = edit.entry.kind == LoadKind::kPressure;
  }
  void operator()(const SetFix& edit) {
    if (edit.index) {
      require_index(constraints.fixes, *edit.index, "fix");
      PrescribedVertices& held = constraints.fixes[*edit.index];
      FixSettings& present = constraints.fix_settings[*edit.index];
      PrescribedVertices changed = changed_held(held, present, edit.entry, system.mesh(),
                                                state.position, state.time, amplitudes);
      undo.keep_entry(constraints.fixes, *edit.index);
      undo.keep_entry(constraints.fix_settings, *edit.index);
      held = std::move(changed);
      present = edit.entry;
    } else {
      constraints.fixes.push_back(
          make_held(edit.entry, system.mesh(), state.position, state.time, amplitudes));
      undo.remove_last(constraints.fixes);
      constraints.fix_settings.push_back(edit.entry);
      undo.remove_last(constraints.fix_settings);
    }
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const Unfix& edit) {
    if (edit.fix) require_index(constraints.fixes, *edit.fix, "fix");
    const std::vector<Index> released = select_at(system.mesh(), edit.select, edit.where);
    bool any = false;
    for (std::size_t number = 0; number < constraints.fixes.size(); ++number) {
      if (edit.fix && *edit.fix != number) continue;
      undo.keep_entry(constraints.fixes, number);
      PrescribedVertices& fix = constraints.fixes[number];
      PrescribedVertices kept = fix;
      kept.vertices.clear();
      for (std::size_t i = 0; i < fix.vertices.size(); ++i) {
        if (std::binary_search(released.begin(), released.end(), fix.vertices[i])) continue;
        kept.start.col(static_cast<Index>(kept.vertices.size())) =
            fix.start.col(static_cast<Index>(i));
        kept.vertices.push_back(fix.vertices[i]);
      }
      kept.start.conservativeResize(3, static_cast<Index>(kept.vertices.size()));
      any = any || kept.vertices.size() < fix.vertices.size();
      fix = std::move(kept);
    }
    if (!anywhere(system.part(), any))
      warning = "unfix released no vertex: none of those it selects was fixed.";
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const SetConstraint& edit) {
    ConstraintObject object =
        make_constraint(edit.entry, system, state.position, state.time, amplitudes);
    const ConstraintSettings complete = with_length(edit.entry, object);
    if (edit.index) {
      require_index(constraints.others, *edit.index, "constraint");
      undo.keep_entry(constraints.others, *edit.index);
      undo.keep_entry(constraints.other_settings, *edit.index);
      constraints.others[*edit.index] = std::move(object);
      constraints.other_settings[*edit.index] = complete;
    } else {
      constraints.others.push_back(std::move(object));
      undo.remove_last(constraints.others);
      constraints.other_settings.emplace_back(complete);
      undo.remove_last(constraints.other_settings);
    }
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const RemoveConstraint& edit) {
    require_index(constraints.others, edit.index, "constraint");
    undo.keep_entry(constraints.others, edit.index);
    undo.keep_entry(constraints.other_settings, edit.index);
    constraints.others[edit.index] = PrescribedVertices{};  // an empty one
    constraints.other_settings[edit.index].reset();
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const SetObstacle& edit) {
    std::vector<BodyObstacle>& all = settings.obstacles;
    if (edit.index) {
      require_index(all, *edit.index, "obstacle");
      undo.keep_entry(all, *edit.index);
      change_obstacle(all[*edit.index], edit.entry, state.time, amplitudes);
    } else {
      all.push_back(begun_obstacle(edit.entry, state.time, least_modulus(system)));
      undo.remove_last(all);
    }
    renew_contact("With this change the body", edit.index.value_or(all.size() - 1));
  }
  void operator()(const RemoveObstacle& edit) {
    require_index(settings.obstacles, edit.index, "obstacle");
    if (settings.obstacles[edit.index].removed) {
      throw InputError(fmt::format("The obstacle \"{}\", number {}, was removed already.",
                                   settings.obstacles[edit.index].settings.name, edit.index));
    }
    undo.keep_entry(settings.obstacles, edit.index);
    settings.obstacles[edit.index].removed = true;
    renew_contact("The body", edit.index);
  }
  void renew_contact(const std::string& body, std::size_t changed) {
    if (system.contact() == nullptr) {
      throw InputError(
          "Obstacles can be added to a run only if its scene has obstacles or events that add "
          "some.");
    }
    std::shared_ptr<const Contact> old = system.set_contact(make_contact(
        settings.obstacles, amplitudes, system, system.contact(), std::nullopt, changed));
    undo.add([this_system = &system, old] { this_system->set_contact(old); });
    refuse_penetration(system, state.position, state.time, body);
    renewal.stepper = renewal.limit = true;
  }
  void operator()(const SetMomentum& edit) {
    if (!edit.change.value.allFinite()) {
      throw InputError(fmt::format("{}{}the momentum must be finite.", edit.change.where,
                                   edit.change.where.empty() ? "" : ": "));
    }
    for (const Index v : select_at(system.mesh(), edit.change.select, edit.change.where)) {
      vertex_block(state.momentum, v) = edit.change.value;
    }
    project_to_constraints(system.constraints(), system.mass(), state.position, state.time,
                           state.momentum);
    system.velocity_of(state.momentum, state.velocity);
  }
  void operator()(const ShiftState& edit) {
    const std::vector<Index> vertices = check_shift(edit.change, system.mesh());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (!edit.change.displacement.empty()) {
        vertex_block(state.position, vertices[i]) += edit.change.displacement[i];
      }
      if (!edit.change.impulse.empty()) {
        vertex_block(state.momentum, vertices[i]) += edit.change.impulse[i];
      }
    }
    if (!edit.change.displacement.empty()) {
      require_admissible(edit.change);
      renewal.limit = true;
      // Positions are moved back onto the constraints, and momenta are projected there.
      renewal.constraints = !system.constraints().empty();
    }
    if (renewal.constraints) return;
    project_to_constraints(system.constraints(), system.mass(), state.position, state.time,
                           state.momentum);
    system.velocity_of(state.momentum, state.velocity);
  }
  void require_admissible(const ShiftSettings& shift) const {
    const EvaluationStatus status = system.elastic().admissible(state.position);
    if (status.ok()) {
      require_defined_terms(system, state.position, state.time, "The displacement");
      return;
    }
    throw InputError(fmt::format(
        "{}{}the displacement {}: make it smaller, or move more vertices together.", shift.where,
        shift.where.empty() ? "" : ": ", change_by(state.position, status)));
  }
  std::string change_by(const Vector& position, const EvaluationStatus& status) const {
    return inadmissible_change(system.elastic(), position, status.failed_element,
                               system.mesh().tetrahedron_id(status.failed_element));
  }
  bool all_built_in() const {
    const std::vector<MaterialField>& materials = system.materials();
    return std::none_of(materials.begin(), materials.end(), [](const MaterialField& material) {
      return std::holds_alternative<CustomMaterial>(material.model());
    });
  }
};

}  // namespace

void apply_edit(RunData& run, std::unique_ptr<StepStrategy>& strategy, const Edit& edit, double at,
                const std::string& what) {
  // The edit changes a copy of the state, which becomes the present one once nothing can fail any
  // more. Other objects refer to the system; therefore it is changed in place, and so are the
  // settings and the plan of the steps. All are put back if something fails.
  MechanicalSystem& system = *run.system;
  RunSettings& settings = run.settings;
  RunProgress& progress = run.progress;
  State& new_state = run.states.other();
  new_state = run.state();
  std::unique_ptr<Stepper> new_stepper;
  std::unique_ptr<StepStrategy> new_strategy;
  AppliedEdit done;
  Undo undo;
  std::optional<Constraints> old_constraints;
  const StepPlan old_plan = progress.plan;
  const StepRange old_steps = progress.steps;
  const double old_first_step = progress.first_time_step;
  try {
    Editor editor{system, settings, new_state, run.scene.amplitude, undo};
    std::visit(editor, edit);
    const Renewal& renewal = editor.renewal;
    if (renewal.constraints) {
      old_constraints = constrain(system, settings.constraints, new_state.time, new_state.position,
                                  "bring their targets nearer to the present positions.");
      project_to_constraints(system.constraints(), system.mass(), new_state.position,
                             new_state.time, new_state.momentum);
      system.velocity_of(new_state.momentum, new_state.velocity);
    }
    const bool limited = !is_implicit(settings.time.integrator);
    StabilityLimit limit;
    CriticalModes modes;
    if (limited && (renewal.limit || renewal.step)) {
      limit = timed_limit(run, new_state.position, &modes);
    }
    if (renewal.step) {
      new_strategy = make_step_strategy(run);
      new_strategy->choose_step(limit, std::move(modes));
    } else if (limited && renewal.limit) {
      strategy->renew(limit, std::move(modes));
    }
    if (renewal.stepper || renewal.constraints) {
      new_stepper = make_stepper(settings.time.integrator, settings.solver, system);
    }
    done.at = at;
    done.time = new_state.time;
    done.step = new_state.step;
    done.what = what;
    done.warning = editor.warning;
    if (limited && renewal.limit) {
      if (std::string warning = step_warning(run, limit); !warning.empty()) {
        done.warning = std::move(warning);
      }
    }
    // The entry is added below, where nothing may fail.
    if (progress.edits.size() == progress.edits.capacity()) {
      progress.edits.reserve(2 * progress.edits.size() + 1);
    }
    done.energy_jump = run.balance->enter_edit(new_state);
    if (system.contact() != nullptr) progress.obstacle_forces.resize(system.contact()->size());
  } catch (...) {
    if (old_constraints) system.set_constraints(std::move(*old_constraints));
    undo.undo();
    progress.plan = old_plan;
    progress.steps = old_steps;
    progress.first_time_step = old_first_step;
    run.memory.tracker.reset();
    throw;
  }
  if (new_stepper) {
    run.memory.stepper = std::move(new_stepper);
    run.memory.whole_stepper.reset();
    run.reactions = Reactions::zero(system.dof_count());
  } else {
    run.memory.stepper->reset();
  }
  run.memory.impact = {};
  if (new_strategy) strategy = std::move(new_strategy);
  progress.plan.adaptive = {};
  run.states.switch_to_other();
  progress.edits.push_back(std::move(done));
}

}  // namespace tetraction
