// Edits between two steps: one mechanism for events, viewer and library users.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/multipliers.h"
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

// What an edit asks to be renewed.
struct Renewal {
  bool stepper = false;  // integrator, solver or constraints are others
  bool constraints = false;
  bool step = false;   // step or end are others
  bool limit = false;  // the stability limit may be another
};

// Changes copies of what an edit concerns; nothing is committed before all of it is known to fit.
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
    const bool locked = !locking_warning(system).empty();
    system.set_material(edit.region, make_material(edit.material));
    materials[static_cast<std::size_t>(edit.region)] = edit.material;
    if (!locked) warning = locking_warning(system);
    renewal.limit = true;
  }
  void operator()(const SetTime& edit) {
    renewal.stepper = edit.time.integrator != time.integrator;
    renewal.step = renewal.limit = true;
    time = edit.time;
  }
  void operator()(const SetSolver& edit) {
    check_solver(edit.solver);
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
    UserForce force = make_force(edit.force, system.mesh());
    if (!edit.index) {
      system.add_force(std::move(force));
      forces.push_back(edit.force);
      return;
    }
    if (*edit.index >= system.force_count()) {
      throw InputError(fmt::format(kNoSuch, "force", *edit.index, system.force_count()));
    }
    system.set_force(*edit.index, std::move(force));
    forces[*edit.index] = edit.force;
  }
  void operator()(const SetFix& edit) {
    if (edit.index) {
      require_index(constraints.fixes, *edit.index, "fix");
      HeldVertices& held = constraints.fixes[*edit.index];
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
      HeldVertices& fix = constraints.fixes[number];
      HeldVertices kept = fix;
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
    constraints.others[edit.index] = HeldVertices{};  // which holds none
    constraints.other_settings[edit.index].reset();
    renewal.constraints = renewal.limit = true;
  }
  void operator()(const SetMomentum& edit) {
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
      // Back onto whatever holds and guides them; momenta are projected there.
      renewal.constraints = !system.constraints().empty();
    }
    if (renewal.constraints) return;
    project_to_constraints(system.constraints(), system.mass(), state.position, state.time,
                           state.momentum);
    state.velocity = system.velocity_of(state.momentum);
  }
  void require_admissible(const ShiftSettings& shift) const {
    const Evaluation status = system.elastic().admissible(state.position);
    if (status.ok()) return;
    throw InputError(fmt::format(
        "{}{}the displacement inverts element {}: make it smaller, or move more vertices together.",
        shift.where, shift.where.empty() ? "" : ": ",
        system.mesh().tetrahedron_ids[static_cast<std::size_t>(status.failed_element)]));
  }
};

}  // namespace

void Session::apply(const Edit& edit, const std::string& what) {
  impl_->apply(edit, impl_->state.time, what);
}

void Session::Impl::apply(const Edit& edit, double at, const std::string& what) {
  // Copies of what can fail half-way; the system itself refuses before it changes anything.
  BodyConstraints new_constraints = constraints;
  TimeSettings new_time = time;
  SolverSettings new_solver = solver;
  std::vector<MaterialSettings> new_materials = materials;
  EnvironmentSettings new_environment = environment;
  std::vector<ForceSettings> new_forces = forces;
  State new_state = state;
  Editor editor{*system,       new_constraints, new_time,   new_solver,
                new_materials, new_environment, new_forces, new_state};
  std::visit(editor, edit);
  StabilityLimit limit;
  CriticalModes modes;
  if (editor.renewal.step) {
    const TimeSettings old_time = std::exchange(time, new_time);
    try {
      if (!is_implicit(time.integrator)) limit = current_limit(&modes);
      choose_step(limit, std::move(modes));
    } catch (...) {
      time = old_time;
      throw;
    }
  }
  if (editor.renewal.constraints) {
    constrain(*system, new_constraints, state.time, new_state.position);
    project_to_constraints(system->constraints(), system->mass(), new_state.position, state.time,
                           new_state.momentum);
    new_state.velocity = system->velocity_of(new_state.momentum);
  }
  if (editor.renewal.stepper || editor.renewal.constraints) {
    stepper = make_stepper(new_time.integrator, new_solver, *system);
  } else {
    stepper->reset();
  }
  constraints = std::move(new_constraints);
  time = new_time;
  solver = new_solver;
  materials = std::move(new_materials);
  environment = new_environment;
  forces = std::move(new_forces);
  state = std::move(new_state);

  AppliedEdit done;
  done.at = at;
  done.time = state.time;
  done.step = state.step;
  done.what = what;
  done.energy_jump = books->enter_edit(state);
  count_inverted(nullptr);
  done.warning = editor.warning;
  if (editor.renewal.limit && !is_implicit(time.integrator)) {
    if (!editor.renewal.step) {
      limit = current_limit(&modes);
      renew_automatic_step(limit, std::move(modes));
    }
    if (std::string warning = step_warning(limit); !warning.empty()) {
      done.warning = std::move(warning);
    }
  }
  edits.push_back(std::move(done));
  if (keeps_good_states) keep_state();
}

bool Session::Impl::apply_events() {
  // t = k h carries round-off. An event may make the step so short that what follows is not due yet.
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
