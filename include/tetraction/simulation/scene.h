// A scene is the complete description of a run, as plain data. The scene reader (io/scene_reader.h)
// fills it from TOML. A program may fill it by hand. Default values stand here and nowhere else.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/dynamics/nodal_volume/volume_rule.h"
#include "tetraction/dynamics/steppers/integrator.h"
#include "tetraction/dynamics/terms/amplitude.h"
#include "tetraction/dynamics/terms/damping.h"
#include "tetraction/dynamics/terms/rayleigh_damping.h"
#include "tetraction/material/material_field.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/simulation/frame_format.h"
#include "tetraction/simulation/load_settings.h"
#include "tetraction/simulation/material_settings.h"
#include "tetraction/simulation/obstacle_settings.h"
#include "tetraction/simulation/quantities.h"
#include "tetraction/solver/linear_solver.h"

namespace tetraction {

class ForceField;
class ForceTerm;

/// Kinds of meshes that the program can make (mesh/generate.h).
enum class GeneratorKind { kBeam, kBox, kCube, kTetrahedron };

template <>
struct EnumNames<GeneratorKind> {
  static constexpr std::array names{"beam", "box", "cube", "tetrahedron"};
};

struct GeneratorSettings {
  GeneratorKind kind = GeneratorKind::kBeam;
  Vector3 size{1.0, 1.0, 1.0};  ///< m
  std::array<int, 3> cells{1, 1, 1};
};

/// One more body with the same mesh.
struct MeshCopySettings {
  Vector3 at = Vector3::Zero();        ///< displacement, m
  Vector3 turn = Vector3::Zero();      ///< rotation vector about the middle of the mesh, degrees
  Vector3 velocity = Vector3::Zero();  ///< m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s about its centre of mass
};

struct MeshSettings {
  std::string file;                           ///< absolute, or relative to the working directory
  std::optional<GeneratorSettings> generate;  ///< instead of a file
  double scale = 1.0;                         ///< multiplies the file's coordinates
  std::string unit = "m";                     ///< of the file's coordinates, see length_units()
  bool quadratic = false;                     ///< ten-node tetrahedra instead of four-node ones
  VolumeRule volume = VolumeRule::kElement;   ///< where the volumetric part of the energy is taken
  /// Further bodies. read_scene_mesh() adds them to the mesh (mesh/mesh_copies.h).
  std::vector<MeshCopySettings> copies{};
};

/// A unit of length that mesh.unit can name.
struct LengthUnit {
  const char* name;
  double metres;
};
const std::vector<LengthUnit>& length_units();
/// The factor of the coordinates of the mesh file: scale times the unit in m. Throws
/// InputError for an unknown unit.
double coordinate_scale(const MeshSettings& mesh);

/// Another material in a part of the body.
struct MaterialRegionSettings {
  Selection select = SelectAll{};  ///< see select_tetrahedra()
  MaterialSettings material;
  std::string where;  ///< place in the scene, for messages
};

/// Whether the sizes of the steps adapt to the motion.
enum class StepAdaptation {
  kNone,   ///< all steps have the size that was given
  kError,  ///< the error of every step is estimated and kept below a tolerance
  kEnergy  ///< every step has the size that keeps the discrete energy
};
template <>
struct EnumNames<StepAdaptation> {
  static constexpr std::array names{"none", "error", "energy"};
  static constexpr const char* noun = "a way of adapting steps";
};

struct TimeSettings {
  Integrator integrator = Integrator::kMidpoint;
  double step = 1.0e-2;    ///< s; if steps adapt: the first one
  bool automatic = false;  ///< step = "auto": 0.5 of the stability limit (explicit rules only)
  double end = 1.0;        ///< s; infinite (by programs only): the run has no end of its own
  int retry = 0;           ///< how often a step that fails may be halved
  StepAdaptation adapt = StepAdaptation::kNone;
  double tolerance = 1.0e-4;  ///< of kError: error of a step over the body's diagonal
  /// The bounds of adaptive steps, s. If they are absent, these are a millionth and a hundred times
  /// of the first step with kError, and a tenth and ten times of it with kEnergy.
  std::optional<double> min_step{};
  std::optional<double> max_step{};
};

template <>
struct EnumNames<LinearSolver> {
  static constexpr std::array names{"auto", "matrix-free", "cg", "factor"};
  static constexpr const char* noun = "a linear solver";
};

struct SolverSettings {
  std::string kind = "newton";                ///< or "ceres"
  LinearSolver linear = LinearSolver::kAuto;  ///< newton only
  double tolerance = 1.0e-8;                  ///< force residual relative to the step's force scale
  int max_iterations = 100;
  /// Where a run is computed: "local", in this process, or "petsc", in all processes of an MPI run.
  std::string engine = "local";
};

/// If the settings contradict each other: the text of a message about solver.linear. Otherwise
/// empty.
std::string solver_conflict(const SolverSettings& settings);

/// The kinds of amplitudes.
enum class AmplitudeKind { kPoints, kFile, kSine, kSmoothStep };

template <>
struct EnumNames<AmplitudeKind> {
  static constexpr std::array names{"points", "file", "sine", "smooth_step"};
};

/// A factor that changes in time, for loads, the environment and prescribed motions. They refer to
/// it by its name.
struct AmplitudeSettings {
  std::string name;
  AmplitudeKind kind = AmplitudeKind::kPoints;
  /// Time in s and value of each corner; of kFile the contents of the file.
  std::vector<std::pair<double, double>> points;
  std::string file;        ///< of kFile: for messages and for writing the scene
  double frequency = 1.0;  ///< of kSine, Hz
  double phase = 0.0;      ///< of kSine, rad
  double offset = 0.0;     ///< of kSine
  double from = 0.0;       ///< of kSmoothStep, s
  double until = 1.0;      ///< of kSmoothStep, s
  std::string where;       ///< place in the scene, for messages
};

/// Only a program can set kCustom; a scene file cannot name it.
enum class EnvironmentKind { kNone, kGravity, kAttraction, kCustom };

template <>
struct EnumNames<EnvironmentKind> {
  static constexpr std::array names{"none", "gravity", "attraction", "custom"};
};

struct EnvironmentSettings {
  EnvironmentKind kind = EnvironmentKind::kNone;
  double strength = 9.81;                             ///< m/s² (gravity), N m² (attraction)
  Vector3 direction{0.0, -1.0, 0.0};                  ///< of gravity; normalised by the reader
  double softening = 0.0;                             ///< ε of attraction, m
  std::shared_ptr<const ForceField> field = nullptr;  ///< only with kCustom
  std::string amplitude{};                            ///< factor of the strength; empty: 1
};

/// Returns the direction with length 1. A direction whose length is 1 up to round-off is returned
/// bitwise unchanged, so that a scene which is written and read again is the same.
Vector3 unit_direction(const Vector3& direction);

/// A damped spring that pulls the mean of some vertices to a point (dynamics/terms/vertex_pull.h).
struct PullSettings {
  std::vector<std::int64_t> vertices;  ///< numbers of the mesh file, each once
  Vector3 target = Vector3::Zero();    ///< m
  double stiffness = 0.0;              ///< k, N/m
  double damping = 0.0;                ///< d, kg/s
};

struct FixSettings {
  Selection select = SelectAll{};
  std::array<bool, 3> components{true, true, true};  ///< which of x, y, z are fixed
  std::optional<Vector3> target;                     ///< m; default: where the vertices are
  std::optional<Vector3> offset;                     ///< m, added to where the vertices are
  /// Instead of target and offset: one target, m, for each number of a SelectVertices.
  std::vector<Vector3> targets{};
  Vector3 velocity = Vector3::Zero();  ///< of the targets, m/s
  bool is_penalty = false;  ///< fixed by springs with the force −2γ(q − c) instead of exactly
  double penalty = 0.0;     ///< γ, N/m
  std::string where;        ///< place in the scene, for messages
  std::string amplitude{};  ///< factor of `offset`, which then changes in time; empty: 1
};

/// The kinds of [[constraint]].
enum class ConstraintKind { kDistance, kPlane, kLine, kRigid };

template <>
struct EnumNames<ConstraintKind> {
  static constexpr std::array names{"distance", "plane", "line", "rigid"};
};
/// Whether a constraint of that kind has a selection of vertices. A distance has two vertices by
/// number.
inline bool has_selection(ConstraintKind kind) {
  return kind != ConstraintKind::kDistance;
}
/// "x", "yz", "xyz": which components are true.
std::string letters_of(const std::array<bool, 3>& components);

struct ConstraintSettings {
  ConstraintKind kind = ConstraintKind::kDistance;
  std::array<std::int64_t, 2> vertices{0, 1};  ///< distance: numbers of the mesh file
  std::optional<double> length;                ///< distance, m; default: the present one
  Selection select = SelectAll{};              ///< plane, line, rigid
  std::optional<Vector3> point;  ///< of the plane, line or axis (rigid), m; see docs/scene.md
  Vector3 direction = Vector3::UnitX();     ///< plane: its normal; line: its direction
  std::optional<Vector3> velocity;          ///< rigid: driven, m/s
  std::optional<Vector3> angular_velocity;  ///< rigid: driven, rad/s about `point` or its centre
  std::string where;
  std::string amplitude{};  ///< factor of both velocities; empty: 1

  bool is_driven() const { return velocity.has_value() || angular_velocity.has_value(); }
};

struct MomentumSettings {
  Selection select = SelectAll{};
  Vector3 value = Vector3::Zero();  ///< kg m/s, of every selected vertex
  std::string where;
};

/// The changes of positions and momenta of single vertices.
struct ShiftSettings {
  std::vector<std::int64_t> vertices;  ///< numbers of the mesh file, each once
  std::vector<Vector3> displacement;   ///< m, one for each vertex, or none
  std::vector<Vector3> impulse;        ///< N s, one for each vertex, or none
  std::string where;
};

/// A vector for each vertex that a file or three formulas give. Only one of the two is set. The
/// library's core does not compute it: read_scene_mesh() (io/initial_fields.h) puts it into
/// TetMesh::point_arrays.
struct FieldSettings {
  std::string file;                    ///< a table of comma-separated values
  std::array<std::string, 3> formula;  ///< of X, Y, Z, the rest position in m
  std::string where;                   ///< place in the scene, for messages

  bool empty() const { return file.empty() && formula[0].empty(); }
};

/// The names of the point arrays that hold the fields of InitialSettings.
inline constexpr const char* kInitialDisplacement = "initial.displacement";
inline constexpr const char* kInitialVelocity = "initial.velocity";

struct InitialSettings {
  Vector3 velocity = Vector3::Zero();          ///< m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s about the centre of mass
  Vector3 stretch = Vector3::Ones();           ///< scales positions about the centre of mass
  std::string displacement_array;              ///< point-data array of the mesh file, m
  std::string velocity_array;                  ///< point-data array of the mesh file, m/s
  std::vector<MomentumSettings> momentum;
  Vector3 displacement = Vector3::Zero();  ///< of the whole body, m
  FieldSettings displacement_field{};      ///< m, instead of `displacement`
  FieldSettings velocity_field{};          ///< m/s, instead of `velocity`
  /// Whether the positions are those of the equilibrium under the loads at t = 0.
  bool is_static = false;
  /// The places in the scene of keys that move vertices ("stretch", …), for messages.
  std::map<std::string, std::string> places{};
};

/// The sections that an edit replaces as a whole. Everything that concerns all of them, from the
/// scene's reader to the window, takes them from members().
struct ChangeableSections {
  TimeSettings time;
  SolverSettings solver;
  Damping damping;
  EnvironmentSettings environment;
  PullSettings pull;

  /// Their places in the order of the scene file.
  static constexpr auto members() {
    using S = ChangeableSections;
    return std::tuple(&S::time, &S::solver, &S::damping, &S::environment, &S::pull);
  }
  /// The section with settings of a type.
  template <class Section>
  const Section& section() const {
    return std::apply(
        [this](auto... member) -> const Section& {
          return std::get<const Section&>(std::tie(this->*member...));
        },
        members());
  }
  template <class Section>
  Section& section() {
    return const_cast<Section&>(std::as_const(*this).section<Section>());
  }
};

// The kinds of edits, which are made between two steps.
struct SetMaterial {
  Index region = 0;  ///< 0: [material]; i: the i-th [[material_region]]
  MaterialSettings material;
};
/// Replaces the settings of a section.
template <class Section>
struct SetSection {
  Section settings;
};
using SetTime = SetSection<TimeSettings>;
using SetSolver = SetSection<SolverSettings>;
using SetDamping = SetSection<Damping>;
using SetEnvironment = SetSection<EnvironmentSettings>;
using SetPull = SetSection<PullSettings>;
/// Adds an entry to its list, or changes the one with that number. Loads of each kind have numbers of their
/// own. `offset` and the default target of a [[fix]] are relative to the positions of the vertices at the time
/// of the edit.
template <class Entry>
struct SetEntry {
  std::optional<std::size_t> index;
  Entry entry;
};
using SetForce = SetEntry<ForceSettings>;
using SetFix = SetEntry<FixSettings>;
using SetConstraint = SetEntry<ConstraintSettings>;
/// An obstacle that is changed stays where its motion has brought it, and keys of its shape change it there. If its
/// motion changes, the new one begins there. One that is added stands where its keys say.
using SetObstacle = SetEntry<ObstacleSettings>;
/// Releases vertices from all [[fix]], or from the one with that number.
struct Unfix {
  Selection select = SelectAll{};
  std::string where;
  std::optional<std::size_t> fix = std::nullopt;
};
/// Removes the constraint with that number. The others keep their numbers.
struct RemoveConstraint {
  std::size_t index = 0;
};
/// Removes the obstacle with that number. The others keep their numbers.
struct RemoveObstacle {
  std::size_t index = 0;
};
/// Changes positions and momenta as the settings say, and then removes the parts that the constraints
/// do not allow. The settings stay.
template <class Change>
struct ChangeState {
  Change change;
};
using SetMomentum = ChangeState<MomentumSettings>;
using ShiftState = ChangeState<ShiftSettings>;

/// One change between two steps. The density cannot be changed: this would create mass, and with it
/// momentum.
using Edit = std::variant<SetMaterial, SetTime, SetSolver, SetDamping, SetEnvironment, SetPull,
                          SetForce, SetFix, Unfix, SetConstraint, RemoveConstraint, SetObstacle,
                          RemoveObstacle, SetMomentum, ShiftState>;

/// Whether a kind of edit is a SetSection, a SetEntry or a ChangeState.
template <class Kind>
inline constexpr bool kSetsSection = false;
template <class Section>
inline constexpr bool kSetsSection<SetSection<Section>> = true;
template <class Kind>
inline constexpr bool kSetsEntry = false;
template <class Entry>
inline constexpr bool kSetsEntry<SetEntry<Entry>> = true;
template <class Kind>
inline constexpr bool kChangesState = false;
template <class Change>
inline constexpr bool kChangesState<ChangeState<Change>> = true;

/// Edits that a scene makes during its run.
struct EventSettings {
  double at = 0.0;  ///< s; the edits are made before the first step that starts at t ≥ at
  std::vector<Edit> edits;
  std::string echo;    ///< as JSON text
  std::string where;   ///< place in the scene, for messages
  std::string note{};  ///< description for people, a comment in a written scene file
  /// The keys that the event sets or unsets, such as "time.step". Empty if they are not known.
  std::vector<std::string> changed_keys{};
};

struct OutputSettings {
  std::string directory = "out";  ///< relative to the working directory
  int every = 10;         ///< a frame for every n-th step, and always for the first and the last
  int history_every = 1;  ///< a row of history.csv for every n-th step, the first and the last
  /// Names of fields of the frames, see simulation/quantities.h. Empty: the default ones.
  std::vector<std::string> fields{};
  FramePrecision precision = FramePrecision::kFloat64;  ///< of frames; final.vtu is always double
  FrameCompression compression = FrameCompression::kLz4;
  int checkpoint_every = 0;  ///< a checkpoint after every n-th step; 0: none
};

/// A quantity that a run stores in every step, see simulation/probe.h.
struct ProbeSettings {
  std::string name{};              ///< of its columns: letters, digits, underscores
  Selection select = SelectAll{};  ///< if there is no point
  std::optional<Vector3> point{};  ///< rest coordinates, m
  ProbeQuantity quantity = ProbeQuantity::kDisplacement;
  int every = 1;                    ///< values for every n-th step
  std::string where{};              ///< place in the scene, for messages
  std::string obstacle{};           ///< of forces of contact: the name of the obstacle
  Vector3 about = Vector3::Zero();  ///< of a moment: the point that it is about, m
};

/// A selection that other parts of the scene use by its name (SelectNamed).
struct NamedSelection {
  std::string name;
  Selection select = SelectAll{};
};

struct Scene : LoadLists, ChangeableSections {
  std::string path;  ///< path of the scene file, for messages; empty if a program made the scene
  std::string echo;  ///< the scene as JSON text, with overrides applied, for summary.json
  MeshSettings mesh;
  MaterialSettings material;
  std::vector<MaterialRegionSettings> material_region;
  std::vector<FixSettings> fix;
  std::vector<ConstraintSettings> constraint;
  std::vector<ObstacleSettings> obstacle{};
  ContactSettings contact{};
  /// Further terms that act on the body, see MechanicalSystem::add_force_term(). Only a program can
  /// set them.
  std::vector<std::shared_ptr<const ForceTerm>> force_term{};
  InitialSettings initial;
  std::vector<EventSettings> event;  ///< in the order of their times
  OutputSettings output;
  std::vector<AmplitudeSettings> amplitude;
  std::vector<NamedSelection> selection{};
  /// The damping ratios from which a scene file's reader worked out mass damping and viscosity of
  /// `damping`. Only messages use them.
  std::optional<DampingRatio> damping_ratio{};
  std::vector<ProbeSettings> probe{};
};

/// The amplitude of the settings. Throws InputError for values that contradict each other.
Amplitude make_amplitude(const AmplitudeSettings& settings);
/// The amplitude of that name, or null for an empty name. Throws InputError, which begins with
/// `where`, for a name that the list does not have, and for settings that contradict each other.
std::shared_ptr<const Amplitude> find_amplitude(const std::vector<AmplitudeSettings>& amplitudes,
                                                const std::string& name, const std::string& where);

}  // namespace tetraction
