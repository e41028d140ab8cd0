// [time], [solver], [environment], [damping], [pull], [initial], [output]

#include <fmt/format.h>

#include <cmath>

#include "body_loads.h"
#include "core/quoting.h"
#include "number_or_array.h"
#include "sections.h"
#include "setting_values.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

// The message gives the usual value, because most people do not know one.
constexpr NumberRange kTolerance{.least = 0.0,
                                 .most = 1.0,
                                 .least_itself = false,
                                 .most_itself = false,
                                 .advice = "; 1e-8 is usual"};
constexpr NumberRange kStrength{
    .least = 0.0, .is_moderate = true, .advice = "; turn it with environment.direction"};
// Halvings of a step. Parts of h/2³⁰ are below the round-off of most times.
constexpr NumberRange kHalvings{.least = 0.0, .most = 30.0};
// Smaller errors are below the round-off of positions.
constexpr NumberRange kStepTolerance{
    .least = 1e-12, .most = 1.0, .most_itself = false, .advice = "; 1e-4 is usual"};

std::string automatic_step_conflict(const TimeSettings& time) {
  if (!time.automatic || !is_implicit(time.integrator)) return {};
  return fmt::format(
      "= \"auto\" is for the integrators explicit and verlet: {} has no stability limit to take "
      "half of. Give a number of seconds.",
      to_string(time.integrator));
}

std::string retry_conflict(const TimeSettings& time) {
  if (time.retry == 0) return {};
  if (time.adapt != StepAdaptation::kNone) {
    return fmt::format(
        "= {} is for steps of a given size: adapt = \"{}\" makes a step that fails smaller by "
        "itself. Leave one of them out.",
        time.retry, to_string(time.adapt));
  }
  if (time.automatic) {
    return fmt::format(
        "= {} is for steps of a given size: step = \"auto\" makes a step that fails smaller by "
        "itself. Leave one of them out.",
        time.retry);
  }
  return {};
}

std::string adaptation_conflict(const TimeSettings& time) {
  if (time.adapt != StepAdaptation::kEnergy) return {};
  if (is_implicit(time.integrator) && is_variational(time.integrator)) return {};
  std::string able;
  for (const Integrator rule : all_integrators()) {
    if (!is_implicit(rule) || !is_variational(rule)) continue;
    able += (able.empty() ? "" : ", ") + to_string(rule);
  }
  return fmt::format(
      "= \"energy\" is for implicit rules that follow from a discrete action ({}), of which {} is "
      "none. Take such a rule, or adapt = \"error\".",
      able, to_string(time.integrator));
}

std::string step_range_conflict(const TimeSettings& time) {
  if (time.adapt == StepAdaptation::kNone) return {};
  if (time.min_step && time.max_step && *time.min_step > *time.max_step) {
    return fmt::format("= {} s is below min_step = {} s.", *time.max_step, *time.min_step);
  }
  return {};
}

bool has_adaptive_steps(const TimeSettings& time) {
  return time.adapt != StepAdaptation::kNone;
}

// The reader refuses such a name before; a program may set it.
std::string solver_kind_conflict(const SolverSettings& solver) {
  if (solver.kind == "newton" || solver.kind == "ceres") return {};
  return fmt::format("= {} is not a solver; there are newton and ceres.", in_quotes(solver.kind));
}

std::string solver_engine_conflict(const SolverSettings& solver) {
  if (solver.engine == "local" || solver.engine == "petsc") return {};
  return fmt::format("= {} is not an engine; there are local and petsc.", in_quotes(solver.engine));
}

std::string direction_conflict(const EnvironmentSettings& environment) {
  return environment.direction.isZero(0.0) ? "must not be zero; [0, -1, 0] is downward." : "";
}

std::string amplitude_conflict(const EnvironmentSettings& environment) {
  return environment.kind == EnvironmentKind::kNone && !environment.amplitude.empty()
             ? "has no effect without an environment: choose a kind, or leave it out."
             : "";
}

// Vertices that are pulled, of which there may be none: then nothing acts.
class PulledVertices : public MemberValue<PullSettings, std::vector<std::int64_t>> {
 public:
  PulledVertices() : MemberValue(&PullSettings::vertices) {}
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    if (node.is_array() && node.empty()) {
      static_cast<PullSettings*>(settings)->vertices.clear();
    } else {
      MemberValue::read(node, range, refuse, settings);
    }
  }
};

std::string pull_conflict(const PullSettings& pull) {
  const bool acts = pull.stiffness > 0.0 || pull.damping > 0.0;
  return acts && pull.vertices.empty() ? "must name the vertices that the spring pulls." : "";
}

const char* strength_unit(const EnvironmentSettings& environment) {
  switch (environment.kind) {
    case EnvironmentKind::kGravity:
      return "m/s²";
    case EnvironmentKind::kAttraction:
      return "N m²";
    case EnvironmentKind::kNone:
    case EnvironmentKind::kCustom:
      break;
  }
  return "";
}

}  // namespace

std::string one_key_too_many(std::string_view first, std::string_view second,
                             std::string_view why) {
  return fmt::format("is one key too many: {} and {} are both given{}. Leave one of the two out.",
                     first, second, why);
}

SceneSection time_section() {
  using S = TimeSettings;
  SceneSection section = make_section<S>(
      "time",
      {{{.name = "integrator", .title = "Integrator", .help = "the time-stepping rule"},
        &S::integrator},
       {{.name = "step",
         .title = "Step size",
         .unit = "s",
         .help = "the length of a step, or with `explicit` and `verlet` `\"auto\"`: half of the "
                 "stability limit",
         .range = kPositive},
        NumberOrAuto<S>{&S::step, &S::automatic}},
       {{.name = "end",
         .unit = "s",
         .help = "met exactly: where `step` does not divide it, the last step is shorter",
         .range = kPositive},
        &S::end},
       {{.name = "retry",
         .help = "how often a step that fails may be halved, see below; 0 ends the run there",
         .range = kHalvings,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::retry},
       {{.name = "adapt",
         .help = "how the size of the steps adapts to the motion, see below; `step`, or the "
                 "nearest of the bounds, is the first one",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::adapt},
       {{.name = "tolerance",
         .help = "of `adapt = \"error\"`: largest error of the positions in a step, divided by the "
                 "diagonal of the body's box at rest",
         .range = kStepTolerance,
         .in_file = Written::kUnlessDefault},
        &S::tolerance,
        [](const S& s) { return s.adapt == StepAdaptation::kError; }},
       {{.name = "min_step",
         .unit = "s",
         .help = "of `adapt`: the smallest step",
         .range = kPositive,
         .absent = "a millionth of `step`; with `\"energy\"` a tenth"},
        &S::min_step,
        has_adaptive_steps},
       {{.name = "max_step",
         .unit = "s",
         .help = "of `adapt`: the largest step",
         .range = kPositive,
         .absent = "100 times `step`; with `\"energy\"` 10 times"},
        &S::max_step,
        has_adaptive_steps}},
      {{{"step"}, automatic_step_conflict},
       {{"retry"}, retry_conflict},
       {{"adapt"}, adaptation_conflict},
       {{"max_step"}, step_range_conflict}});
  section.unwritable = [](const void* settings) -> std::string {
    if (std::isfinite(static_cast<const S*>(settings)->end)) return {};
    return "The run has no end, which a scene file must give: set time.end.";
  };
  return section;
}

SceneSection solver_section() {
  using S = SolverSettings;
  return make_section<S>(
      "solver",
      {{{.name = "engine",
         .help = "how one process computes a run: as this manual says (`local`), or with the "
                 "engine for several processes (`petsc`), which `mpirun` with two or more "
                 "processes always takes ([parallel.md](parallel.md))"},
        Choice<S>{{"local", "petsc"}, &S::engine}},
       {{.name = "kind", .help = "the minimiser of each implicit step"},
        Choice<S>{{"newton", "ceres"}, &S::kind}},
       {{.name = "linear", .help = "of `newton` only: how its linear systems are solved"},
        &S::linear},
       {{.name = "tolerance",
         .title = "Tolerance",
         .help = "largest force residual relative to the step's force scale",
         .range = kTolerance},
        &S::tolerance},
       {{.name = "max_iterations",
         .title = "Most iterations",
         .help = "most iterations of one step",
         .range = kAtLeastOne},
        &S::max_iterations}},
      {{{"engine"}, solver_engine_conflict},
       {{"kind"}, solver_kind_conflict},
       {{"linear"}, solver_conflict}});
}

SceneSection environment_section() {
  using S = EnvironmentSettings;
  SceneSection section = make_section<S>(
      "environment",
      {{{.name = "kind",
         .help = "the force field around the body; without an `[environment]` there is none",
         .needed = "\"none\", \"gravity\" or \"attraction\"."},
        &S::kind},
       {{.name = "strength",
         .unit = "m/s² or N m²",
         .help = "g of gravity in m/s², k of attraction in N m²",
         .range = kStrength},
        &S::strength,
        {.unit = strength_unit}},
       {{.name = "direction",
         .title = "Direction of gravity",
         .help = "of gravity; any length but zero"},
        &S::direction},
       {{.name = "softening",
         .title = "Softening",
         .unit = "m",
         .help = "ε of attraction, which bounds the force near the origin",
         .range = kModerateNotNegative},
        &S::softening},
       {{.name = "amplitude",
         .help = "name of an `[[amplitude]]`, the factor of the strength",
         .absent = "the factor 1"},
        &S::amplitude}},
      {{{"direction"}, direction_conflict}, {{"amplitude"}, amplitude_conflict}});
  section.unwritable = [](const void* settings) -> std::string {
    if (static_cast<const S*>(settings)->kind != EnvironmentKind::kCustom) return {};
    return "The environment is a program's own force field: a scene file cannot name it. Take "
           "none, gravity or attraction.";
  };
  section.put_into = [](const void* settings, MechanicalSystem& system,
                        const std::vector<AmplitudeSettings>& amplitudes) {
    system.set_environment(make_environment(*static_cast<const S*>(settings), amplitudes));
  };
  return section;
}

SceneSection damping_section() {
  using S = Damping;
  SceneSection section = make_section<S>(
      "damping",
      {{{.name = "drag",
         .title = "Drag",
         .unit = "kg/s",
         .per = "per vertex",
         .help = "k_D: force −k_D v on every vertex, whatever its mass",
         .range = kDampingRange,
         .usual = 1.0},
        &S::drag},
       {{.name = "mass_damping",
         .title = "Mass damping",
         .unit = "1/s",
         .help = "a: force −a m v; the momentum of a free body decays as exp(−at)",
         .range = kDampingRange,
         .usual = 10.0},
        &S::mass_damping},
       {{.name = "viscosity",
         .title = "Viscosity",
         .unit = "Pa s",
         .help = "η: internal stress 2ηĖ (Kelvin–Voigt), which takes energy but no momentum",
         .range = kDampingRange,
         .usual = 5000.0},
        &S::viscosity},
       {{.name = "ratio",
         .help =
             "`{ at = [f1, f2], value = [ζ1, ζ2] }`: damping ratios at two frequencies in Hz, from "
             "which mass damping and viscosity are worked out, see below; not beside them"},
        DocumentedValue<S>{"table"}}});
  section.put_into = [](const void* settings, MechanicalSystem& system, const auto&) {
    system.set_damping(*static_cast<const S*>(settings));
  };
  return section;
}

SceneSection pull_section() {
  using S = PullSettings;
  SceneSection section = make_section<S>(
      "pull",
      {{{.name = "vertices", .help = "the numbers of the vertices in the mesh file, each once"},
        PulledVertices()},
       {{.name = "target", .unit = "m", .help = "the point to which their mean is pulled"},
        &S::target},
       {{.name = "stiffness",
         .unit = "N/m",
         .help = "k of the spring with the force −k(x̄ − target)",
         .range = kModerateNotNegative},
        &S::stiffness},
       {{.name = "damping",
         .unit = "kg/s",
         .help = "d of the damper with the force −d v̄",
         .range = kModerateNotNegative},
        &S::damping}},
      {{{"vertices"}, pull_conflict}});
  section.put_into = [](const void* settings, MechanicalSystem& system, const auto&) {
    system.set_pull(make_pull(*static_cast<const S*>(settings), system));
  };
  return section;
}

SceneSection initial_section() {
  using S = InitialSettings;
  return make_section<S>(
      "initial",
      {{{.name = "velocity",
         .unit = "m/s",
         .help = "of the whole body, or [of each vertex](#initial-fields)",
         .in_file = Written::kUnlessDefault},
        VectorOrField<S>{&S::velocity, &S::velocity_field}},
       {{.name = "angular_velocity",
         .unit = "rad/s",
         .help = "about the centre of mass of the deformed body",
         .in_file = Written::kUnlessDefault},
        &S::angular_velocity},
       {{.name = "stretch",
         .help = "scales positions about the centre of mass",
         .range = kPositive,
         .in_file = Written::kUnlessDefault},
        &S::stretch},
       {{.name = "displacement_array", .help = "name of a point-data array of the mesh file, in m"},
        &S::displacement_array},
       {{.name = "velocity_array", .help = "name of a point-data array of the mesh file, in m/s"},
        &S::velocity_array},
       {{.name = "momentum",
         .help = "`[[initial.momentum]]`: momenta of single vertices, instead of what they had, "
                 "see below"},
        TablesValue<S, MomentumSettings>{&S::momentum}},
       {{.name = "displacement",
         .unit = "m",
         .help = "of the whole body, or [of each vertex](#initial-fields)",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        VectorOrField<S>{&S::displacement, &S::displacement_field}},
       {{.name = "static",
         .help = "whether the body starts at its equilibrium under the loads at t = 0, see below",
         .in_file = Written::kUnlessDefault},
        &S::is_static}});
}

SceneSection damping_ratio_section() {
  using S = DampingRatio;
  return make_section<S>("damping.ratio",
                         {{{.name = "at",
                            .unit = "Hz",
                            .help = "two frequencies",
                            .range = kModeratePositive,
                            .needed = "give the two frequencies in Hz, for instance ratio = { at = "
                                      "[50, 400], value = [0.01, 0.02] }."},
                           &S::frequency},
                          {{.name = "value",
                            .help = "the damping ratios at these",
                            .range = {.least = 0.0, .most = 100.0},
                            .needed = "give the two damping ratios, for instance ratio = { at = "
                                      "[50, 400], value = [0.01, 0.02] }."},
                           &S::value}});
}

SceneSection array_section() {
  using S = ArrayName;
  return make_section<S>("array", {{{.name = "array",
                                     .help = "a cell array of the mesh file",
                                     .needed = "give the name of a cell array of the mesh file."},
                                    &S::name}});
}

SceneSection field_section() {
  using S = FieldSettings;
  SceneSection section =
      make_section<S>("field",
                      {{{.name = "file", .help = "a table of comma-separated values"}, &S::file},
                       {{.name = "formula", .help = "three formulas of X, Y, Z"}, &S::formula}},
                      {{{}, [](const S& s) -> std::string {
                          if (s.file.empty() != s.formula[0].empty()) return {};
                          return "must have either file = \"…\" or formula = [\"…\", \"…\", "
                                 "\"…\"], which gives x, y and z.";
                        }}});
  section.is_placed_at_key = true;
  return section;
}

}  // namespace tetraction
