#include "failure_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/terms/term_forces.h"
#include "failure_place.h"
#include "simulation/stepping/step_strategy.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Forces are out of proportion if they would strain a part of the body by more than this.
constexpr double kAbsurdStrain = 100.0;
// Vertices are too fast if they move so many times as fast as pressure waves.
constexpr double kAbsurdSpeed = 10.0;
// Moduli that differ by more leave a factorisation too few digits for the softer part.
constexpr double kAbsurdContrast = 1e8;
// Supports have crushed a body whose stability limit has fallen to less than this share.
constexpr double kCrushed = 0.1;
// Residuals below this share of the forces are round-off of large sums.
constexpr double kLoadRoundOff = 1e-11;
struct Moduli {
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
};

Moduli moduli_of(const MechanicalSystem& system) {
  Moduli moduli;
  for (const MaterialField& material : system.materials()) {
    moduli.least = std::min(moduli.least, material.lame_range().least_modulus);
    moduli.most = std::max(moduli.most, material.lame_range().most_modulus);
  }
  moduli.least = least_of_parts(system.part(), moduli.least);
  moduli.most = largest_of_parts(system.part(), moduli.most);
  return moduli;
}

// The edge of a cube with the volume that belongs to a vertex, m.
double length_of_vertex(const MechanicalSystem& system) {
  return std::cbrt(system.mesh().total_volume() / static_cast<double>(global_vertex_count(system)));
}

// The strain that the forces (3 per vertex, N) would make in the stiffest material: of the largest
// one on the section that belongs to a vertex, or of all on the section of the body.
double strain_of(const MechanicalSystem& system, const Vector& forces) {
  double sum = 0.0;
  double most = 0.0;
  for (Index v = 0; v < system.owned_vertex_count(); ++v) {
    sum += vertex_block(forces, v).norm();
    most = std::max(most, vertex_block(forces, v).norm());
  }
  sum = sum_over_parts(system.part(), sum);
  most = largest_of_parts(system.part(), most);
  const double volume = system.mesh().total_volume();
  const double length = length_of_vertex(system);
  const double pressure = std::max(most / (length * length), sum / std::cbrt(volume * volume));
  return pressure / moduli_of(system).most;
}

std::optional<Index> first_not_finite(const Vector& field) {
  for (Index v = 0; v < field.size() / 3; ++v) {
    if (!vertex_block(field, v).allFinite()) return v;
  }
  return std::nullopt;
}

double fastest(const MechanicalSystem& system, const Vector& momentum) {
  const Vector3 mean = global_resultant(system, momentum) / system.total_mass();
  double most = 0.0;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    most = std::max(most, (vertex_block(momentum, v) / system.mass()[v] - mean).norm());
  }
  return largest_of_parts(system.part(), most);
}

// Speed of pressure waves in the stiffest material, m/s.
double wave_speed(const MechanicalSystem& system) {
  return std::sqrt(moduli_of(system).most * system.mesh().total_volume() / system.total_mass());
}

// Two instants of a step beside obstacles.
struct StepBesideObstacles {
  const MechanicalSystem& system;
  const State& from;
  double end = 0.0;
  bool is_static = false;

  ForcePoint point(const Vector& x, double at) const {
    ForcePoint result = system.force_point(x, is_static ? 0.0 : at);
    if (is_static) result.load_factor = at;
    return result;
  }
  ForcePoint begin_point() const { return point(from.position, from.time); }
};

// The name of what holds or leads a vertex, in the directions in which it cannot give way to an obstacle; empty if it
// can.
std::string holder_of(const StepBesideObstacles& step, Index v) {
  const MechanicalSystem& system = step.system;
  if (system.coordinates().is_free(v) || system.coordinates().set_of(v) >= 0) return {};
  constexpr double kNothing = 1e-9;
  HessianBlocks support;
  support.reset(system.vertex_count());
  system.contact()->add_support(step.begin_point(), Contact::Support::kPossible, support);
  const Matrix3 block = support.diagonal(v);
  const Matrix columns = system.coordinates().map(v).columns;
  if (columns.cols() > 0 &&
      (columns.transpose() * block * columns).norm() > kNothing * block.norm())
    return {};
  for (const PrescribedVertices& held : system.constraints().list().held) {
    if (std::find(held.vertices.begin(), held.vertices.end(), v) != held.vertices.end()) {
      return held.name;
    }
  }
  return "a constraint";
}

std::optional<ObstacleNote> held_vertex_note(const StepBesideObstacles& step,
                                             const Vector& prescribed) {
  constexpr int kMostTried = 64;
  const MechanicalSystem& system = step.system;
  std::vector<Index> held;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    if (!system.coordinates().is_free(v)) held.push_back(v);
  }
  for (int i = 0; i < kMostTried && !held.empty(); ++i) {
    const auto crossing =
        system.contact()->crossing(step.begin_point(), step.point(prescribed, step.end), &held);
    if (!crossing) return std::nullopt;
    const Contact& contact = *system.contact();
    const bool is_body = crossing->obstacle == contact.size();
    const std::string partner = contact.partner(crossing->obstacle);
    if (const std::string holder = holder_of(step, crossing->vertex); !holder.empty()) {
      return ObstacleNote{
          fmt::format("vertex {} cannot give way to {}, because it moves as {} prescribes",
                      system.mesh().vertex_id(crossing->vertex), partner, holder),
          fmt::format("End the run or the motion before they meet, move {} or the support aside, "
                      "or leave this part of the surface out with the key select of {}.",
                      is_body ? "the other body" : "the obstacle",
                      is_body ? "[contact]" : partner)};
    }
    held.erase(std::find(held.begin(), held.end(), crossing->vertex));
  }
  return std::nullopt;
}

std::optional<ObstacleNote> fast_obstacle_note(const StepBesideObstacles& step) {
  constexpr double kShare = 0.5;  // of an element
  const MechanicalSystem& system = step.system;
  const double length = step.end - step.from.time;
  Vector velocity = Vector::Zero(system.dof_count());
  if (!step.is_static) system.velocity_of(step.from.momentum, velocity);
  const Vector x = step.from.position + length * velocity;
  const auto crossing = system.contact()->crossing(step.begin_point(), step.point(x, step.end));
  if (!crossing || crossing->obstacle == system.contact()->size()) return std::nullopt;
  const Obstacle& obstacle = system.contact()->obstacle(crossing->obstacle);
  const auto frame = [&](double at) {
    return step.is_static ? frame_at(obstacle.motion, 0.0, at) : frame_at(obstacle.motion, at);
  };
  const Vector3 place = vertex_block(step.from.position, crossing->vertex);
  const double moved =
      (frame(step.end).to_local(place) - frame(step.from.time).to_local(place)).norm();
  const double element = length_of_vertex(system);
  if (!(moved > kShare * element)) return std::nullopt;
  const double shorter = kShare * element / moved * length;
  ObstacleNote note{
      fmt::format("the obstacle \"{}\" moves by {:.3g} m in this step, {:.2g} times the size of an "
                  "element, and meets vertex {} on its way",
                  obstacle.name, moved, moved / element, system.mesh().vertex_id(crossing->vertex)),
      ""};
  note.remedy = step.is_static
                    ? fmt::format(
                          "Take load steps of {:.2g} or less, or move the obstacle by a smaller "
                          "offset.",
                          shorter)
                    : fmt::format(
                          "Take a time.step of {:.2g} s or less, in which it moves by half of an "
                          "element, time.retry = {}, or a slower motion of the obstacle.",
                          shorter, static_cast<int>(std::ceil(std::log2(moved / element))) + 2);
  return note;
}

}  // namespace

std::optional<ObstacleNote> obstacle_note(const MechanicalSystem& system, const State& from,
                                          double end, const Vector& prescribed,
                                          const Vector& attempted, bool is_static) {
  const Contact* contact = system.contact();
  if (contact == nullptr || !from.position.allFinite() || !prescribed.allFinite()) {
    return std::nullopt;
  }
  const StepBesideObstacles step{system, from, end, is_static};
  if (contact->undefined_vertex(step.begin_point()) >= 0) return std::nullopt;
  if (auto note = held_vertex_note(step, prescribed)) return note;
  if (auto note = fast_obstacle_note(step)) return note;
  if (is_static || attempted.size() == 0 || !attempted.allFinite()) return std::nullopt;
  const auto crossing = contact->crossing(step.begin_point(), step.point(attempted, end));
  if (!crossing) return std::nullopt;
  const double thickness = contact->thickness(crossing->obstacle);
  const bool is_body = crossing->obstacle == contact->size();
  Vector velocity;
  system.velocity_of(from.momentum, velocity);
  const double speed =
      is_body ? fastest(system, from.momentum) : vertex_block(velocity, crossing->vertex).norm();
  return ObstacleNote{
      fmt::format("vertex {} would penetrate {} or pass through it",
                  system.mesh().vertex_id(crossing->vertex), contact->partner(crossing->obstacle)),
      fmt::format("{} at {:.3g} m/s, and should take ten steps to cross the layer of {:.3g} m: "
                  "take {}a larger thickness of {}; if the layer gives way under the impact, raise "
                  "its stiffness.",
                  is_body ? "Vertices move" : "It moves", speed, thickness,
                  speed > 0.0
                      ? fmt::format("a time.step of {:.2g} s or less, or ", 0.1 * thickness / speed)
                      : "a smaller time.step, or ",
                  is_body ? "the layer (contact.thickness)" : "the obstacle")};
}

std::optional<BadForce> bad_force(const MechanicalSystem& system, const ForcePoint& at) {
  Vector force;
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) {
      force.setZero(system.dof_count());
      term->add_gradient(at, force);
      if (const auto v = first_not_finite(force)) return BadForce{term->name(), *v};
    }
    if (term->has_load()) {
      force.setZero(system.dof_count());
      term->add_load(at, force);
      if (const auto v = first_not_finite(force)) return BadForce{term->name(), *v};
    }
  }
  return std::nullopt;
}

bool leads_out_of_range(const MechanicalSystem& system, const State& from, double time) {
  bool leads = false;
  if (system.constraints().moving()) {
    Vector prescribed = from.position;
    system.constraints().prescribe(time, prescribed);
    leads = !prescribed.allFinite();
  }
  return anywhere(system.part(), leads);
}

FailureCause cause_of(const RunData& run, const StepOutcome& outcome, const StepFailure& failure) {
  const MechanicalSystem& system = *run.system;
  const State& state = run.state();
  const TimeSettings& time = run.settings.time;
  const double h = failure.time_step;
  const MeshPart* part = system.part();
  if (outcome.status == StepStatus::kUndefined) return FailureCause::kForceTerm;
  if (outcome.status == StepStatus::kOverdamped) return FailureCause::kDamping;
  const TimeSpan span{failure.time, failure.time + h};
  Vector load;
  Vector forces;
  Vector springs;
  system.external_force(state.position, span.begin, h, load);
  const ForcePoint start = system.force_point(state.position, failure.time, span);
  if (gather_term_forces(system, start, load, forces, springs)) forces -= springs;
  bool is_bad = !forces.allFinite();
  if (!is_bad && failure.attempted_position.size() > 0 && failure.attempted_position.allFinite()) {
    const ForcePoint end = system.force_point(failure.attempted_position, span.end, span);
    is_bad = bad_force(system, end).has_value();
  }
  if (anywhere(part, is_bad)) return FailureCause::kForceTerm;
  if (strain_of(system, forces) > kAbsurdStrain) return FailureCause::kLoads;
  switch (outcome.obstacle) {
    case StepObstacle::kPrescribedMotion:
      return FailureCause::kPrescribedMotion;
    case StepObstacle::kConstraints:
      return FailureCause::kConstraints;
    case StepObstacle::kLoads:
    case StepObstacle::kViscosity:
    case StepObstacle::kRoundOff:
      return FailureCause::kStepTooLarge;
    case StepObstacle::kSolver:
      break;
  }
  // A body that supports have compressed is so stiff that the limit has fallen.
  if (outcome.status == StepStatus::kInverted && anywhere(part, system.constraints().moving()) &&
      failure.stable_step < kCrushed * run.initial_limit.critical_step) {
    return FailureCause::kPrescribedMotion;
  }
  const bool implicit = is_implicit(time.integrator);
  if (!implicit && h > failure.stable_step) {
    return is_automatic(time) && outcome.status == StepStatus::kInverted &&
                   worst_is_held(system, failure)
               ? FailureCause::kPrescribedMotion
               : FailureCause::kStepAboveLimit;
  }
  if (fastest(system, state.momentum) > kAbsurdSpeed * wave_speed(system)) {
    return FailureCause::kSpeed;
  }
  if (outcome.status == StepStatus::kInverted && worst_is_held(system, failure)) {
    return FailureCause::kPrescribedMotion;
  }
  if (!implicit || outcome.status != StepStatus::kNotConverged) return FailureCause::kStepTooLarge;
  const Moduli moduli = moduli_of(system);
  if (moduli.most > kAbsurdContrast * moduli.least) return FailureCause::kStiffnessContrast;
  const MinimizerReport& report = outcome.minimizer;
  const double scale = report.asked_limit / run.settings.solver.tolerance;
  if (report.asked_limit > 0.0 && report.residual > report.residual_limit &&
      report.residual < kLoadRoundOff * scale) {
    return FailureCause::kTolerance;
  }
  if (report.termination == Termination::kIterationLimit) return FailureCause::kIterations;
  return h > failure.stable_step ? FailureCause::kStepTooLarge : FailureCause::kSolver;
}

std::string remedy_for(const RunData& run, const StepFailure& failure, const StepOutcome& outcome,
                       const std::string& advice) {
  const MechanicalSystem& system = *run.system;
  const State& state = run.state();
  const SolverSettings& solver = run.settings.solver;
  const double h = failure.time_step;
  switch (failure.cause) {
    case FailureCause::kLoads:
      return fmt::format(
          "The loads are out of all proportion to the body, whose stiffest modulus is {:.3g} Pa: "
          "they would strain it more than a hundredfold, with any size of the steps. Check their "
          "size and units, and those of the modulus and of the mesh.",
          moduli_of(system).most);
    case FailureCause::kSpeed:
      return fmt::format(
          "A vertex moves at {:.3g} m/s relative to the body, and pressure waves in its material "
          "at {:.3g} m/s: no size of the steps helps. Check the velocities at the start, impulses "
          "and prescribed motion, and their units.",
          fastest(system, state.momentum), wave_speed(system));
    case FailureCause::kStiffnessContrast: {
      const Moduli moduli = moduli_of(system);
      return fmt::format(
          "The moduli of the body lie between {:.3g} and {:.3g} Pa, too far apart for double "
          "precision: bring them nearer together, or hold the stiff part with a constraint of kind "
          "\"rigid\".",
          moduli.least, moduli.most);
    }
    case FailureCause::kPrescribedMotion:
      if (leads_out_of_range(system, state, failure.time + h)) {
        return "Make the velocities, angular velocities, offsets and amplitudes of [[fix]] and "
               "[[constraint]] smaller, and check their units.";
      }
      return "What moves as prescribed crushes or tears the elements beside it: make the motion "
             "smaller or slower, check its direction and units, or refine the mesh there. " +
             advice;
    case FailureCause::kConstraints:
      return "Check the lengths of distances and the motion of handles. " + advice;
    case FailureCause::kTolerance:
      return fmt::format(
          "solver.tolerance = {:.3g} is below the round-off of the forces: the step came as near "
          "as double precision allows. Take solver.tolerance = {:.1g} or larger.",
          solver.tolerance,
          2.0 * outcome.minimizer.residual / outcome.minimizer.asked_limit * solver.tolerance);
    case FailureCause::kIterations: {
      const int usual = SolverSettings{}.max_iterations;
      const std::string more = fmt::format("solver.max_iterations = {} did not suffice: raise it.",
                                           solver.max_iterations);
      // So few may be too few for any step.
      if (solver.max_iterations < usual && run.settings.time.retry == 0) {
        return more + fmt::format(" The default is {}.", usual);
      }
      return more + " " + advice;
    }
    case FailureCause::kForceTerm:
      if (outcome.status == StepStatus::kUndefined) return advice;
      return "Correct the term: it must give finite forces wherever its potential is defined. "
             "Amplitudes and strengths must be finite, too.";
    case FailureCause::kSolver:
      return fmt::format(
          "The step of {:.4g} s is below the explicit stability limit of {:.4g} s, so that its "
          "size is hardly the cause. Check loads, materials, prescribed motion and the quality of "
          "the mesh (tetraction check), or take another solver.kind.",
          h, failure.stable_step);
    case FailureCause::kStepAboveLimit:
    case FailureCause::kStepTooLarge:
    case FailureCause::kDamping:
      break;
  }
  return advice;
}

}  // namespace tetraction
