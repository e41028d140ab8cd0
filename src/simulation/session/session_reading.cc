// The functions that read a session.
#include "session_impl.h"

namespace tetraction {
namespace {

// A force of the body, which is empty where there are none, with 3 numbers for each vertex.
Vector padded(const Vector& force, const MechanicalSystem& system) {
  return force.size() > 0 ? force : Vector(Vector::Zero(system.dof_count()));
}

}  // namespace

Analysis Session::analysis() const {
  return impl_->loading ? Analysis::kEquilibrium : Analysis::kMotion;
}
const LoadPath* Session::load_path() const {
  return impl_->loading ? &impl_->loading->path() : nullptr;
}
const Scene& Session::scene() const {
  return impl_->scene;
}
const MechanicalSystem& Session::system() const {
  return *impl_->system;
}
const State& Session::state() const {
  return impl_->states.at_home();
}
double Session::time() const {
  return impl_->state().time;
}
Index Session::step_number() const {
  return impl_->state().step;
}
const Balance& Session::balance() const {
  return *impl_->balance;
}
RunStatus Session::status() const {
  return impl_->progress.status;
}
const std::string& Session::message() const {
  return impl_->progress.message;
}
double Session::time_step() const {
  return impl_->progress.plan.time_step;
}
Index Session::step_count() const {
  return impl_->progress.plan.segment_step + impl_->progress.plan.segment_count;
}
const StepRange& Session::steps() const {
  return impl_->progress.steps;
}
const InvertedElements& Session::inverted_elements() const {
  return impl_->progress.inverted;
}
const StabilityLimit& Session::initial_limit() const {
  return impl_->initial_limit;
}
StabilityLimit Session::current_limit() const {
  return impl_->limit_at(impl_->state().position);
}
const std::vector<std::string>& Session::warnings() const {
  return impl_->progress.warnings;
}
const std::vector<AppliedEdit>& Session::edits() const {
  return impl_->progress.edits;
}
const TimeSettings& Session::time_settings() const {
  return impl_->settings.time;
}
const SolverSettings& Session::solver_settings() const {
  return impl_->settings.solver;
}
const std::vector<MaterialSettings>& Session::materials() const {
  return impl_->settings.materials;
}
const Damping& Session::damping() const {
  return impl_->settings.damping;
}
const EnvironmentSettings& Session::environment() const {
  return impl_->settings.environment;
}
const std::vector<ForceSettings>& Session::forces() const {
  return impl_->settings.loads.force;
}

const LoadLists& Session::loads() const {
  return impl_->settings.loads;
}
std::size_t Session::fix_count() const {
  return impl_->settings.constraints.fixes.size();
}
PresentFix Session::fix(std::size_t i) const {
  const PrescribedVertices& held = impl_->settings.constraints.fixes.at(i);
  // In an equilibrium the targets are those at the full loads.
  const double time = impl_->loading ? 0.0 : impl_->state().time;
  PresentFix fix{impl_->settings.constraints.fix_settings.at(i), held.vertices, held.start};
  for (Index v = 0; v < fix.targets.cols(); ++v) {
    fix.targets.col(v) = held.motion.position(held.start.col(v), time);
  }
  return fix;
}
const std::vector<std::optional<ConstraintSettings>>& Session::constraints() const {
  return impl_->settings.constraints.other_settings;
}
double Session::tension(std::size_t i) const {
  const SharedDistance shared = impl_->shared.at(i);
  if (shared.count == 0) return 0.0;
  const Constraints& constraints = impl_->system->constraints();
  return constraints.tension(shared.number, impl_->reactions.configuration_force,
                             constraints.configuration(impl_->state().position)) /
         static_cast<double>(shared.count);
}
Vector Session::external_force() const {
  return padded(impl_->progress.external_force, *impl_->system);
}
Vector Session::next_external_force() const {
  return impl_->next_external_force();
}
Vector Session::Impl::next_external_force() const {
  if (loading) return padded(progress.external_force, *system);
  Vector force;
  system->applied_force(state().position, state().time, progress.plan.time_step, force);
  return padded(force, *system);
}
const std::vector<Index>& Session::constraint_vertices(std::size_t i) const {
  static const std::vector<Index> none;
  const ConstraintObject& object = impl_->settings.constraints.others.at(i);
  if (const auto* held = std::get_if<PrescribedVertices>(&object)) return held->vertices;
  if (const auto* guided = std::get_if<GuidedVertices>(&object)) return guided->vertices;
  if (const auto* handle = std::get_if<RigidHandle>(&object)) return handle->vertices;
  return none;
}
const Vector& Session::reaction_force() const {
  return impl_->reactions.force;
}
const Vector& Session::reaction_delay() const {
  return impl_->reactions.delay;
}
int Session::last_iterations() const {
  return impl_->progress.last_report.iterations;
}
Index Session::total_iterations() const {
  return impl_->progress.total_iterations;
}
Index Session::total_factorizations() const {
  return impl_->progress.total_factorizations;
}
Index Session::total_cg_iterations() const {
  return impl_->progress.total_cg_iterations;
}
const std::string& Session::linear_solver() const {
  return impl_->progress.linear_solver;
}
const std::string& Session::solver_message() const {
  return impl_->progress.last_report.message;
}
PhaseTimes Session::times() const {
  PhaseTimes times = impl_->times;
  times.output += impl_->observed_seconds();
  return times;
}
void Session::add_mesh_time(double seconds) {
  impl_->times.mesh += seconds;
}
void Session::add_times(const PhaseTimes& earlier) {
  PhaseTimes& times = impl_->times;
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
  return impl_->state();
}
const Vector& Session::present_external_force() const {
  return impl_->progress.external_force;
}

double Session::constraint_error() const {
  const State& state = impl_->state();
  if (impl_->loading) {
    return impl_->equilibrium_problem->constraint_error(state.time, state.position);
  }
  return largest_of_parts(impl_->system->part(),
                          impl_->system->constraints().error(state.position, state.time));
}

}  // namespace tetraction
