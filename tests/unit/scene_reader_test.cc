#include "tetraction/io/scene_reader.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr const char* kSmall = R"([mesh]
file = "bar.vtu"

[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
)";

constexpr const char* kWhole = R"([mesh]
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
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("tetraction_scene_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / "scene.toml").string();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

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
  // The same for lines added to the small scene, whose last line is the sixth.
  void expect_refused_lines(const std::string& lines, const std::string& start,
                            const std::vector<std::string>& parts = {}) const {
    expect_refusal(kSmall + lines, start, parts);
  }

  std::filesystem::path folder_;
  std::string path_;
};

TEST_F(SceneReader, LeavesDefaultsWhereNothingIsSaid) {
  const Scene scene = read(kSmall);
  const Scene defaults;
  EXPECT_EQ(scene.path, path_);
  EXPECT_EQ(scene.mesh.file, (folder_ / "bar.vtu").string());
  EXPECT_FALSE(scene.mesh.generate);
  EXPECT_EQ(scene.mesh.scale, defaults.mesh.scale);
  EXPECT_EQ(scene.material.model, defaults.material.model);
  EXPECT_EQ(scene.material.density, defaults.material.density);
  EXPECT_EQ(scene.time.integrator, defaults.time.integrator);
  EXPECT_EQ(scene.time.step, defaults.time.step);
  EXPECT_FALSE(scene.time.automatic);
  EXPECT_EQ(scene.time.end, defaults.time.end);
  EXPECT_EQ(scene.environment.kind, EnvironmentKind::kNone);
  EXPECT_TRUE(scene.fix.empty());
  EXPECT_TRUE(scene.force.empty());
  EXPECT_EQ(scene.output.directory, defaults.output.directory);
  EXPECT_EQ(scene.output.every, defaults.output.every);
}

TEST_F(SceneReader, ReadsEveryKey) {
  const Scene scene = read(kWhole);
  EXPECT_EQ(scene.mesh.file, (folder_ / "meshes" / "bar.vtu").string());
  EXPECT_EQ(scene.mesh.scale, 0.001);
  EXPECT_EQ(scene.material.model, "mooney-rivlin");
  EXPECT_EQ(scene.material.youngs_modulus, 1e6);
  EXPECT_EQ(scene.material.poissons_ratio, 0.4);
  EXPECT_EQ(scene.material.ratio, 0.25);
  EXPECT_FALSE(scene.material.mu);
  EXPECT_EQ(scene.material.density, 1200.0);
  EXPECT_EQ(scene.time.integrator, Integrator::kVerlet);
  EXPECT_TRUE(scene.time.automatic);
  EXPECT_EQ(scene.time.end, 2.0);
  EXPECT_EQ(scene.solver.tolerance, 1e-6);
  EXPECT_EQ(scene.solver.max_iterations, 50);
  EXPECT_EQ(scene.environment.kind, EnvironmentKind::kGravity);
  EXPECT_EQ(scene.environment.strength, 3.7);
  EXPECT_EQ(scene.environment.direction, Vector3(0, 0, -1));
  ASSERT_EQ(scene.fix.size(), 2U);
  EXPECT_EQ(std::get<SelectPlane>(scene.fix[0].select).axis, 0);
  EXPECT_EQ(scene.fix[0].components, (std::array<bool, 3>{true, false, true}));
  EXPECT_EQ(scene.fix[0].target, Vector3(1, 2, 3));
  EXPECT_FALSE(scene.fix[0].offset);
  EXPECT_EQ(scene.fix[0].where, path_ + ":33:1: fix.0");
  EXPECT_EQ(scene.fix[1].components, (std::array<bool, 3>{true, true, true}));
  EXPECT_EQ(scene.fix[1].offset, Vector3(0.1, 0, 0));
  ASSERT_EQ(scene.force.size(), 1U);
  EXPECT_EQ(scene.force[0].vector, Vector3(0, 10, 0));
  EXPECT_EQ(scene.force[0].from, 0.25);
  EXPECT_EQ(scene.force[0].until, std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.force[0].where, path_ + ":43:1: force.0");
  EXPECT_EQ(scene.initial.velocity, Vector3(1, 0, 0));
  EXPECT_EQ(scene.initial.angular_velocity, Vector3(0, 0, 2));
  EXPECT_EQ(scene.initial.stretch, Vector3(1.5, 1, 0.5));
  EXPECT_EQ(scene.initial.displacement_array, "start");
  EXPECT_EQ(scene.initial.velocity_array, "speed");
  ASSERT_EQ(scene.initial.momentum.size(), 1U);
  EXPECT_EQ(scene.initial.momentum[0].value, Vector3(0, 0, 1));
  EXPECT_EQ(scene.output.directory, "results");
  EXPECT_EQ(scene.output.every, 5);
}

TEST_F(SceneReader, ReadsEveryModelAndIntegrator) {
  const std::string mesh = "mesh = { file = \"a.vtu\" }\n";
  EXPECT_EQ(read(mesh + "material = { model = \"stvk\", mu = 1, lambda = 2 }").material.mu, 1.0);
  EXPECT_EQ(read(mesh + "material = { model = \"mooney-rivlin\", mu1 = 1, mu2 = 0, lambda = 2 }")
                .material.mu2,
            0.0);
  for (const Integrator integrator : {Integrator::kExplicit, Integrator::kVerlet,
                                      Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    EXPECT_EQ(read(kSmall, {"time.integrator=" + to_string(integrator)}).time.integrator,
              integrator);
  }
}

TEST_F(SceneReader, ReadsEverySelection) {
  const auto select = [this](const std::string& what) {
    return read(std::string(kSmall) + "[[fix]]\nselect = { " + what + " }\n").fix[0].select;
  };
  EXPECT_EQ(std::get<SelectVertices>(select("vertices = [5, 0]")).ids,
            (std::vector<std::int64_t>{5, 0}));
  const auto plane =
      std::get<SelectPlane>(select("plane = { axis = \"z\", at = 1, tolerance = 0.5 }"));
  EXPECT_EQ(plane.axis, 2);
  EXPECT_EQ(plane.at, 1.0);
  EXPECT_EQ(plane.tolerance, 0.5);
  const auto box = std::get<SelectBox>(select("box = { min = [0, 1, 2], max = [3, 1, 4] }"));
  EXPECT_EQ(box.min, Vector3(0, 1, 2));
  EXPECT_EQ(box.max, Vector3(3, 1, 4));
  const auto sphere = std::get<SelectSphere>(select("sphere = { center=[1,2,3], radius=4 }"));
  EXPECT_EQ(sphere.center, Vector3(1, 2, 3));
  EXPECT_EQ(sphere.radius, 4.0);
  EXPECT_EQ(std::get<SelectNearest>(select("nearest = [1, 2, 3]")).point, Vector3(1, 2, 3));
  EXPECT_EQ(std::get<SelectGroup>(select("group = \"clamp\"")).name, "clamp");
  EXPECT_TRUE(std::holds_alternative<SelectSurface>(select("surface = true")));
  EXPECT_TRUE(std::holds_alternative<SelectAll>(select("all = true")));
}

TEST_F(SceneReader, ReadsEveryGenerator) {
  const auto generator = [this](const std::string& what) {
    return *read("[mesh]\ngenerate = { " + what + " }\n[material]\nmu = 1\nlambda = 1\n")
                .mesh.generate;
  };
  const auto beam = generator("kind = \"beam\", size = [4, 1, 0.5], cells = [40, 9, 3]");
  EXPECT_EQ(beam.kind, GeneratorKind::kBeam);
  EXPECT_EQ(beam.size, Vector3(4, 1, 0.5));
  EXPECT_EQ(beam.cells, (std::array<int, 3>{40, 9, 3}));
  EXPECT_EQ(generator("kind = \"box\", size = [4, 1, 1], cells = [4, 1, 1]").kind,
            GeneratorKind::kBox);
  const auto cube = generator("kind = \"cube\", cells = 3");
  EXPECT_EQ(cube.kind, GeneratorKind::kCube);
  EXPECT_EQ(cube.size, Vector3(1, 1, 1));
  EXPECT_EQ(cube.cells, (std::array<int, 3>{3, 3, 3}));
  EXPECT_EQ(generator("kind = \"cube\", cells = 3, size = 2").size, Vector3(2, 2, 2));
  EXPECT_EQ(generator("kind = \"tetrahedron\"").kind, GeneratorKind::kTetrahedron);
  EXPECT_EQ(generator("kind = \"tetrahedron\", size = 0.1").size.x(), 0.1);
}

TEST_F(SceneReader, PathsAreRelativeToTheScene) {
  EXPECT_EQ(read(kSmall, {"mesh.file=../other/./a.vtu"}).mesh.file,
            (folder_.parent_path() / "other" / "a.vtu").string());
  EXPECT_EQ(read(kSmall, {"mesh.file=/data/a.vtu"}).mesh.file, "/data/a.vtu");
}

TEST_F(SceneReader, UnknownKeysAreRefusedWithTheNearest) {
  expect_refusal("[mesh]\nfile = \"a.vtu\"\n[material]\nyoungs_modlus = 1\n",
                 "scene.toml:4:1: unknown key material.youngs_modlus in [material]",
                 {"did you mean youngs_modulus?"});
  expect_refused_lines("[material_regoin]\n", "scene.toml:7:2: unknown key material_regoin");
  expect_refused_lines("[mehs]\n", "scene.toml:7:2: unknown key mehs", {"did you mean mesh?"});
  expect_refused_lines("[enviroment]\n", "scene.toml:7:2: unknown key enviroment",
                       {"did you mean environment?"});
  expect_refused_lines("[time]\nStep = 1\n", "scene.toml:8:1: unknown key time.Step",
                       {"did you mean step?"});
  expect_refused_lines("[output]\ndir = \"x\"\n", "scene.toml:8:1: unknown key output.dir",
                       {"did you mean directory?"});
  expect_refused_lines("[[fix]]\nselect = { plne = 1 }\n",
                       "scene.toml:8:12: unknown key fix.0.select.plne", {"did you mean plane?"});
  expect_refused_lines("[initial]\nmomentum = [{ select = { all = true }, vlaue = [0, 0, 0] }]\n",
                       "scene.toml:8:40: unknown key initial.momentum.0.vlaue",
                       {"did you mean value?"});
}

TEST_F(SceneReader, UnknownKeysWithNothingNearListTheValidOnes) {
  expect_refused_lines("[time]\nresolution = 1\n", "scene.toml:8:1: unknown key time.resolution",
                       {"valid are integrator, step or end."});
  expect_refused_lines("[" + std::string(5000, 'q') + "]\n", "scene.toml:7:2: unknown key qqq",
                       {"valid are mesh, material"});
}

TEST_F(SceneReader, WhatComesLaterIsRefusedAsSuch) {
  const char* said = "not in this version of Tetraction";
  expect_refused_lines("[[constraint]]\nkind = \"distance\"\n", "scene.toml:7:3: constraint ",
                       {said});
  expect_refused_lines("[[event]]\nat = 1\n", "scene.toml:7:3: event ", {said});
  expect_refused_lines("[[material_region]]\n", "scene.toml:7:3: material_region ", {said});
  for (const char* key : {"drag", "mass_damping", "viscosity"}) {
    expect_refused_lines(std::string("[damping]\n") + key + " = 0.1\n",
                         std::string("scene.toml:8:1: damping.") + key, {said, "0.1"});
  }
  expect_refused_lines("[environment]\nkind = \"attraction\"\n",
                       "scene.toml:8:1: environment.kind = \"attraction\"",
                       {said, "none or gravity"});
  const std::string fix = "[[fix]]\nselect = { all = true }\n";
  expect_refused_lines(fix + "mode = \"penalty\"\n", "scene.toml:9:1: fix.0.mode", {said, "exact"});
  expect_refused_lines(fix + "penalty = 1e5\n", "scene.toml:9:1: fix.0.penalty", {said});
  expect_refused_lines(fix + "velocity = [0, 0, 1]\n", "scene.toml:9:1: fix.0.velocity", {said});
  expect_refusal(kSmall, "--set mesh.element=quadratic: mesh.element", {said, "linear"},
                 {"mesh.element=quadratic"});
  expect_refused_lines("[solver]\nkind = \"newton\"\n", "scene.toml:8:1: solver.kind",
                       {said, "ceres"});
  expect_refused_lines("[solver]\nlinear = \"cg\"\n", "scene.toml:8:1: solver.linear", {said});
  expect_refused_lines("[time]\nintegrator = \"energy-momentum\"\n",
                       "scene.toml:8:1: time.integrator", {said, "midpoint"});
  expect_refused_lines("[output]\ncheckpoint_every = 100\n",
                       "scene.toml:8:1: output.checkpoint_every", {said});
}

TEST_F(SceneReader, UnknownWordsAreRefusedWithTheNearest) {
  expect_refused_lines("[time]\nintegrator = \"mid-point\"\n",
                       "scene.toml:8:1: time.integrator = \"mid-point\"",
                       {"did you mean midpoint?"});
  expect_refused_lines("[time]\nintegrator = \"rk4\"\n", "scene.toml:8:1: time.integrator",
                       {"explicit, verlet, midpoint or backward-euler"});
  expect_refusal(kSmall, "--set material.model=neohookean: material.model",
                 {"did you mean neo-hookean?"}, {"material.model=neohookean"});
  expect_refused_lines("[environment]\nkind = \"wind\"\n", "scene.toml:8:1: environment.kind",
                       {"none or gravity"});
  expect_refusal("[mesh]\ngenerate = { kind = \"ball\" }\n",
                 "scene.toml:2:14: mesh.generate.kind = \"ball\"", {"beam, box, cube"});
}

TEST_F(SceneReader, MissingKeysAreNamed) {
  expect_refusal("", "scene.toml:1:1: mesh is missing", {"[mesh]", "file"});
  expect_refusal("[mesh]\nfile = \"a.vtu\"\n", "scene.toml:1:1: material is missing",
                 {"youngs_modulus"});
  expect_refusal("\n[mesh]\n[material]\n", "scene.toml:2:1: mesh has no mesh",
                 {"file", "generate"});
  expect_refusal("[mesh]\nfile = \"a.vtu\"\n[material]\nyoungs_modulus = 1\n",
                 "scene.toml:3:1: material.poissons_ratio is missing");
  expect_refused_lines("[[fix]]\n", "scene.toml:7:1: fix.0.select is missing", {"all = true"});
  expect_refused_lines("[[force]]\nselect = { all = true }\n",
                       "scene.toml:7:1: force.0.vector is missing");
  expect_refused_lines("[[force]]\nvector = [0, 0, 1]\n",
                       "scene.toml:7:1: force.0.select is missing");
  expect_refused_lines("[[initial.momentum]]\nselect = { all = true }\n",
                       "scene.toml:7:1: initial.momentum.0.value is missing");
  expect_refused_lines("[environment]\nstrength = 9.81\n",
                       "scene.toml:7:1: environment.kind is missing", {"gravity"});
  expect_refused_lines("[[fix]]\nselect = { plane = { axis = \"x\" } }\n",
                       "scene.toml:8:20: fix.0.select.plane.at is missing");
  expect_refused_lines("[[fix]]\nselect = { plane = { at = 0 } }\n",
                       "scene.toml:8:20: fix.0.select.plane.axis is missing");
  expect_refused_lines("[[fix]]\nselect = { box = { min = [0, 0, 0] } }\n",
                       "scene.toml:8:18: fix.0.select.box.max is missing");
  expect_refused_lines("[[fix]]\nselect = { sphere = { center = [0, 0, 0] } }\n",
                       "scene.toml:8:21: fix.0.select.sphere.radius is missing");
  expect_refusal("[mesh]\ngenerate = {}\n", "scene.toml:2:12: mesh.generate.kind is missing",
                 {"tetrahedron"});
  expect_refusal("[mesh]\ngenerate = { kind = \"box\", size = [1, 1, 1] }\n",
                 "scene.toml:2:12: mesh.generate.cells is missing");
  expect_refusal("[mesh]\ngenerate = { kind = \"cube\" }\n",
                 "scene.toml:2:12: mesh.generate.cells is missing");
}

TEST_F(SceneReader, WrongTypesAreNamed) {
  expect_refused_lines("[time]\nend = \"long\"\n", "scene.toml:8:1: time.end must be a number",
                       {"not a string"});
  expect_refused_lines("[time]\nend = true\n", "scene.toml:8:1: time.end", {"not true or false"});
  expect_refused_lines("[time]\nend = 1979-05-27\n", "scene.toml:8:1: time.end", {"date"});
  expect_refused_lines("[time]\nstep = \"fast\"\n", "scene.toml:8:1: time.step = \"fast\"",
                       {"\"auto\""});
  expect_refused_lines("[time]\nstep = [1]\n", "scene.toml:8:1: time.step", {"not a list"});
  expect_refused_lines("[output]\nevery = 2.0\n",
                       "scene.toml:8:1: output.every must be a whole number", {"decimal point"});
  expect_refused_lines("[output]\ndirectory = 3\n", "scene.toml:8:1: output.directory",
                       {"text in quotes", "not a whole number"});
  expect_refused_lines("[initial]\nvelocity = 3\n", "scene.toml:8:1: initial.velocity",
                       {"[1.0, 0.0, 0.0]", "not a whole number"});
  expect_refused_lines("[initial]\nvelocity = [1, 2]\n", "scene.toml:8:1: initial.velocity",
                       {"has 2 entries", "must have 3"});
  expect_refused_lines("[initial]\nvelocity = [1, 2, \"3\"]\n", "scene.toml:8:1: initial.velocity",
                       {"list of numbers", "not a string"});
  expect_refused_lines("[[fix]]\nselect = { vertices = [1, 2.5] }\n",
                       "scene.toml:8:12: fix.0.select.vertices", {"whole numbers"});
  expect_refused_lines("[[fix]]\nselect = \"all\"\n", "scene.toml:8:1: fix.0.select",
                       {"must be a table", "not a string"});
  expect_refused_lines("[[fix]]\nselect = { all = 1 }\n", "scene.toml:8:12: fix.0.select.all",
                       {"true or false"});
  expect_refused_lines("[fix]\n", "scene.toml:7:2: fix", {"[[fix]]", "brackets twice"});
  expect_refused_lines("[[time]]\n", "scene.toml:7:3: time", {"[time]", "list of tables"});
  expect_refusal("fix = [1]\n" + std::string(kSmall), "scene.toml:1:1: fix", {"[[fix]]"});
  expect_refusal("time = 3\n" + std::string(kSmall), "scene.toml:1:1: time", {"table"});
}

TEST_F(SceneReader, NumbersThatAreNotFiniteAreRefused) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    for (const char* key :
         {"time.end", "time.step", "mesh.scale", "material.density", "material.youngs_modulus",
          "material.poissons_ratio", "solver.tolerance"}) {
      const std::string text = std::string(key) + "=" + value;
      expect_refusal(kSmall, "--set " + text + ": " + key, {"finite"}, {text});
    }
    expect_refused_lines(std::string("[initial]\nvelocity = [0, ") + value + ", 0]\n",
                         "scene.toml:8:1: initial.velocity", {"finite"});
  }
  const std::string force = "[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n";
  expect_refused_lines(force + "until = nan\n", "scene.toml:10:1: force.0.until", {"finite"});
  expect_refused_lines(force + "from = inf\n", "scene.toml:10:1: force.0.from", {"finite"});
  expect_refused_lines(force + "until = -inf\n", "scene.toml:10:1: force.0.until", {"later"});
}

TEST_F(SceneReader, RangesAreChecked) {
  const auto refused = [this](const std::string& key, const std::string& value,
                              const std::string& range) {
    const std::string text = key + "=" + value;
    expect_refusal(kSmall, "--set " + text + ": " + key, {range}, {text});
  };
  refused("material.youngs_modulus", "0", "above 0");
  refused("material.youngs_modulus", "-1e6", "above 0");
  refused("material.poissons_ratio", "0.5", "between -1 and 0.5");
  refused("material.poissons_ratio", "-1", "between -1 and 0.5");
  refused("material.density", "0", "above 0");
  refused("mesh.scale", "0", "above 0");
  refused("mesh.scale", "-1", "above 0");
  refused("time.step", "0", "above 0");
  refused("time.step", "-1e-3", "above 0");
  refused("time.end", "0", "above 0");
  refused("solver.tolerance", "0", "between 0 and 1");
  refused("solver.tolerance", "1", "between 0 and 1");
  refused("solver.max_iterations", "0", "1 or more");
  refused("solver.max_iterations", "99999999999", "2147483647 at most");
  refused("output.every", "0", "1 or more");
  refused("output.every", "-3", "1 or more");
  refused("initial.stretch", "[1, 0, 1]", "above 0");
  refused("initial.displacement_array", "\"\"", "empty");
  refused("mesh.file", "\"\"", "empty");
  refused("output.directory", "\"\"", "empty");
}

TEST_F(SceneReader, TheEnvironmentIsChecked) {
  const std::string gravity = "[environment]\nkind = \"gravity\"\n";
  expect_refused_lines(gravity + "strength = -1\n", "scene.toml:9:1: environment.strength = -1",
                       {"0 or more", "direction"});
  expect_refused_lines(gravity + "direction = [0, 0, 0]\n", "scene.toml:9:1: environment.direction",
                       {"not be zero"});
  EXPECT_EQ(read(kSmall + gravity + "strength = 0\n").environment.strength, 0.0);
  // Neither overflow nor underflow in the norm.
  EXPECT_EQ(read(kSmall + gravity + "direction = [1e-200, 0, 0]\n").environment.direction,
            Vector3(1, 0, 0));
  EXPECT_EQ(read(kSmall + gravity + "direction = [0, -1e200, 0]\n").environment.direction,
            Vector3(0, -1, 0));
}

TEST_F(SceneReader, TheAutomaticStepIsForExplicitRules) {
  for (const char* integrator : {"midpoint", "backward-euler"}) {
    expect_refusal(kSmall, "--set time.step=auto: time.step = \"auto\"",
                   {"explicit and verlet", integrator},
                   {std::string("time.integrator=") + integrator, "time.step=auto"});
  }
  EXPECT_TRUE(read(kSmall, {"time.integrator=explicit", "time.step=auto"}).time.automatic);
}

TEST_F(SceneReader, OneMeshOnly) {
  expect_refusal("[mesh]\nfile = \"a.vtu\"\ngenerate = { kind = \"tetrahedron\" }\n",
                 "scene.toml:3:1: mesh.generate", {"file", "one of the two"});
  expect_refusal("[mesh]\ngenerate = { kind = \"tetrahedron\" }\n",
                 "--set mesh.file=a.vtu: mesh.file", {"one of the two"}, {"mesh.file=a.vtu"});
  expect_refusal("[mesh]\ngenerate = { kind = \"tetrahedron\" }\nscale = 2\n",
                 "scene.toml:3:1: mesh.scale", {"size"});
}

TEST_F(SceneReader, GeneratorsAreChecked) {
  const auto refused = [this](const std::string& what, const std::string& start,
                              const std::vector<std::string>& parts) {
    expect_refusal("[mesh.generate]\n" + what, "scene.toml:" + start, parts);
  };
  refused("kind = \"box\"\nsize = [1, 0, 1]\ncells = [1, 1, 1]\n", "3:1: mesh.generate.size",
          {"above 0"});
  refused("kind = \"box\"\nsize = [1, 1, 1]\ncells = [1, 0, 1]\n", "4:1: mesh.generate.cells",
          {"1 or more"});
  refused("kind = \"box\"\nsize = [1, 1, 1]\ncells = 4\n", "4:1: mesh.generate.cells",
          {"[40, 10, 10]"});
  refused("kind = \"cube\"\ncells = 0\n", "3:1: mesh.generate.cells", {"1 or more"});
  refused("kind = \"cube\"\ncells = [2, 2, 2]\n", "3:1: mesh.generate.cells", {"whole number"});
  refused("kind = \"cube\"\ncells = 2\nsize = [1, 1, 1]\n", "4:1: mesh.generate.size",
          {"number", "not a list"});
  refused("kind = \"tetrahedron\"\ncells = 2\n", "3:1: unknown key mesh.generate.cells",
          {"kind or size"});
}

TEST_F(SceneReader, MaterialParametersMustFitTogether) {
  expect_refusal(std::string(kSmall) + "mu = 3e5\n", "scene.toml:4:1: material.mu",
                 {"youngs_modulus and poissons_ratio"});
  expect_refusal(kSmall, "--set material.mu=3e5: material.mu", {"does not go with"},
                 {"material.density=2000", "material.mu=3e5"});
  expect_refusal("[mesh]\nfile = \"a.vtu\"\n[material]\nmu = 1.0\nlambda = -0.7\n",
                 "scene.toml:3:1: material: ", {"lambda = -0.7"});
}

TEST_F(SceneReader, SelectionsAreOfOneKind) {
  const auto refused = [this](const std::string& what, const std::string& start,
                              const std::vector<std::string>& parts) {
    expect_refused_lines("[[fix]]\nselect = { " + what + " }\n", "scene.toml:8:" + start, parts);
  };
  refused("", "1: fix.0.select is empty", {"vertices, plane, box"});
  refused("all = true, group = \"a\"", "1: fix.0.select has both group and all", {"one of"});
  refused("all = false", "12: fix.0.select.all", {"only be true"});
  refused("surface = false", "12: fix.0.select.surface", {"only be true"});
  refused("vertices = []", "12: fix.0.select.vertices has 0 entries", {"at least one"});
  refused("vertices = [-1]", "12: fix.0.select.vertices holds -1", {"0 or more"});
  refused("group = \"\"", "12: fix.0.select.group is empty", {});
  refused("plane = { axis = \"w\", at = 0 }", "22: fix.0.select.plane.axis", {"x, y or z"});
  refused("plane = { axis = \"x\", at = 0, tolerance = -1 }", "42: fix.0.select.plane.tolerance",
          {"0 or more"});
  refused("sphere = { center = [0, 0, 0], radius = 0 }", "43: fix.0.select.sphere.radius",
          {"above 0"});
  refused("box = { min = [0, 0, 1], max = [1, 1, 0] }", "37: fix.0.select.box.max", {"below min"});
}

TEST_F(SceneReader, FixesAreChecked) {
  const std::string fix = "[[fix]]\nselect = { all = true }\n";
  expect_refused_lines(fix + "target = [0, 0, 0]\noffset = [0, 0, 0]\n",
                       "scene.toml:10:1: fix.0.offset", {"target", "one of the two"});
  for (const char* components : {"xw", "xx", "X", "x,y"}) {
    expect_refused_lines(fix + "components = \"" + components + "\"\n",
                         std::string("scene.toml:9:1: fix.0.components = \"") + components + "\"",
                         {"each once"});
  }
  expect_refused_lines(fix + "components = \"\"\n", "scene.toml:9:1: fix.0.components is empty");
  expect_refused_lines(fix + "components = [\"x\"]\n", "scene.toml:9:1: fix.0.components",
                       {"not a list"});
}

TEST_F(SceneReader, ForcesEndAfterTheyBegin) {
  const std::string force = "[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n";
  expect_refused_lines(force + "from = 1\nuntil = 1\n", "scene.toml:11:1: force.0.until",
                       {"later than from"});
  expect_refused_lines(force + "until = 0\n", "scene.toml:10:1: force.0.until", {"from 0 s"});
}

TEST_F(SceneReader, SyntaxErrorsHaveALineAndAColumn) {
  expect_refusal("[mesh]\nfile = = 3\n", "scene.toml:2:8: not valid TOML: ");
  expect_refusal("[mesh\n", "scene.toml:1:6: not valid TOML: ");
  expect_refusal("a = 1\na = 2\n", "scene.toml:2:5: not valid TOML: ");
  expect_refusal(std::string("a = \"\xff\xfe\"\n"), "scene.toml:1:5: not valid TOML: ");
  expect_refusal("a = " + std::string(100000, '['), "scene.toml:1:", {"not valid TOML"});
  expect_refusal(std::string("a\0b = 1", 7), "scene.toml:1:", {"not valid TOML"});
}

TEST_F(SceneReader, FilesThatCannotBeReadAreFileErrors) {
  EXPECT_THROW(read_scene((folder_ / "none.toml").string()), FileError);
  EXPECT_THROW(read_scene(folder_.string()), FileError);
  EXPECT_THROW(read_scene(""), FileError);
  try {
    read_scene((folder_ / "none.toml").string());
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("none.toml: cannot read the scene: No such file"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(SceneReader, OverridesChangeAndAddKeys) {
  const Scene scene =
      read(kWhole, {"time.step=1e-4", " material.density = 2000 ", "time.integrator=midpoint",
                    "force.0.vector=[1, 2, 3]", "fix.1.components=\"y\"", "output.every=1",
                    "initial.velocity.2=7", "output.every=2"});
  EXPECT_EQ(scene.time.step, 1e-4);
  EXPECT_FALSE(scene.time.automatic);
  EXPECT_EQ(scene.time.integrator, Integrator::kMidpoint);
  EXPECT_EQ(scene.material.density, 2000.0);
  EXPECT_EQ(scene.force[0].vector, Vector3(1, 2, 3));
  EXPECT_EQ(scene.fix[1].components, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(scene.initial.velocity, Vector3(1, 0, 7));
  EXPECT_EQ(scene.output.every, 2);
}

TEST_F(SceneReader, OverridesMakeWhatIsAbsent) {
  const Scene scene =
      read(kSmall, {"environment.kind=gravity", "fix.0.select.plane.axis=x",
                    "fix.0.select.plane.at=0.5", "fix.1={select={all=true}, components='z'}",
                    "force=[{ select = { group = 'tip' }, vector = [0, 0, 1] }]",
                    "output.directory=out/my run"});
  EXPECT_EQ(scene.environment.kind, EnvironmentKind::kGravity);
  ASSERT_EQ(scene.fix.size(), 2U);
  EXPECT_EQ(std::get<SelectPlane>(scene.fix[0].select).at, 0.5);
  EXPECT_TRUE(std::holds_alternative<SelectAll>(scene.fix[1].select));
  EXPECT_EQ(std::get<SelectGroup>(scene.force.at(0).select).name, "tip");
  EXPECT_EQ(scene.output.directory, "out/my run");
}

TEST_F(SceneReader, MalformedOverridesAreRefused) {
  const auto refused = [this](const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal(kWhole, "--set " + text + ": ", parts, {text});
  };
  refused("time.step", {"KEY=VALUE"});
  refused("", {"KEY=VALUE"});
  refused("=3", {"part of the key is empty"});
  refused("time..step=3", {"part of the key is empty"});
  refused("time.=3", {"part of the key is empty"});
  refused("time.step=", {"value is missing"});
  refused("initial.velocity=[1, 2", {"not TOML"});
  refused("time.step=1\nend = 3", {"not TOML"});
  refused("mesh.file.name=3", {"mesh.file is a string", "no name"});
  refused("fix.select=3", {"fix is a list with 2 entries", "fix.0"});
  refused("fix.7.mode=exact", {"fix is a list with 2 entries", "fix.2"});
  refused("fix.-1.mode=exact", {"fix is a list"});
}

TEST_F(SceneReader, OverridesAreToBlameForTheirValues) {
  expect_refusal(kWhole, "--set time.stp=3: unknown key time.stp", {"did you mean step?"},
                 {"time.stp=3"});
  expect_refusal(kWhole, "--set fix.0.select.plane.at=here: fix.0.select.plane.at",
                 {"not a string"}, {"fix.0.select.plane.at=here"});
  expect_refusal(kWhole, "--set force.0={vector=[0,0,1]}: force.0.select is missing", {},
                 {"force.0={vector=[0,0,1]}"});
  // A value of the file stays at its place.
  expect_refusal("[mesh]\nscale = -1\nfile = \"a.vtu\"\n", "scene.toml:2:1: mesh.scale", {},
                 {"mesh.file=b.vtu"});
}

// --set for every leaf of the echo, made into TOML.
void list_overrides(const nlohmann::ordered_json& json, const std::string& key,
                    std::vector<std::string>& overrides) {
  const bool of_objects = json.is_array() && !json.empty() && json[0].is_object();
  if (!json.is_object() && !of_objects) {
    overrides.push_back(key + "=" + json.dump());
    return;
  }
  std::size_t index = 0;
  for (const auto& item : json.items()) {
    std::string path = key;
    if (!path.empty()) path += '.';
    path += json.is_object() ? item.key() : std::to_string(index++);
    list_overrides(item.value(), path, overrides);
  }
}

TEST_F(SceneReader, TheEchoIsTheSceneInEffect) {
  const Scene scene = read(kWhole, {"time.end=7"});
  const auto echo = nlohmann::ordered_json::parse(scene.echo);
  EXPECT_EQ(echo["time"]["end"], 7.0);
  EXPECT_EQ(echo["time"]["step"], "auto");
  EXPECT_EQ(echo["environment"]["direction"], nlohmann::ordered_json({0.0, 0.0, -1.0}));
  EXPECT_EQ(echo["fix"][0]["components"], "xz");
  EXPECT_EQ(nlohmann::json::parse(read(kSmall).echo)["output"]["every"], OutputSettings{}.every);
}

TEST_F(SceneReader, TheEchoReadsBackAsTheSameScene) {
  for (const std::string& text :
       {std::string(kWhole), std::string(kSmall),
        std::string("[mesh]\ngenerate = { kind = \"beam\", size = [4, 1, 1], cells = [8, 2, 2] }\n"
                    "[material]\nmodel = \"stvk\"\nmu = 1\nlambda = 0.1\n"
                    "[[fix]]\nselect = { box = { min = [0, 0, 0], max = [0, 1, 1] } }\n"
                    "[[fix]]\nselect = { group = \"a\" }\n[[fix]]\nselect = { surface = true }\n"
                    "[[force]]\nselect = { all = true }\nvector = [0.1, 0, 0]\nuntil = 0.3\n"),
        std::string("[mesh]\ngenerate = { kind = \"cube\", cells = 2 }\n"
                    "[material]\nmodel = \"mooney-rivlin\"\nmu1 = 1\nmu2 = 0.5\nlambda = 0.1\n"),
        std::string("[mesh]\ngenerate = { kind = \"tetrahedron\", size = 0.1 }\n"
                    "[material]\nmu = 1\nlambda = 0.1\n")}) {
    const std::string echo = read(text).echo;
    std::vector<std::string> overrides;
    list_overrides(nlohmann::ordered_json::parse(echo), "", overrides);
    EXPECT_EQ(read("", overrides).echo, echo);
  }
}

// No scene cut off anywhere, and none with one byte changed, may do anything but pass or be
// refused.
TEST_F(SceneReader, DamagedScenesPassOrAreRefused) {
  const std::string whole = kWhole;
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char byte : {'\0', '"', '[', '=', '9', '\xff'}) {
      std::string damaged = whole;
      damaged[i] = byte;
      refused += refusal(damaged) == "accepted" ? 0 : 1;
    }
    refused += refusal(whole.substr(0, i)) == "accepted" ? 0 : 1;
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace tetraction
