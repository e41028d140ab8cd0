// A scene: everything a run needs to know, as plain data. The scene reader (io/scene_reader.h)
// fills it from TOML; a program may fill it by hand. Default values stand here and nowhere else.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/core/types.h"
#include "tetraction/material/material.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {

/// The time-stepping rules of physics.md.
enum class Integrator { kExplicit, kVerlet, kMidpoint, kBackwardEuler };

/// "explicit", "verlet", "midpoint", "backward-euler".
std::string to_string(Integrator integrator);
/// Inverse of to_string(); throws InputError listing the valid names.
Integrator integrator_from_string(const std::string& name);
/// Whether a step solves a minimisation.
bool is_implicit(Integrator integrator);
/// Whether the rule is derived from a discrete action (all but backward Euler).
inline bool is_variational(Integrator integrator) {
  return integrator != Integrator::kBackwardEuler;
}

/// Kinds of meshes that the program can make (mesh/generate.h).
enum class GeneratorKind { kBeam, kBox, kCube, kTetrahedron };

struct GeneratorSettings {
  GeneratorKind kind = GeneratorKind::kBeam;
  Vector3 size{1.0, 1.0, 1.0};  ///< m
  std::array<int, 3> cells{1, 1, 1};
};

struct MeshSettings {
  std::string file;                           ///< absolute, or relative to the working directory
  std::optional<GeneratorSettings> generate;  ///< instead of a file
  double scale = 1.0;                         ///< multiplies the file's coordinates
};

struct MaterialSettings {
  std::string model = "neo-hookean";
  // Either (youngs_modulus, poissons_ratio [, ratio]) or the model's own moduli; Pa.
  std::optional<double> youngs_modulus;
  std::optional<double> poissons_ratio;
  std::optional<double> mu;
  std::optional<double> lambda;
  std::optional<double> mu1;    ///< mooney-rivlin
  std::optional<double> mu2;    ///< mooney-rivlin
  std::optional<double> ratio;  ///< mooney-rivlin: μ₂/μ₁
  double density = 1000.0;      ///< kg/m³
};

/// The material of the settings. Throws InputError for unknown models, parameters that are missing,
/// do not belong to the model or contradict each other, and values out of range.
MaterialModel make_material(const MaterialSettings& settings);

struct TimeSettings {
  Integrator integrator = Integrator::kMidpoint;
  double step = 1.0e-2;    ///< s
  bool automatic = false;  ///< step = "auto": 0.5 of the stability limit (explicit rules only)
  double end = 1.0;        ///< s
};

struct SolverSettings {
  std::string kind = "ceres";
  double tolerance = 1.0e-8;  ///< force residual relative to the step's force scale
  int max_iterations = 100;
};

enum class EnvironmentKind { kNone, kGravity };

struct EnvironmentSettings {
  EnvironmentKind kind = EnvironmentKind::kNone;
  double strength = 9.81;             ///< m/s²
  Vector3 direction{0.0, -1.0, 0.0};  ///< of gravity; normalised by the reader
};

struct FixSettings {
  Selection select = SelectAll{};
  std::array<bool, 3> components{true, true, true};  ///< which of x, y, z are fixed
  std::optional<Vector3> target;                     ///< m; default: where the vertices are
  std::optional<Vector3> offset;                     ///< m, added to where the vertices are
  std::string where;                                 ///< place in the scene, for messages
};

struct ForceSettings {
  Selection select = SelectAll{};
  Vector3 vector = Vector3::Zero();                        ///< N, on every selected vertex
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
  std::string where;
};

struct MomentumSettings {
  Selection select = SelectAll{};
  Vector3 value = Vector3::Zero();  ///< kg m/s, of every selected vertex
  std::string where;
};

struct InitialSettings {
  Vector3 velocity = Vector3::Zero();          ///< m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s about the centre of mass
  Vector3 stretch = Vector3::Ones();           ///< scales positions about the centre of mass
  std::string displacement_array;              ///< point-data array of the mesh file, m
  std::string velocity_array;                  ///< point-data array of the mesh file, m/s
  std::vector<MomentumSettings> momentum;
};

struct OutputSettings {
  std::string directory = "out";  ///< relative to the working directory
  int every = 10;                 ///< frames: each n-th step, and the first and last always
};

struct Scene {
  std::string path;  ///< of the scene file, for messages; empty if made by a program
  std::string echo;  ///< the scene as JSON text, with overrides applied, for summary.json
  MeshSettings mesh;
  MaterialSettings material;
  TimeSettings time;
  SolverSettings solver;
  EnvironmentSettings environment;
  std::vector<FixSettings> fix;
  std::vector<ForceSettings> force;
  InitialSettings initial;
  OutputSettings output;
};

}  // namespace tetraction
