// Edits between two steps: one mechanism for events, viewer and library users.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/multipliers.h"
#include "tetraction/simulation/setting_keys.h"
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

// The settings of a system that edits may change, without its constraints.
class SystemSettings {
 public:
  explicit SystemSettings(const MechanicalSystem& system)
      : materials_(system.elastic().materials()),
        environment_(system.environment()),
        damping_(system.damping()),
        forces_(system.forces()) {}
  void put_back(MechanicalSystem& system) {
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      system.set_material(static_cast<Index>(i), materials_[i]);
    }
    system.set_environment(environment_);
    system.set_damping(damping_);
    system.set_forces(std::move(forces_));
  }

 private:
  std::vector<MaterialModel> materials_;
  Environment environment_;
  Damping damping_;
  std::vector<ExternalForce> forces_;
};

// Changes copies of the settings. Nothing is committed before the whole edit has been checked.
struct Editor {
  MechanicalSystem& system;
  BodyConstraints& constraints;
  TimeSettings& time;
  SolverSettings& solver;
  std::vector<MaterialSettings>& materials;
  EnvironmentSettings& environment;
  std::vector<ForceSettings>& forces;
  State& state;
  Renewal renewal{};
  std::string warning{};

  void operator()(const SetMaterial& edit) {
    if (edit.region < 0 || edit.region >= system.region_count()) {
      throw InputError(fmt::format(kNoSuch, "material region", edit.region, system.region_count()));
    }
    const double density = system.density(edit.region);
    if (edit.material.density != density) {
      throw InputError(fmt::format(
          "The density cannot be changed during a run ({} to {} kg/m3): mass would appear from "
          "nowhere, and momentum and energy with it. Change it before the start.",
          density, edit.material.density));
    }
    const bool built_in = all_built_in();
    const bool locked = !locking_warning(system).empty();
    const bool unstable = !instability_warning(system).empty();
    system.set_material(edit.region, make_material(edit.material));
    materials[static_cast<std::size_t>(edit.region)] = edit.material;
    if (!locked) warning = locking_warning(system);
    if (!unstable) {
      const std::string more = instability_warning(system);
      warning += (warning.empty() || more.empty() ? "" : " ") + more;
    }
    // A solver determines when it is made whether it can work without a matrix.
    renewal.stepper = all_built_in() != built_in;
    renewal.limit = true;
  }
  void operator()(const SetTime& edit) {
    renewal.stepper = edit.time.integrator != time.integrator;
    renewal.step = renewal.limit = true;
    time = edit.time;
  }
  void operator()(const SetSolver& edit) {
    check_settings(edit.solver);
    solver = edit.solver;
    renewal.stepper = true;
  }
  void operator()(const SetDamping& edit) {
    system.set_damping(edit.damping);
    renewal.limit = true;
  }
  void operator()(const SetEnvironment& edit) {
    system.set_environment(make_environment(edit.environment));
    environment = edit.environment;
    renewal.limit = !system.environment().is_uniform();
  }
  void operator()(const SetForce& edit) {
    if (edit.index) require_index(forces, *edit.index, "force");
    ExternalForce force = make_force(edit.force, system.mesh());
    if (edit.index) {
      system.set_force(*edit.index, std::move(force));
      forces[*edit.index] = edit.force;
    } else {
      system.add_force(std::move(force));
      forces.push_back(edit.force);
    }
  }
  void operator()(const SetFix& edit) {
    if (edit.index) {
      require_index(constraints.fixes, *edit.index, "fix");
      PrescribedVertices& held = constraints.fixes[*edit.index];
      FixSettings& settings = constraints.fix_settings[*edit.index];
      held = changed_held(held, settings, edit.fix, system.mesh(), state.position, state.time);
      settings = edit.fix;
    } else {
      constraints.fixes.push_back(make_held(edit.fix, system.mesh(), state.position, state.time));
      constraints.fix_settings.push_back(edit.fix);
    }
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const Unfix& edit) {
    if (edit.fix) require_index(constraints.fixes, *edit.fix, "fix");
    const std::vector<Index> released = select_at(system.mesh(), edit.select, edit.where);
    bool any = false;
    for (std::size_t number = 0; number < constraints.fixes.size(); ++number) {
      if (edit.fix && *edit.fix != number) continue;
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
    if (!any) warning = "unfix released no vertex: none of those it selects was fixed.";
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const SetConstraint& edit) {
    ConstraintObject object = make_constraint(edit.constraint, system, state.position, state.time);
    const ConstraintSettings settings = with_length(edit.constraint, object);
    if (edit.index) {
      require_index(constraints.others, *edit.index, "constraint");
      constraints.others[*edit.index] = std::move(object);
      constraints.other_settings[*edit.index] = settings;
    } else {
      constraints.others.push_back(std::move(object));
      constraints.other_settings.emplace_back(settings);
    }
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const RemoveConstraint& edit) {
    require_index(constraints.others, edit.index, "constraint");
    constraints.others[edit.index] = PrescribedVertices{};  // an empty one
    constraints.other_settings[edit.index].reset();
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const SetMomentum& edit) {
    if (!edit.momentum.value.allFinite()) {
      throw InputError(fmt::format("{}{}the momentum must be finite.", edit.momentum.where,
                                   edit.momentum.where.empty() ? "" : ": "));
    }
    for (const Index v : select_at(system.mesh(), edit.momentum.select, edit.momentum.where)) {
      vertex_block(state.momentum, v) = edit.momentum.value;
    }
    project_to_constraints(system.constraints(), system.mass(), state.position, state.time,
                           state.momentum);
    state.velocity = system.velocity_of(state.momentum);
  }
  void operator()(const ShiftState& edit) {
    const std::vector<Index> vertices = check_shift(edit.shift, system.mesh());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (!edit.shift.displacement.empty()) {
        vertex_block(state.position, vertices[i]) += edit.shift.displacement[i];
      }
      if (!edit.shift.impulse.empty()) {
        vertex_block(state.momentum, vertices[i]) += edit.shift.impulse[i];
      }
    }
    if (!edit.shift.displacement.empty()) {
      require_admissible(edit.shift);
      renewal.limit = true;
      // Positions are moved back onto the constraints, and momenta are projected there.
      renewal.constraints = !system.constraints().empty();
    }
    if (renewal.constraints) return;
    project_to_constraints(system.constraints(), system.mass(), state.position, state.time,
                           state.momentum);
    state.velocity = system.velocity_of(state.momentum);
  }
  void require_admissible(const ShiftSettings& shift) const {
    const EvaluationStatus status = system.elastic().admissible(state.position);
    if (status.ok()) {
      require_defined_terms(system, state.position, state.time, "The displacement");
      return;
    }
    throw InputError(fmt::format(
        "{}{}the displacement inverts element {}: make it smaller, or move more vertices together.",
        shift.where, shift.where.empty() ? "" : ": ",
        system.mesh().tetrahedron_id(status.failed_element)));
  }
  bool all_built_in() const {
    const std::vector<MaterialModel>& models = system.elastic().materials();
    return std::none_of(models.begin(), models.end(), [](const MaterialModel& model) {
      return std::holds_alternative<CustomMaterial>(model);
    });
  }
};

}  // namespace

void Session::apply(const Edit& edit, const std::string& what) {
  impl_->apply(edit, impl_->state.time, what);
}

void Session::Impl::apply(const Edit& edit, double at, const std::string& what) {
  // The edit changes copies, which are committed once nothing can fail any more. Other objects
  // refer to the system; therefore it is changed in place, and so is the plan of the steps. Both
  // are restored if something fails.
  BodyConstraints new_constraints = constraints;
  TimeSettings new_time = time;
  SolverSettings new_solver = solver;
  std::vector<MaterialSettings> new_materials = materials;
  EnvironmentSettings new_environment = environment;
  std::vector<ForceSettings> new_forces = forces;
  State new_state = state;
  Editor editor{*system,       new_constraints, new_time,   new_solver,
                new_materials, new_environment, new_forces, new_state};
  std::unique_ptr<Stepper> new_stepper;
  AppliedEdit done;
  GoodState new_good;
  SystemSettings old_system(*system);
  std::optional<Constraints> old_constraints;
  const TimeSettings old_time = time;
  const Stepping old_stepping = stepping;
  const StepRange old_steps = steps;
  const double old_first_step = first_time_step;
  try {
    std::visit(editor, edit);
    const Renewal& renewal = editor.renewal;
    if (renewal.constraints) {
      old_constraints = constrain(*system, new_constraints, state.time, new_state.position);
      project_to_constraints(system->constraints(), system->mass(), new_state.position, state.time,
                             new_state.momentum);
      new_state.velocity = system->velocity_of(new_state.momentum);
    }
    time = new_time;
    const bool limited = !is_implicit(time.integrator);
    StabilityLimit limit;
    CriticalModes modes;
    if (limited && (renewal.limit || renewal.step)) {
      limit = current_limit(new_state.position, &modes);
    }
    if (renewal.step) {
      choose_step(limit, std::move(modes));
    } else if (limited && renewal.limit) {
      renew_automatic_step(limit, std::move(modes));
    }
    if (renewal.stepper || renewal.constraints) {
      new_stepper = make_stepper(time.integrator, new_solver, *system);
    }
    done.at = at;
    done.time = state.time;
    done.step = state.step;
    done.what = what;
    done.warning = editor.warning;
    if (limited && renewal.limit) {
      if (std::string warning = step_warning(limit); !warning.empty()) {
        done.warning = std::move(warning);
      }
    }
    edits.reserve(edits.size() + 1);
    if (keeps_good_states) {
      new_good = {new_state, std::make_unique<Balance>(*balance), stepping};
      new_good.balance->enter_edit(new_state);
    }
    done.energy_jump = balance->enter_edit(new_state);
  } catch (...) {
    if (old_constraints) system->set_constraints(std::move(*old_constraints));
    old_system.put_back(*system);
    time = old_time;
    stepping = old_stepping;
    steps = old_steps;
    first_time_step = old_first_step;
    tracker.reset();
    throw;
  }
  if (new_stepper) {
    stepper = std::move(new_stepper);
  } else {
    stepper->reset();
  }
  constraints = std::move(new_constraints);
  solver = std::move(new_solver);
  materials = std::move(new_materials);
  environment = std::move(new_environment);
  forces = std::move(new_forces);
  state = std::move(new_state);
  count_inverted(nullptr);
  edits.push_back(std::move(done));
  if (keeps_good_states) good = std::move(new_good);
}

bool Session::Impl::apply_events() {
  // t = k h has round-off. An event may make the step so short that the next event is not due yet.
  const auto due = [this] {
    return next_event < scene.event.size() &&
           scene.event[next_event].at <= state.time + 1e-6 * stepping.time_step;
  };
  while (due()) {
    const EventSettings& event = scene.event[next_event++];
    const std::size_t before = edits.size();
    try {
      for (const Edit& edit : event.edits) apply(edit, event.at, event.echo);
    } catch (const InputError& error) {
      status = RunStatus::kNotConverged;
      message = fmt::format("step {} (t = {:.6g} s): the event at {} s could not be made: {}",
                            state.step + 1, state.time, event.at, error.what());
      return false;
    }
    // One entry for the whole event.
    AppliedEdit& whole = edits[before];
    for (std::size_t i = before + 1; i < edits.size(); ++i) {
      whole.energy_jump += edits[i].energy_jump;
      if (!edits[i].warning.empty()) whole.warning = edits[i].warning;
    }
    edits.resize(before + 1);
    if (stepping.segment_count <= state.step - stepping.segment_step) {
      status = RunStatus::kFinished;
      warn_at_the_end();
      return false;
    }
  }
  return true;
}

}  // namespace tetraction
