// What a failed step tells the user: what went wrong, where, why, and the remedy that fits the cause.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/terms/term_forces.h"

#include "session_impl.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/whole_body.h"

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
constexpr double kRoundOff = 1e-11;
// Elements with so much of the largest energy density belong to the place of a failure.
constexpr double kConcerned = 0.5;

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
  return std::cbrt(system.mesh().total_volume() / static_cast<double>(whole_vertex_count(system)));
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

// A term and a vertex whose force is not a finite number.
struct BadForce {
  std::string term;
  Index vertex = 0;
};

std::optional<Index> first_not_finite(const Vector& field) {
  for (Index v = 0; v < field.size() / 3; ++v) {
    if (!vertex_block(field, v).allFinite()) return v;
  }
  return std::nullopt;
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

double fastest(const MechanicalSystem& system, const Vector& momentum) {
  const Vector3 mean = whole_resultant(system, momentum) / system.total_mass();
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

Vector3 rest_centroid(const TetMesh& mesh, Index e) {
  Vector3 sum = Vector3::Zero();
  for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
    sum += mesh.vertices[static_cast<std::size_t>(v)];
  }
  return 0.25 * sum;
}

// In single precision, in which numbers that differ by round-off only are mostly equal. Symmetric bodies have such
// elements, and the one with the lowest number is then named.
double rounded(double number) {
  return static_cast<double>(static_cast<float>(number));
}

// Elements, the worst first, and how bad that one is, to compare it with those of other parts.
struct ConcernedElements {
  std::vector<Index> elements;
  double badness = -std::numeric_limits<double>::infinity();
};

// The elements that a motion to q inverts or tears to places that are no numbers, the worst first.
ConcernedElements broken_elements(const MechanicalSystem& system, const Vector& q) {
  std::vector<std::pair<double, Index>> broken;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const double jacobian = least_jacobian(system, e, q);
    if (jacobian > 0.0 && std::isfinite(jacobian)) continue;
    broken.emplace_back(
        std::isfinite(jacobian) ? rounded(jacobian) : -std::numeric_limits<double>::infinity(), e);
  }
  std::sort(broken.begin(), broken.end());
  ConcernedElements found;
  if (!broken.empty()) found.badness = -broken.front().first;
  found.elements.reserve(broken.size());
  for (const auto& entry : broken) found.elements.push_back(entry.second);
  return found;
}

// The elements with the largest energy densities at q, the largest first.
ConcernedElements hot_elements(const MechanicalSystem& system, const Vector& q) {
  Vector of_points;
  system.elastic_energy_densities(q, of_points);
  const Vector densities =
      of_points.reshaped(system.rest().points_per_element(), system.rest().element_count())
          .colwise()
          .maxCoeff()
          .transpose()
          .unaryExpr(&rounded);
  const double most = largest_of_parts(system.part(), densities.maxCoeff());
  std::vector<Index> elements;
  for (Index e = 0; e < densities.size(); ++e) {
    if (!(densities[e] < kConcerned * most)) elements.push_back(e);
  }
  std::stable_sort(elements.begin(), elements.end(),
                   [&](Index a, Index b) { return densities[a] > densities[b]; });
  // Where the energy is the same everywhere, as in a body at rest, it tells nothing.
  const double count = sum_over_parts(system.part(), static_cast<double>(elements.size()));
  if (count > 0.5 * static_cast<double>(whole_tetrahedron_count(system))) elements.clear();
  ConcernedElements found;
  if (!elements.empty()) found.badness = densities[elements.front()];
  found.elements = std::move(elements);
  return found;
}

// The elements at the vertex with the largest force (3 per vertex; empty: none).
ConcernedElements loaded_elements(const MechanicalSystem& system, const Vector& forces) {
  Index loaded = 0;
  double most = -1.0;
  const Index count = std::min(forces.size() / 3, system.owned_vertex_count());
  for (Index v = 0; v < count; ++v) {
    const double force = vertex_block(forces, v).norm();
    if (force <= most) continue;
    most = force;
    loaded = v;
  }
  ConcernedElements found;
  found.badness = most;
  // The other parts leave this to the one that owns the vertex.
  if (most < largest_of_parts(system.part(), most)) return found;
  std::vector<Index>& elements = found.elements;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const ElementNodes nodes = system.rest().nodes(e);
    if (std::find(nodes.begin(), nodes.end(), loaded) != nodes.end()) elements.push_back(e);
  }
  return found;
}

// Whether prescribed motion leads vertices at that time to where positions are not finite.
bool leads_out_of_range(const MechanicalSystem& system, const State& from, double time) {
  bool leads = false;
  if (system.constraints().moving()) {
    Vector prescribed = from.position;
    system.constraints().prescribe(time, prescribed);
    leads = !prescribed.allFinite();
  }
  return anywhere(system.part(), leads);
}

bool holds_moving_vertex(const MechanicalSystem& system, Index e) {
  const Constraints& constraints = system.constraints();
  if (!constraints.moving()) return false;
  const std::vector<Index> held = constraints.constrained_vertices();
  const ElementNodes nodes = system.rest().nodes(e);
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](Index v) { return std::binary_search(held.begin(), held.end(), v); });
}

}  // namespace

const char* to_string(FailureCause cause) {
  switch (cause) {
    case FailureCause::kStepAboveLimit:
      return "step_above_limit";
    case FailureCause::kStepTooLarge:
      return "step_too_large";
    case FailureCause::kLoads:
      return "loads";
    case FailureCause::kSpeed:
      return "speed";
    case FailureCause::kStiffnessContrast:
      return "stiffness_contrast";
    case FailureCause::kPrescribedMotion:
      return "prescribed_motion";
    case FailureCause::kConstraints:
      return "constraints";
    case FailureCause::kDamping:
      return "damping";
    case FailureCause::kTolerance:
      return "tolerance";
    case FailureCause::kIterations:
      return "iterations";
    case FailureCause::kForceTerm:
      return "force_term";
    case FailureCause::kSolver:
      break;
  }
  return "solver";
}

const StepFailure* Session::failure() const {
  const RunStatus status = impl_->progress.status;
  const bool failed = status == RunStatus::kUnstable || status == RunStatus::kNotConverged;
  return failed && impl_->failed_step ? &*impl_->failed_step : nullptr;
}

double Session::Impl::present_limit() const {
  if (limit_of_failure) return *limit_of_failure;
  double limit = initial_limit.critical_step;
  if (everywhere(system->part(), system->elastic().admissible(state().position).ok())) {
    limit = std::min(limit, limit_at(state().position).critical_step);
  }
  return limit;
}

void Session::Impl::locate(StepFailure& failure, Index element) const {
  const MeshPart* part = system->part();
  const Vector& trial = failure.attempted_position;
  ConcernedElements found;
  const auto is_found = [&] { return anywhere(part, !found.elements.empty()); };
  if (trial.size() > 0) found = broken_elements(*system, trial);
  const bool is_broken = is_found();
  if (!is_broken && element >= 0) found = {{element}, 0.0};
  if (!is_found()) found = hot_elements(*system, state().position);
  if (!is_found()) found = loaded_elements(*system, next_external_force());
  failure.elements = std::move(found.elements);
  failure.element_count =
      static_cast<Index>(sum_over_parts(part, static_cast<double>(failure.elements.size())));
  if (part != nullptr) {
    bool is_worst =
        largest_of_parts(part, found.badness) == found.badness && !failure.elements.empty();
    const double id = is_worst ? static_cast<double>(element_id(failure.elements.front()))
                               : std::numeric_limits<double>::infinity();
    is_worst = least_of_parts(part, id) == id && is_worst;
    failure.process = first_process(*part, is_worst);
    if (failure.process == part->count()) failure.process = 0;
  }
  if (failure.elements.empty()) return;
  failure.jacobian =
      least_jacobian(*system, failure.elements.front(), is_broken ? trial : state().position);
}

// Whether the worst element is at a vertex that is held or led.
bool Session::Impl::worst_is_held(const StepFailure& failure) const {
  const MeshPart* part = system->part();
  const bool is_worst = part == nullptr || part->rank() == failure.process;
  return anywhere(part, is_worst && !failure.elements.empty() &&
                            holds_moving_vertex(*system, failure.elements.front()));
}

std::string Session::Impl::place_of(const StepFailure& failure) const {
  if (failure.elements.empty()) return {};
  const Index e = failure.elements.front();
  const Vector3 center = rest_centroid(system->mesh(), e);
  std::string text =
      fmt::format(" at element {} (region {}, centroid ({:.4g}, {:.4g}, {:.4g}) m at rest, ",
                  element_id(e), system->region(e), center.x(), center.y(), center.z());
  text += std::isfinite(failure.jacobian) ? fmt::format("J = {:.3g}", failure.jacobian)
                                          : "J is not a finite number";
  // The step did not get as far as where an element is inverted.
  if (failure.jacobian > 0.0 && failure.attempted_position.size() == 0) text += " before the step";
  text += ")";
  if (failure.element_count > 1) {
    text += fmt::format(" and {} more", failure.element_count - 1);
  }
  return text;
}

FailureCause Session::Impl::cause_of(const StepOutcome& outcome, const StepFailure& failure) {
  const double h = failure.time_step;
  const MeshPart* part = system->part();
  if (outcome.status == StepStatus::kUndefined) return FailureCause::kForceTerm;
  if (outcome.status == StepStatus::kOverdamped) return FailureCause::kDamping;
  const TimeSpan span{failure.time, failure.time + h};
  Vector load;
  Vector forces;
  Vector springs;
  system->external_force(state().position, span.begin, h, load);
  const ForcePoint start = system->force_point(state().position, failure.time, span);
  if (gather_term_forces(*system, start, load, forces, springs)) forces -= springs;
  bool is_bad = !forces.allFinite();
  if (!is_bad && failure.attempted_position.size() > 0 && failure.attempted_position.allFinite()) {
    const ForcePoint end = system->force_point(failure.attempted_position, span.end, span);
    is_bad = bad_force(*system, end).has_value();
  }
  if (anywhere(part, is_bad)) return FailureCause::kForceTerm;
  if (strain_of(*system, forces) > kAbsurdStrain) return FailureCause::kLoads;
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
  if (outcome.status == StepStatus::kInverted && anywhere(part, system->constraints().moving()) &&
      failure.stable_step < kCrushed * initial_limit.critical_step) {
    return FailureCause::kPrescribedMotion;
  }
  const bool implicit = is_implicit(settings.time.integrator);
  if (!implicit && h > failure.stable_step) {
    return is_automatic() && outcome.status == StepStatus::kInverted && worst_is_held(failure)
               ? FailureCause::kPrescribedMotion
               : FailureCause::kStepAboveLimit;
  }
  if (fastest(*system, state().momentum) > kAbsurdSpeed * wave_speed(*system)) {
    return FailureCause::kSpeed;
  }
  if (outcome.status == StepStatus::kInverted && worst_is_held(failure)) {
    return FailureCause::kPrescribedMotion;
  }
  if (!implicit || outcome.status != StepStatus::kNotConverged) return FailureCause::kStepTooLarge;
  const Moduli moduli = moduli_of(*system);
  if (moduli.most > kAbsurdContrast * moduli.least) return FailureCause::kStiffnessContrast;
  const MinimizerReport& report = outcome.minimizer;
  const double scale = report.asked_limit / settings.solver.tolerance;
  if (report.asked_limit > 0.0 && report.residual > report.residual_limit &&
      report.residual < kRoundOff * scale) {
    return FailureCause::kTolerance;
  }
  if (report.termination == Termination::kIterationLimit) return FailureCause::kIterations;
  return h > failure.stable_step ? FailureCause::kStepTooLarge : FailureCause::kSolver;
}

std::string Session::Impl::remedy_for(const StepFailure& failure,
                                      const StepOutcome& outcome) const {
  const double h = failure.time_step;
  switch (failure.cause) {
    case FailureCause::kLoads:
      return fmt::format(
          "The loads are out of all proportion to the body, whose stiffest modulus is {:.3g} Pa: "
          "they would strain it more than a hundredfold, with any size of the steps. Check their "
          "size and units, and those of the modulus and of the mesh.",
          moduli_of(*system).most);
    case FailureCause::kSpeed:
      return fmt::format(
          "A vertex moves at {:.3g} m/s relative to the body, and pressure waves in its material "
          "at "
          "{:.3g} m/s: no size of the steps helps. Check the velocities at the start, impulses and "
          "prescribed motion, and their units.",
          fastest(*system, state().momentum), wave_speed(*system));
    case FailureCause::kStiffnessContrast: {
      const Moduli moduli = moduli_of(*system);
      return fmt::format(
          "The moduli of the body lie between {:.3g} and {:.3g} Pa, too far apart for double "
          "precision: bring them nearer together, or hold the stiff part with a constraint of kind "
          "\"rigid\".",
          moduli.least, moduli.most);
    }
    case FailureCause::kPrescribedMotion:
      if (leads_out_of_range(*system, state(), failure.time + h)) {
        return "Make the velocities, angular velocities, offsets and amplitudes of [[fix]] and "
               "[[constraint]] smaller, and check their units.";
      }
      return "What moves as prescribed crushes or tears the elements beside it: make the motion "
             "smaller or slower, check its direction and units, or refine the mesh there. " +
             limit_advice();
    case FailureCause::kConstraints:
      return "Check the lengths of distances and the motion of handles. " + limit_advice();
    case FailureCause::kTolerance:
      return fmt::format(
          "solver.tolerance = {:.3g} is below the round-off of the forces: the step came as near "
          "as "
          "double precision allows. Take solver.tolerance = {:.1g} or larger.",
          settings.solver.tolerance,
          2.0 * outcome.minimizer.residual / outcome.minimizer.asked_limit *
              settings.solver.tolerance);
    case FailureCause::kIterations: {
      const int usual = SolverSettings{}.max_iterations;
      const std::string advice = fmt::format(
          "solver.max_iterations = {} did not suffice: raise it.", settings.solver.max_iterations);
      // So few may be too few for any step.
      if (settings.solver.max_iterations < usual && settings.time.retry == 0) {
        return advice + fmt::format(" The default is {}.", usual);
      }
      return advice + " " + limit_advice();
    }
    case FailureCause::kForceTerm:
      if (outcome.status == StepStatus::kUndefined) return limit_advice();
      return "Correct the term: it must give finite forces wherever its potential is defined. "
             "Amplitudes and strengths must be finite, too.";
    case FailureCause::kSolver:
      return fmt::format(
          "The step of {:.4g} s is below the explicit stability limit of {:.4g} s, so that its "
          "size "
          "is hardly the cause. Check loads, materials, prescribed motion and the quality of the "
          "mesh (tetraction check), or take another solver.kind.",
          h, failure.stable_step);
    case FailureCause::kStepAboveLimit:
    case FailureCause::kStepTooLarge:
    case FailureCause::kDamping:
      break;
  }
  return limit_advice();
}

void Session::Impl::fail(const StepOutcome& outcome) {
  StepFailure now;
  now.step = state().step + 1;
  now.time = state().time;
  now.time_step = planned_span().length;
  now.stable_step = present_limit();
  limit_of_failure = now.stable_step;
  const State& tried = states.other();
  if (tried.step == now.step) now.attempted_position = tried.position;
  RunStatus how = RunStatus::kUnstable;
  switch (outcome.status) {
    case StepStatus::kOk:
      return;
    case StepStatus::kInverted:
      now.what = is_automatic()
                     ? "the body is crushed or torn (inverted, J <= 0, whatever the step)"
                     : "the material's energy is not defined (inverted, J <= 0)";
      break;
    case StepStatus::kNotFinite:
      now.what = outcome.message.empty() ? "positions, momenta or energies are not finite numbers"
                                         : outcome.message;
      break;
    case StepStatus::kUndefined:
      now.what = outcome.message;
      break;
    case StepStatus::kOverdamped:
      now.what = "the damping forces of one step would turn velocities around and give energy";
      break;
    case StepStatus::kNotConverged: {
      how = RunStatus::kNotConverged;
      now.what = outcome.message;
      const MinimizerReport& report = outcome.minimizer;
      if (report.iterations == 0) break;
      // The residual may be small enough, and something else keeps the step from its end.
      const bool is_large = !(report.residual <= report.residual_limit);
      // A step with moving targets or constraints minimises more than once.
      const bool several = report.iterations > settings.solver.max_iterations;
      now.what = fmt::format("the implicit step did not converge after {} iteration{}{}: {} ",
                             report.iterations, report.iterations == 1 ? "" : "s",
                             several ? " of several minimisations" : "", outcome.message);
      now.what += is_large ? fmt::format("(force residual {:.3g} N, allowed {:.3g} N)",
                                         report.residual, report.residual_limit)
                           : fmt::format(
                                 "(the last force residual, {:.3g} N, is within the {:.3g} N "
                                 "allowed)",
                                 report.residual, report.residual_limit);
      break;
    }
  }
  if (outcome.obstacle == StepObstacle::kPrescribedMotion) {
    // Where the elements would be if the rest of the body did not follow.
    now.attempted_position = state().position;
    system->constraints().prescribe(now.time + now.time_step, now.attempted_position);
  }
  locate(now, outcome.element);
  now.cause = cause_of(outcome, now);
  if (leads_out_of_range(*system, state(), now.time + now.time_step)) {
    now.cause = FailureCause::kPrescribedMotion;
    now.what = "what moves as prescribed gets to positions that are not finite numbers";
  }
  if (now.cause == FailureCause::kForceTerm && outcome.status != StepStatus::kUndefined) {
    const TimeSpan span{now.time, now.time + now.time_step};
    auto bad = bad_force(*system, system->force_point(state().position, now.time, span));
    if (!bad && now.attempted_position.size() > 0) {
      bad = bad_force(*system, system->force_point(now.attempted_position, span.end, span));
    }
    if (bad) {
      now.what =
          fmt::format("the force term \"{}\" gives a force that is not finite at vertex {}: ",
                      bad->term, system->mesh().vertex_id(bad->vertex)) +
          now.what;
    }
    take_from_first(system->part(), bad.has_value(), now.what);
  }
  now.remedy = remedy_for(now, outcome);
  const bool has_place =
      outcome.status == StepStatus::kInverted || outcome.status == StepStatus::kNotFinite;
  end_with(how, std::move(now), has_place || outcome.status == StepStatus::kNotConverged);
}

void Session::Impl::stop(RunStatus how, const std::string& what, Index element) {
  StepFailure now;
  now.step = state().step + 1;
  now.time = state().time;
  now.time_step = progress.plan.time_step;
  now.stable_step = present_limit();
  limit_of_failure = now.stable_step;
  now.what = what;
  locate(now, element);
  now.cause = worst_is_held(now) ? FailureCause::kPrescribedMotion : FailureCause::kStepAboveLimit;
  now.remedy = limit_advice();
  end_with(how, std::move(now), true);
}

void Session::Impl::fail_blown_up() {
  StepFailure now;
  now.step = state().step;
  now.time = state().time - progress.steps.last;
  now.time_step = progress.steps.last;
  now.stable_step = present_limit();
  limit_of_failure = now.stable_step;
  now.what = fmt::format(
      "the energy blew up: the integrator has added {:.3g} J to the {:.3g} J that entered, most",
      balance->energy_error(), balance->energy_scale());
  now.attempted_position = state().position;
  locate(now, -1);
  StepOutcome outcome;
  now.cause = cause_of(outcome, now);
  now.remedy = remedy_for(now, outcome);
  end_with(RunStatus::kUnstable, std::move(now), true);
}

// The path of the equilibria has messages of its own. Its time is the load factor.
void Session::Impl::fail_load_step(const StepOutcome& outcome) {
  StepFailure now;
  now.step = state().step + 1;
  now.time = state().time;
  now.time_step = loading->increment();
  now.what = loading->message(outcome);
  locate(now, outcome.element);
  progress.message = now.what + ". Look" + place_of(now) + " first";
  progress.status = RunStatus::kNotConverged;
  failed_step = std::move(now);
}

void Session::Impl::end_with(RunStatus how, StepFailure now, bool with_place) {
  limit_of_failure.reset();
  const std::string where = (with_place ? place_of(now) : "") + center_note();
  progress.message = fmt::format("step {} (t = {:.6g} s): {}{}. {}", now.step,
                                 now.time + now.time_step, now.what, where, now.remedy);
  if (const MeshPart* part = system->part(); part != nullptr) {
    part->broadcast(progress.message, now.process);
  }
  progress.status = how;
  failed_step = std::move(now);
}

}  // namespace tetraction
