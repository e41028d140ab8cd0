// [mesh], [time], [solver], [environment], [damping], [initial], [output]
#include "tetraction/simulation/setting_keys.h"

#include <fmt/format.h>

#include "core/quoting.h"

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
constexpr NumberRange kCount{.least = 1.0};
// Of a step. Parts of h/2³⁰ are below the round-off of most times.
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

bool adapts(const TimeSettings& time) {
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

constexpr const char* kLinear = "linear";
constexpr const char* kQuadratic = "quadratic";

std::vector<const char*> length_unit_names() {
  std::vector<const char*> names;
  for (const LengthUnit& unit : length_units()) names.push_back(unit.name);
  return names;
}

}  // namespace

template <>
const Section<MeshSettings>& section_of() {
  using S = MeshSettings;
  static const Section<S> section{
      "mesh",
      {{{.name = "file",
         .help =
             "a tetrahedral mesh; a relative path starts at the scene's folder. `.vtu`, `.vtk`, "
             "`.msh` (Gmsh 1, 2 and 4.1), `.node` or `.ele` (TetGen), `.veg` (Vega)"},
        ByHand{"text"}},
       {{.name = "generate", .help = "a mesh made on the spot, see below"}, ByHand{"table"}},
       {{.name = "scale",
         .help = "multiplies the file's coordinates (0.001 for a mesh in millimetres); for files "
                 "only",
         .range = kModeratePositive,
         .in_file = Written::kUnlessDefault},
        &S::scale},
       {{.name = "element",
         .help =
             "four-node or ten-node tetrahedra. A linear mesh gets vertices in the middles of its "
             "edges ([see below](#quadratic-tetrahedra))",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{{kLinear, kQuadratic},
                  {},
                  [](const S& s) { return std::string(s.quadratic ? kQuadratic : kLinear); },
                  [](S& s, const std::string& name) { s.quadratic = name == kQuadratic; }}},
       {{.name = "unit",
         .help = "of the file's coordinates, which are then multiplied by `scale`; for files only",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{length_unit_names(),
                  {},
                  [](const S& s) { return s.unit; },
                  [](S& s, const std::string& name) { s.unit = name; }}},
       {{.name = "volume",
         .help = "where the volumetric part of the energy is taken: in each tetrahedron, or with "
                 "averages at the vertices, which do not lock where ν is near ½ "
                 "([see below](#nearly-incompressible-materials))",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{{to_string(VolumeRule::kElement), to_string(VolumeRule::kNodal)},
                  {},
                  [](const S& s) { return std::string(to_string(s.volume)); },
                  [](S& s, const std::string& name) {
                    s.volume = name == to_string(VolumeRule::kNodal) ? VolumeRule::kNodal
                                                                     : VolumeRule::kElement;
                  }}}}};
  return section;
}

template <>
const Section<GeneratorSettings>& section_of() {
  using S = GeneratorSettings;
  static const Section<S> section{
      "mesh.generate",
      {{{.name = "kind",
         .help = "the shape",
         .needed = "\"beam\", \"box\", \"cube\" or \"tetrahedron\"."},
        Choice<S>{{"beam", "box", "cube", "tetrahedron"},
                  {},
                  [](const S& s) { return to_string(s.kind); },
                  [](S& s, const std::string& name) {
                    for (const GeneratorKind kind :
                         {GeneratorKind::kBeam, GeneratorKind::kBox, GeneratorKind::kCube,
                          GeneratorKind::kTetrahedron}) {
                      if (name == to_string(kind)) s.kind = kind;
                    }
                  }}},
       {{.name = "size",
         .help = "of `beam` and `box` the lengths along x, y and z, which must be given; of `cube` "
                 "and `tetrahedron` the length of an edge; above 0",
         .absent = "`1` for an edge"},
        ByHand{"three numbers or one, m"}},
       {{.name = "cells",
         .help = "of `beam` and `box` the numbers of cells along x, y and z, of `cube` the number "
                 "along each edge; 1 or more",
         .absent = "must be given"},
        ByHand{"three whole numbers or one"},
        [](const S& s) { return s.kind != GeneratorKind::kTetrahedron; }}},
      {},
      true};
  return section;
}

template <>
const Section<TimeSettings>& section_of() {
  using S = TimeSettings;
  static const Section<S> section{
      "time",
      {{{.name = "integrator", .title = "Integrator", .help = "the time-stepping rule"},
        Choice<S>{
            integrator_names(),
            {},
            [](const S& s) { return to_string(s.integrator); },
            [](S& s, const std::string& name) { s.integrator = integrator_from_string(name); }}},
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
                 "nearest of the "
                 "bounds, is the first one",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{
            step_adaptation_names(),
            {},
            [](const S& s) { return to_string(s.adapt); },
            [](S& s, const std::string& name) { s.adapt = step_adaptation_from_string(name); }}},
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
        adapts},
       {{.name = "max_step",
         .unit = "s",
         .help = "of `adapt`: the largest step",
         .range = kPositive,
         .absent = "100 times `step`; with `\"energy\"` 10 times"},
        &S::max_step,
        adapts}},
      {{{"step"}, automatic_step_conflict},
       {{"retry"}, retry_conflict},
       {{"adapt"}, adaptation_conflict},
       {{"max_step"}, step_range_conflict}}};
  return section;
}

template <>
const Section<SolverSettings>& section_of() {
  using S = SolverSettings;
  static const Section<S> section{
      "solver",
      {{{.name = "engine",
         .help = "how one process computes a run: as this manual says (`local`), or with the "
                 "engine for several processes (`petsc`), which `mpirun` with two or more "
                 "processes always takes ([parallel.md](parallel.md))"},
        Choice<S>{{"local", "petsc"},
                  {},
                  [](const S& s) { return s.engine; },
                  [](S& s, const std::string& name) { s.engine = name; }}},
       {{.name = "kind", .help = "the minimiser of each implicit step"},
        Choice<S>{{"newton", "ceres"},
                  {},
                  [](const S& s) { return s.kind; },
                  [](S& s, const std::string& name) { s.kind = name; }}},
       {{.name = "linear", .help = "of `newton` only: how its linear systems are solved"},
        Choice<S>{
            linear_solver_names(),
            {},
            [](const S& s) { return to_string(s.linear); },
            [](S& s, const std::string& name) { s.linear = linear_solver_from_string(name); }}},
       {{.name = "tolerance",
         .title = "Tolerance",
         .help = "largest force residual relative to the step's force scale",
         .range = kTolerance},
        &S::tolerance},
       {{.name = "max_iterations",
         .title = "Most iterations",
         .help = "most iterations of one step",
         .range = kCount},
        &S::max_iterations}},
      {{{"engine"}, solver_engine_conflict},
       {{"kind"}, solver_kind_conflict},
       {{"linear"}, solver_conflict}}};
  return section;
}

template <>
const Section<EnvironmentSettings>& section_of() {
  using S = EnvironmentSettings;
  static const Section<S> section{
      "environment",
      {{{.name = "kind",
         .help = "the force field around the body; without an `[environment]` there is none",
         .needed = "\"none\", \"gravity\" or \"attraction\"."},
        Choice<S>{{"none", "gravity", "attraction"},
                  {},
                  [](const S& s) { return to_string(s.kind); },
                  [](S& s, const std::string& name) {
                    for (const auto kind : {EnvironmentKind::kNone, EnvironmentKind::kGravity,
                                            EnvironmentKind::kAttraction}) {
                      if (name == to_string(kind)) s.kind = kind;
                    }
                  }}},
       {{.name = "strength",
         .unit = "m/s² or N m²",
         .help = "g of gravity in m/s², k of attraction in N m²",
         .range = kStrength},
        &S::strength,
        nullptr,
        strength_unit},
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
      {{{"direction"}, direction_conflict}, {{"amplitude"}, amplitude_conflict}}};
  return section;
}

template <>
const Section<Damping>& section_of() {
  using S = Damping;
  static const Section<S> section{
      "damping",
      {{{.name = "drag",
         .title = "Drag",
         .unit = "kg/s",
         .per = "per vertex",
         .help = "k_D: force −k_D v on every vertex, whatever its mass",
         .range = kDampingRange},
        &S::drag},
       {{.name = "mass_damping",
         .title = "Mass damping",
         .unit = "1/s",
         .help = "a: force −a m v; the momentum of a free body decays as exp(−at)",
         .range = kDampingRange},
        &S::mass_damping},
       {{.name = "viscosity",
         .title = "Viscosity",
         .unit = "Pa s",
         .help = "η: internal stress 2ηĖ (Kelvin–Voigt), which takes energy but no momentum",
         .range = kDampingRange},
        &S::viscosity},
       {{.name = "ratio",
         .help =
             "`{ at = [f1, f2], value = [ζ1, ζ2] }`: damping ratios at two frequencies in Hz, "
             "from which mass damping and viscosity are worked out, see below; not beside them"},
        ByHand{"table"}}}};
  return section;
}

template <>
const Section<InitialSettings>& section_of() {
  using S = InitialSettings;
  static const Section<S> section{
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
         .help =
             "`[[initial.momentum]]`: momenta of single vertices, instead of what they had, see "
             "below"},
        ByHand{"tables"}},
       {{.name = "displacement",
         .unit = "m",
         .help = "of the whole body, or [of each vertex](#initial-fields)",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        VectorOrField<S>{&S::displacement, &S::displacement_field}},
       {{.name = "static",
         .help = "whether the body starts at its equilibrium under the loads at t = 0, see below",
         .in_file = Written::kUnlessDefault},
        &S::is_static}}};
  return section;
}

}  // namespace tetraction
