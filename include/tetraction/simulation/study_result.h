// What a study finds: a row for each run, the references, and what follows from them.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/study_choice.h"

namespace tetraction {

/// The role of a row of a study.
enum class StudyRole {
  kRun,        ///< a run that was asked for; it may serve as the reference, too
  kReference,  ///< a run that only serves as a reference, or tells the error of one
  /// A run that was asked for, of another variant than its reference, with another solver; its differences show
  /// what that changes.
  kVariant,
  kTrial  ///< a run that was only made to choose the steps of the others
};
template <>
struct EnumNames<StudyRole> {
  static constexpr const char* noun = "a role of a run";
  static constexpr std::array names{"run", "reference", "variant", "trial"};  // of study.csv
};

/// A reference that is extrapolated from runs of one integrator with the steps 2h, h and h/2.
///
/// With the theoretical order p, E(h) = q(h/2) + (q(h/2) − q(h))/(2^p − 1) removes the leading term
/// of the error of q (L. F. Richardson, Phil. Trans. R. Soc. A 210, 1911; E. Hairer, S. P. Nørsett,
/// G. Wanner, Solving Ordinary Differential Equations I, II.9). The error of E(h) is estimated at
/// |E(h) − E(2h)|/(2^(p+1) − 1), since it is of order p + 1 or higher. This applies to the positions
/// at the times of MotionTrack, and by itself to the values of the error probe.
///
/// The extrapolation is not valid if a run did not reach the end, or if the observed order
/// log2(|q(2h) − q(h)|/|q(h) − q(h/2)|), at the end or over time, differs from p by more than 0.4. The
/// reference is then the run with h/2. Differences that the solver's tolerance or round-off explains show no
/// order, and say nothing against p. If all are of that kind, the runs are equal as far as they are exact: the
/// run with h/2 is the reference, and its error is estimated at the largest of these differences.
struct ReferenceExtrapolation {
  double step = 0.0;     ///< h, s
  bool is_valid = true;  ///< whether the reference of the positions is the extrapolation
  std::string reason{};  ///< why it is not valid, as the end of a sentence
  /// The same of the error probe. Without one it is valid.
  bool probe_is_valid = true;
  std::string probe_reason{};
  /// Whether the solver's tolerance and round-off explain the differences of the runs.
  bool is_exact = false;
  bool probe_is_exact = false;
  /// Observed orders of the positions at the end, of those over time, and of the error probe. NaN if
  /// there is none.
  double order_at_end = std::numeric_limits<double>::quiet_NaN();
  double order_over_time = std::numeric_limits<double>::quiet_NaN();
  double order_of_probe = std::numeric_limits<double>::quiet_NaN();
  /// Estimated errors of the reference as position_error, position_error_rms and probe_error. They
  /// are those of the extrapolation, or of the run with h/2 if that is the reference:
  /// |q(h/2) − q(h)|/(2^p − 1), without the divisor if the run with h/2 is exact. NaN if they are not
  /// known. That of the probe includes the error of its linear interpolation between the steps h/2 if a step of
  /// the study is no multiple of h/2.
  double error_at_end = std::numeric_limits<double>::quiet_NaN();
  double error_over_time = std::numeric_limits<double>::quiet_NaN();
  double error_of_probe = std::numeric_limits<double>::quiet_NaN();
  /// Error of the run with h/2, |q(h/2) − E(h)|, as position_error. NaN if E is not valid.
  double finest_error_at_end = std::numeric_limits<double>::quiet_NaN();

  /// Whether the errors of the probe, or those of the positions, are differences from the
  /// extrapolation.
  bool is_valid_for(bool probe) const { return probe ? probe_is_valid : is_valid; }
};

/// How far the motion of a variant is from that of the first one: the difference between their
/// references, relative to the first one. It is no error. All are NaN for the first reference, and if one
/// of the two did not reach the end.
struct ReferenceDifference {
  /// As StudyRow::position_error and position_error_rms. NaN also on another mesh, whose positions cannot
  /// be compared.
  double position = std::numeric_limits<double>::quiet_NaN();
  double position_rms = std::numeric_limits<double>::quiet_NaN();
  /// As StudyRow::probe_error. NaN also without an error probe.
  double probe = std::numeric_limits<double>::quiet_NaN();
};

/// One row of a study.
struct StudyRow {
  std::string variant;  ///< its name; empty without variants
  Integrator integrator = Integrator::kMidpoint;
  double step = 0.0;             ///< s
  std::string solver;            ///< SolverSettings::kind; empty for explicit integrators
  bool compares_solver = false;  ///< one of StudySettings::solver_comparisons
  std::string settings{};        ///< of a rule of its own, as "solver.tolerance=1e-6"; else empty
  double stable_step =
      0.0;  ///< h_crit of the rule at the initial state (implicit: of `explicit`), s
  RunStatus status = RunStatus::kRunning;
  std::string message;
  std::string directory;      ///< of the run, relative to the study's
  Index steps = 0;            ///< steps taken
  double wall_seconds = 0.0;  ///< of the time steps alone
  /// wall_seconds before the run was repeated. The choice of steps counts it, and is the same again.
  double first_seconds = 0.0;
  /// Processor time of the time steps, of all threads together. NaN if several runs with several threads each
  /// were made at the same time, because it is not known then which of them a thread worked for.
  double processor_seconds = std::numeric_limits<double>::quiet_NaN();
  int repeats = 0;  ///< how often the run was made again to see how much its times vary
  /// The largest less the smallest of the processor times of the run and its repeats, relative to their mean. NaN
  /// without repeats. processor_seconds and wall_seconds are those of the fastest one.
  double time_scatter = std::numeric_limits<double>::quiet_NaN();
  /// Whether the run, together with those that were made at the same time, had more threads than the
  /// machine has cores. The wall times then say nothing about the run.
  bool shares_machine = false;
  double seconds_per_simulated_second = 0.0;
  double iterations_per_step = 0.0;
  double max_relative_energy_drift = 0.0;       ///< Balance::max_relative_energy_drift
  double linear_momentum_drift = 0.0;           ///< Balance::linear_momentum_drift
  double angular_momentum_drift = 0.0;          ///< Balance::angular_momentum_drift
  double angular_momentum_drift_allowed = 0.0;  ///< Balance::allowed_angular_momentum_drift
  StudyRole role = StudyRole::kRun;
  /// Whether the errors of the others are differences from this run. Its own ones are zero.
  bool is_reference = false;
  /// |q − q_ref|₂/|q_ref − X|₂ at the end, with the rest positions X. It is NaN unless run and
  /// reference finished. The divisor is at least a tenth of the reference's root mean square
  /// displacement over time, because a body may pass its rest position just at the end. It is also
  /// at least 1e-12 √N times the diagonal of the body (N vertices). The error does not depend on
  /// the place of the origin.
  double position_error = 0.0;
  /// The same error over the whole time: √(mean |q − q_ref|²)/√(mean |q_ref − X|²), with the means over the
  /// times of MotionTrack.
  double position_error_rms = 0.0;
  /// Order between this step and the next finer one of the integrator that was asked for, or NaN if there is
  /// none. It is that of probe_error if the study has an error probe, otherwise that of position_error.
  double observed_order = 0.0;
  /// The error of the study's error probe: max over the times of the run of |s − s_ref|, divided by
  /// the maximum of |s_ref| over the times of the reference. s are the values of the probe as a
  /// vector. Those of the reference are interpolated linearly in time. With StudySettings::error_kind
  /// it is |max|s| − max|s_ref||/max|s_ref| instead, or |f − f_ref|/f_ref with the frequency of the component
  /// that varies most. NaN without an error probe, and unless run and reference finished.
  double probe_error = std::numeric_limits<double>::quiet_NaN();
  /// What that error is the error of: max|s| in the unit of the probe, or f in Hz. NaN with another error_kind.
  double probe_value = std::numeric_limits<double>::quiet_NaN();
  std::string date{};       ///< when the run began, as utc_now() gives it
  std::string processor{};  ///< Machine::processor of the computer that made the run
  int cores = 0;            ///< its Machine::cores
  int threads = 0;          ///< threads of the parallel loops of the run
};

/// The reference of one or several of the variants of a study.
struct VariantReference {
  std::string variant;                  ///< the first one that is compared with it
  std::vector<std::string> variants{};  ///< all variants that are compared with it
  RunStatus status = RunStatus::kRunning;
  std::string directory;
  double error = std::numeric_limits<double>::quiet_NaN();  ///< as StudyResult::reference_error
  std::optional<ReferenceExtrapolation> extrapolation{};    ///< if one was asked for
  /// From the first reference.
  ReferenceDifference difference{};
};

/// The name of a variant and what makes it differ from the others.
struct VariantValues {
  std::string name;
  std::vector<VariedValue> values;
};

/// What runs that were made to choose steps found for a rule.
struct RuleFinding {
  Integrator rule = Integrator::kMidpoint;
  std::optional<TargetStep> target{};   ///< the largest step that meets StudyResult::target
  std::optional<StableStep> stable{};   ///< the largest stable step of an explicit rule
  std::vector<VariedValue> settings{};  ///< RuleSteps::settings
};

/// How a study came to its steps. What is chosen depends on the scene, on what is asked for, and on the times of runs
/// that are kept. Together with the times here the same study chooses the same steps again.
struct PlannedSteps {
  struct Rule {
    StudyRule rule;
    std::vector<double> steps;  ///< s, ascending
    bool is_chosen = false;     ///< whether some of the steps were not asked for
  };
  double budget = 0.0;  ///< s
  std::vector<Rule> rules{};
  std::map<Integrator, double>
      seconds_per_step{};  ///< StudyRequests::seconds_per_step of the next time
  std::string digest{};  ///< of program, scene and mesh, with which these times count; empty: never
};

/// What a run on a finer mesh tells of the error of the mesh.
struct MeshCheck {
  Integrator integrator = Integrator::kMidpoint;
  double step = 0.0;                       ///< s, of both runs
  Index vertices = 0;                      ///< of the finer mesh
  Index tetrahedra = 0;                    ///< of the finer mesh
  RunStatus status = RunStatus::kRunning;  ///< of the run on the finer mesh
  std::string directory{};                 ///< of that run, relative to the study's
  /// The difference of the two runs as StudyRow::position_error, or of the error probe if there is one,
  /// at the vertices that both meshes have. NaN if it is not known.
  double difference = std::numeric_limits<double>::quiet_NaN();

  /// The error of the mesh, where it falls with the square of the edges: that of the finer mesh is then a third of the
  /// difference.
  double estimated_error() const { return 4.0 / 3.0 * difference; }
};

struct StudyResult {
  double stable_step =
      0.0;           ///< h_crit of `explicit` at the initial state (of the first variant), s
  double end = 0.0;  ///< s
  Integrator reference_integrator = Integrator::kMidpoint;
  double reference_step = 0.0;  ///< with an extrapolation that of its finest run
  RunStatus reference_status = RunStatus::kRunning;
  bool is_interrupted = false;  ///< whether a run was stopped on request: later ones are missing
  std::size_t left_out = 0;     ///< runs of the plan that other parts of the study make
  std::string reference_directory;  ///< with an extrapolation that of its finest run
  /// Error of the reference itself, in the error that the orders are computed from. It is estimated
  /// from the finest other run of its integrator and the theoretical order, or as
  /// ReferenceExtrapolation says. NaN without such a run. It is at least the error of two neighbouring steps of a
  /// rule that agree better than they differ from the reference, but not with ErrorKind::kPeak: the largest samples of
  /// neighbouring steps may agree by chance.
  double reference_error = std::numeric_limits<double>::quiet_NaN();
  std::optional<ReferenceExtrapolation> extrapolation{};  ///< if one was asked for
  /// All references, if there are several. The first one is that which the other members describe.
  std::vector<VariantReference> references{};
  std::vector<VariantValues> variants{};  ///< in their order; empty if nothing is varied
  std::vector<StudyRow> rows;        ///< by variant, by integrator, then from the finest step up
  std::vector<std::string> remarks;  ///< remarks for the user, such as a missing reference
  std::string error_probe{};         ///< StudySettings::error_probe
  ErrorKind error_kind = ErrorKind::kProbe;  ///< StudySettings::error_kind
  std::vector<ProbeColumns> probes{};        ///< of the first variant
  std::optional<double> target{};            ///< the relative error for which steps were searched
  std::vector<RuleFinding> findings{};       ///< of the rules for which there are any
  std::optional<PlannedSteps> plan{};        ///< if steps were chosen
  std::optional<MeshCheck> mesh_check{};     ///< if one was asked for
};

}  // namespace tetraction
