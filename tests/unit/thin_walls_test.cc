// The warning of walls that are too thin for nodal volumes.

#include <array>
#include <string>

#include "support/bodies.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

using namespace testing_support;

std::string warning_of(const Vector3& size, const std::array<int, 3>& cells, VolumeRule rule) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, size, cells};
  scene.mesh.volume = rule;
  scene.material.model = "neo-hookean";
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.49;
  return thin_wall_warning(*make_system(scene, generate_mesh(*scene.mesh.generate)));
}

TEST(ThinWalls, AreToldOfWithNodalVolumes) {
  for (const int layers : {1, 2}) {
    const std::string plate = warning_of({8, 8, 1}, {8, 8, layers}, VolumeRule::kNodal);
    EXPECT_NE(plate.find("100 %"), std::string::npos) << plate;
    EXPECT_NE(plate.find("quadratic"), std::string::npos) << plate;
    EXPECT_EQ(warning_of({8, 8, 1}, {8, 8, layers}, VolumeRule::kElement), "");
  }
  for (const int layers : {3, 4, 6}) {
    EXPECT_EQ(warning_of({8, 8, 1}, {8, 8, layers}, VolumeRule::kNodal), "") << layers;
    EXPECT_EQ(warning_of({1, 1, 1}, {layers, layers, layers}, VolumeRule::kNodal), "") << layers;
  }
}

}  // namespace
}  // namespace tetraction
