// How far a run has come: its steps, its edits, and what was counted on the way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {

/// The state of a run, or how it ended. Its names are the words of summary.json and study.csv.
enum class RunStatus {
  kRunning,
  kFinished,      ///< the end time was reached
  kUnstable,      ///< the energy or the positions blew up, or an element inverted
  kNotConverged,  ///< an implicit step's minimisation did not converge, an event could not be made,
                  ///< or a material or force term of the program threw an exception
  kCancelled      ///< an observer asked to stop
};
template <>
struct EnumNames<RunStatus> {
  static constexpr std::array names{"running", "ok", "unstable", "failed", "interrupted"};
};

/// Exit code of a program whose run ended with this status: 0 finished, 1 failed numerically, 130
/// interrupted.
int exit_code(RunStatus status);

/// An edit that was made, or an event with all its edits.
struct AppliedEdit {
  double at = 0.0;           ///< requested time, s
  double time = 0.0;         ///< time of the state that it changed, s
  Index step = 0;            ///< step number of that state
  std::string what;          ///< as JSON text
  double energy_jump = 0.0;  ///< jump of the total energy, J, which is edit work
  std::string warning;       ///< for the user, or empty
};

/// The sizes of the steps of a run so far.
struct StepRange {
  double smallest = 0.0;  ///< s; does not count a last step that the end made shorter
  double largest = 0.0;   ///< s
  double last = 0.0;      ///< length of the last step, s
  Index changes = 0;      ///< how often the size of the steps changed
};

/// Elements with J < 0, which only some materials allow (St Venant–Kirchhoff and custom ones).
struct InvertedElements {
  Index now = 0;            ///< in the present state
  Index most = 0;           ///< largest number so far
  Index most_step = 0;      ///< first step with that number
  std::int64_t first = -1;  ///< number of the first one in the mesh file; −1: there was none
  double first_time = 0.0;  ///< when it was found, s
};

/// The memory of time.step = "auto" of its estimates of the stability limit.
struct AutomaticStepMemory {
  static constexpr std::size_t kRemembered = 8;

  CriticalModes modes;         ///< with which the next estimate begins
  double critical_step = 0.0;  ///< the limit at the last estimate, s
  double rate = 0.0;           ///< |d ln h_crit| per step
  Index last = 0;              ///< step of the last estimate
  Index next = 0;              ///< step of the next one
  Index interval = 0;
  std::array<double, kRemembered> recent{};  ///< limits, s; the oldest is replaced first
  std::size_t known = 0;                     ///< number of limits since the beginning
  double largest_change = 0.0;               ///< of the energy error in a recent step, J
  bool grows = false;
  double elastic_energy = 0.0;              ///< after the last step, J
  double elastic_energy_at_estimate = 0.0;  ///< J
  double sensitivity = 0.0;                 ///< |d ln h_crit / d ln W| between the last estimates
};

/// The memory of adaptive steps of earlier ones (time.adapt).
struct AdaptiveStepMemory {
  double last_error = 0.0;  ///< of the last step, divided by the tolerance; 0: not known
  bool has_energy = false;  ///< whether there is a discrete energy to keep
  double energy = 0.0;      ///< this energy with the work since then, J
  double half_work = 0.0;   ///< half of the work in the last step, J
};

/// The outcome of the choice of steps (time.retry and time.adapt).
struct StepControl {
  Index retried = 0;           ///< steps that were made in smaller ones
  Index rejected = 0;          ///< attempts that were not accepted, those that failed included
  Index failed = 0;            ///< attempts that failed
  Index above_tolerance = 0;   ///< steps of the smallest size whose error was above the tolerance
  Index without_solution = 0;  ///< steps of which no size keeps the discrete energy
  // Numbers of the last step.
  Index last_rejected = 0;
  Index last_substeps = 0;       ///< steps of the rule that it consists of
  double last_error = 0.0;       ///< its estimated error over the body's diagonal
  double discrete_energy = 0.0;  ///< of kEnergy, J
  double energy_residual = 0.0;  ///< of kEnergy: by how much it missed the energy to keep, J
};

/// Steps of equal size, counted since the start or since the size was set last. Step k of them ends
/// at segment_time + k time_step, so that times have no accumulated round-off.
struct StepPlan {
  double time_step = 0.0;     ///< s
  double segment_time = 0.0;  ///< where they begin, s
  Index segment_step = 0;     ///< number of the step before the first one
  Index segment_count = 0;    ///< number of steps up to the end of the run
  AutomaticStepMemory automatic;
  AdaptiveStepMemory adaptive;
};

/// Everything that a run counts and plans.
struct RunProgress {
  RunStatus status = RunStatus::kRunning;
  std::string message;
  StepPlan plan;
  double first_time_step = 0.0;  ///< of "auto", at the start or the last edit, s
  StepRange steps;
  std::size_t next_event = 0;  ///< number of the scene's events that were made
  std::vector<AppliedEdit> edits;
  std::vector<std::string> warnings;
  InvertedElements inverted;
  std::string passed_center;  ///< note about the last vertex that was near a singular centre
  Vector external_force;      ///< in the last step, N; empty if there is none
  std::vector<ObstacleForce> obstacle_forces;  ///< in the last step, see Session::obstacle_forces()
  MinimizerReport last_report;
  Index total_iterations = 0;
  Index total_factorizations = 0;
  Index total_cg_iterations = 0;
  std::string linear_solver;  ///< used last
  StepControl control;
};

}  // namespace tetraction
