// Scenes as texts, and their refusals.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_reader.h"

namespace tetraction::testing_support {

inline const std::string kSmall = R"([mesh]
file = "bar.vtu"

[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
)";

inline const std::string kWhole = R"([mesh]
file = "meshes/bar.vtu"
scale = 0.001
element = "linear"

[material]
model = "mooney-rivlin"
youngs_modulus = 1_000_000
poissons_ratio = 0.4
ratio = 0.25
density = 1200

[time]
integrator = "verlet"
step = "auto"
end = 2

[solver]
kind = "ceres"
tolerance = 1e-6
max_iterations = 50

[damping]
drag = 0
mass_damping = 0.0
viscosity = 0.0

[environment]
kind = "gravity"
strength = 3.7
direction = [0, 0, -2]

[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
components = "xz"
target = [1, 2, 3]
mode = "exact"

[[fix]]
select = { vertices = [12, 3] }
offset = [0.1, 0, 0]

[[force]]
select = { sphere = { center = [1, 2, 3], radius = 0.5 } }
vector = [0, 10, 0]
from = 0.25
until = inf

[initial]
velocity = [1, 0, 0]
angular_velocity = [0, 0, 2]
stretch = [1.5, 1, 0.5]
displacement_array = "start"
velocity_array = "speed"

[[initial.momentum]]
select = { nearest = [0, 0, 1] }
value = [0, 0, 1]

[output]
directory = "results"
every = 5
checkpoint_every = 0
)";

class SceneReader : public ::testing::Test {
 protected:
  void SetUp() override { path_ = (folder_ / "scene.toml").string(); }

  Scene read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(path_, std::ios::binary) << text;
    return read_scene(path_, overrides);
  }

  // The message of the InputError, with the path of the scene cut to "scene.toml".
  std::string refusal(const std::string& text,
                      const std::vector<std::string>& overrides = {}) const {
    try {
      read(text, overrides);
    } catch (const InputError& error) {
      std::string message = error.what();
      const std::string folder = folder_.string() + "/";
      for (auto at = message.find(folder); at != std::string::npos; at = message.find(folder)) {
        message.erase(at, folder.size());
      }
      return message;
    }
    return "accepted";
  }

  // The refusal begins with `start` and says each of the parts.
  void expect_refusal(const std::string& text, const std::string& start,
                      const std::vector<std::string>& parts = {},
                      const std::vector<std::string>& overrides = {}) const {
    const std::string message = refusal(text, overrides);
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "no \"" << part << "\" in: " << message;
    }
  }
  // The same for lines added to the small scene, whose last line is the sixth. The message begins with
  // "scene.toml:" and this text.
  void refuses(const std::string& lines, const std::string& start,
               const std::vector<std::string>& parts = {}) const {
    expect_refusal(kSmall + lines, "scene.toml:" + start, parts);
  }

  TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  std::string path_;
};

// Keys of constraints, damping, regions and events; the lines follow the small scene's.
inline const std::string kMechanics = R"(
[[material_region]]
select = { box = { min = [0, 0, 0], max = [1, 1, 1] } }
model = "stvk"
mu = 3e5
lambda = 2e5
density = 500

[[material_region]]
select = { group = "core" }
youngs_modulus = 2e6
poissons_ratio = 0.3

[damping]
drag = 0.25
mass_damping = 2
viscosity = 40.5

[environment]
kind = "attraction"
strength = 1e4
softening = 0.125

[[fix]]
select = { vertices = [0] }
velocity = [0, 0.5, 0]
components = "xy"

[[fix]]
select = { vertices = [1] }
offset = [0, 0, 0.1]
mode = "penalty"
penalty = 1e5

[[constraint]]
kind = "distance"
vertices = [3, 40]
length = 1.5

[[constraint]]
kind = "plane"
select = { vertices = [5] }
point = [0, 0, 1]
normal = [0, 0, 2]

[[constraint]]
kind = "line"
select = { vertices = [6] }
direction = [0, 3, 4]

[[constraint]]
kind = "rigid"
select = { sphere = { center = [0, 0, 0], radius = 1 } }

[[constraint]]
kind = "rigid"
select = { group = "grip" }
velocity = [1, 0, 0]
angular_velocity = [0, 0, 2]

[[force]]
select = { all = true }
vector = [0, 1, 0]

[[event]]
at = 0.75
set = { "time.step" = 5.0e-3, "damping.drag" = 0 }
momentum = { select = { vertices = [0] }, value = [0, 0, 1] }

[[event]]
at = 0.25
unfix = { select = { vertices = [0, 1] } }
fix = [{ select = { vertices = [2] } }, { select = { vertices = [3] }, components = "z" }]
)";

}  // namespace tetraction::testing_support
