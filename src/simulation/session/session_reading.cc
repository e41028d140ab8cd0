// The functions that read a session.
#include "session_impl.h"
#include "simulation/stepping/limit_estimates.h"

namespace tetraction {
namespace {

// Whether the present time settings, or those that an event of the scene sets, are such.
bool any_time_settings(const RunData& run, const auto& are_such) {
  if (run.analysis == Analysis::kEquilibrium) return false;
  if (are_such(run.settings.time)) return true;
  for (const EventSettings& event : run.scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change != nullptr && are_such(change->settings)) return true;
    }
  }
  return false;
}

}  // namespace

Analysis Session::analysis() const {
  return impl_->run.analysis;
}
const LoadPath* Session::load_path() const {
  return impl_->equilibrium ? &impl_->equilibrium->path() : nullptr;
}
const Scene& Session::scene() const {
  return impl_->run.scene;
}
const MechanicalSystem& Session::system() const {
  return *impl_->run.system;
}
const State& Session::state() const {
  return impl_->run.states.at_home();
}
double Session::time() const {
  return impl_->run.state().time;
}
Index Session::step_number() const {
  return impl_->run.state().step;
}
const Balance& Session::balance() const {
  return *impl_->run.balance;
}
RunStatus Session::status() const {
  return impl_->run.progress.status;
}
const std::string& Session::message() const {
  return impl_->run.progress.message;
}
double Session::time_step() const {
  return impl_->run.progress.plan.time_step;
}
Index Session::step_count() const {
  return impl_->run.progress.plan.segment_step + impl_->run.progress.plan.segment_count;
}
const StepRange& Session::steps() const {
  return impl_->run.progress.steps;
}
const InvertedElements& Session::inverted_elements() const {
  return impl_->run.progress.inverted;
}
const StabilityLimit& Session::initial_limit() const {
  return impl_->run.initial_limit;
}
StabilityLimit Session::current_limit() const {
  return limit_at(impl_->run, impl_->run.state().position);
}
const std::vector<std::string>& Session::warnings() const {
  return impl_->run.progress.warnings;
}
const std::vector<AppliedEdit>& Session::edits() const {
  return impl_->run.progress.edits;
}
const RunSettings& Session::settings() const {
  return impl_->run.settings;
}
PresentFix Session::fix(std::size_t i) const {
  const PrescribedVertices& held = impl_->run.settings.constraints.fixes.at(i);
  // In an equilibrium the targets are those at the full loads.
  const double time = impl_->equilibrium ? 0.0 : impl_->run.state().time;
  PresentFix fix{impl_->run.settings.constraints.fix_settings.at(i), held.vertices, held.start};
  for (Index v = 0; v < fix.targets.cols(); ++v) {
    fix.targets.col(v) = held.motion.position(held.start.col(v), time);
  }
  return fix;
}
double Session::tension(std::size_t i) const {
  const SharedDistance shared = impl_->shared.at(i);
  if (shared.count == 0) return 0.0;
  const Constraints& constraints = impl_->run.system->constraints();
  return constraints.tension(shared.number, impl_->run.reactions.configuration_force,
                             constraints.configuration(impl_->run.state().position)) /
         static_cast<double>(shared.count);
}
Vector Session::external_force() const {
  const Vector& force = impl_->run.progress.external_force;
  // It is empty where there are none.
  return force.size() > 0 ? force : Vector(Vector::Zero(impl_->run.system->dof_count()));
}
Vector Session::next_external_force() const {
  return tetraction::next_external_force(impl_->run);
}
const std::vector<Index>& Session::constraint_vertices(std::size_t i) const {
  static const std::vector<Index> none;
  const ConstraintObject& object = impl_->run.settings.constraints.others.at(i);
  if (const auto* held = std::get_if<PrescribedVertices>(&object)) return held->vertices;
  if (const auto* guided = std::get_if<GuidedVertices>(&object)) return guided->vertices;
  if (const auto* handle = std::get_if<RigidHandle>(&object)) return handle->vertices;
  return none;
}
const Vector& Session::reaction_force() const {
  return impl_->run.reactions.force;
}
const Vector& Session::reaction_delay() const {
  return impl_->run.reactions.delay;
}
const std::vector<ObstacleForce>& Session::obstacle_forces() const {
  return impl_->run.progress.obstacle_forces;
}
int Session::last_iterations() const {
  return impl_->run.progress.last_report.iterations;
}
Index Session::total_iterations() const {
  return impl_->run.progress.total_iterations;
}
Index Session::total_factorizations() const {
  return impl_->run.progress.total_factorizations;
}
Index Session::total_cg_iterations() const {
  return impl_->run.progress.total_cg_iterations;
}
const std::string& Session::linear_solver() const {
  return impl_->run.progress.linear_solver;
}
const std::string& Session::solver_message() const {
  return impl_->run.progress.last_report.message;
}
PhaseTimes Session::times() const {
  PhaseTimes times = impl_->run.times;
  times.output += impl_->observed_seconds();
  return times;
}
void Session::add_mesh_time(double seconds) {
  impl_->run.times.mesh += seconds;
}
void Session::add_times(const PhaseTimes& earlier) {
  PhaseTimes& times = impl_->run.times;
  times.mesh += earlier.mesh;
  times.setup += earlier.setup;
  times.stability += earlier.stability;
  times.stepping += earlier.stepping;
  times.output += earlier.output;
}
const ProbeSet& Session::probes() const {
  return *impl_->probes;
}
const State& Session::present_state() const {
  return impl_->run.state();
}
const Vector& Session::present_external_force() const {
  return impl_->run.progress.external_force;
}

double Session::constraint_error() const {
  const State& state = impl_->run.state();
  if (impl_->equilibrium) return impl_->equilibrium->constraint_error(state);
  return largest_of_parts(impl_->run.system->part(),
                          impl_->run.system->constraints().error(state.position, state.time));
}

const StepFailure* Session::failure() const {
  const RunStatus status = impl_->run.progress.status;
  const bool failed = status == RunStatus::kUnstable || status == RunStatus::kNotConverged;
  return failed && impl_->failed_step ? &*impl_->failed_step : nullptr;
}

bool Session::may_invert() const {
  return tetraction::may_invert(impl_->run.scene, *impl_->run.system);
}

const StepControl& Session::step_control() const {
  return impl_->run.progress.control;
}

bool Session::may_repeat_steps() const {
  return any_time_settings(impl_->run,
                           [](const TimeSettings& t) { return t.retry > 0 || adapts(t); });
}

bool Session::may_adapt(StepAdaptation adaptation) const {
  return any_time_settings(impl_->run,
                           [&](const TimeSettings& t) { return t.adapt == adaptation; });
}

void Session::land_at(double time) {
  impl_->run.landing = time;
}

}  // namespace tetraction
