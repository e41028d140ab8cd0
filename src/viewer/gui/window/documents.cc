#include "documents.h"

#include <filesystem>
#include <limits>

#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction::viewer {
namespace {

constexpr int kHalvings = 6;
constexpr double kEndless = std::numeric_limits<double>::infinity();

// In the window a step that fails is halved. A scene without such a step runs as with tetraction run.
void halve_failed_steps(TimeSettings& time) {
  if (time.adapt == StepAdaptation::kNone && !time.automatic && time.retry == 0) {
    time.retry = kHalvings;
  }
}

// A run without a scene file: it has no end, and its energy shall not drift in large motions.
TimeSettings usual_time() {
  TimeSettings time;
  time.integrator = Integrator::kEnergyMomentum;
  time.step = 5.0e-3;
  time.end = kEndless;
  halve_failed_steps(time);
  return time;
}

}  // namespace

DocumentKind kind_of(const std::string& path) {
  const std::filesystem::path file(path);
  std::error_code error;  // the reader says what is wrong with a link to itself
  if (std::filesystem::is_directory(file, error) || file.extension() == ".pvd")
    return DocumentKind::kRun;
  return file.extension() == ".toml" ? DocumentKind::kScene : DocumentKind::kMesh;
}

Document open_scene(const std::string& path) {
  Document document;
  document.scene = read_scene(path);
  document.mesh = read_scene_mesh(document.scene);
  halve_failed_steps(document.scene.time);
  return document;
}

Document open_mesh(const std::string& path, double scale) {
  Document document;
  document.mesh = read_mesh(path, scale);
  Scene& scene = document.scene;
  scene.mesh.file = std::filesystem::absolute(path).string();
  scene.mesh.scale = scale;
  scene.mesh.quadratic = document.mesh.is_quadratic();
  scene.material.youngs_modulus = 1.0e6;
  scene.material.poissons_ratio = 0.4;
  scene.time = usual_time();
  return document;
}

Document first_scene() {
  Document document;
  Scene& scene = document.scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {1.2, 0.3, 0.3}, {16, 4, 4}};
  scene.material.youngs_modulus = 1.5e6;
  scene.material.poissons_ratio = 0.4;
  scene.time = usual_time();
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings clamp;
  clamp.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(clamp);
  scene.damping.viscosity = 50.0;
  document.mesh = generate_mesh(*scene.mesh.generate);
  return document;
}

}  // namespace tetraction::viewer
