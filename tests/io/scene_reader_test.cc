#include "tetraction/io/scene_reader.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/quoting.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_writer.h"

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
  // The same for lines added to the small scene, whose last line is the sixth.
  void expect_refused_lines(const std::string& lines, const std::string& start,
                            const std::vector<std::string>& parts = {}) const {
    expect_refusal(kSmall + lines, start, parts);
  }

  testing_support::TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
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
  const auto faces = std::get<SelectFaces>(select("faces = { normal = [0, 2, 0] }"));
  EXPECT_EQ(faces.normal, Vector3(0, 2, 0));
  EXPECT_EQ(faces.angle, 30.0);
  const SelectPlane low{1, 0.0, {}};
  const SelectNearest tip{{1, 2, 3}};
  const std::string parts = "[{ plane = { axis = \"y\", at = 0 } }, { nearest = [1, 2, 3] }]";
  EXPECT_EQ(select("all_of = " + parts),
            Selection(SelectSet{SetOperation::kAllOf, {{low}, {tip}}}));
  EXPECT_EQ(select("any_of = " + parts),
            Selection(SelectSet{SetOperation::kAnyOf, {{low}, {tip}}}));
  const SelectSet outside{SetOperation::kNot, {{SelectSet{SetOperation::kAnyOf, {{low}, {tip}}}}}};
  EXPECT_EQ(select("not = { any_of = " + parts + " }"), Selection(outside));
}

TEST_F(SceneReader, ReadsNamedSelections) {
  const std::string names =
      "[selection.clamp]\nplane = { axis = \"x\", at = 0 }\n"
      "[selection.\"the rest\"]\nnot = \"clamp\"\n"
      "[selection.both]\nany_of = [\"the rest\", \"clamp\", { nearest = [1, 2, 3] }]\n";
  const Scene scene =
      read(std::string(kSmall) +
           "[[fix]]\nselect = \"clamp\"\n"
           "[[force]]\nselect = { all_of = [\"both\", { surface = true }] }\nvector = [1, 0, 0]\n"
           "[[event]]\nat = 0.1\nunfix = { select = \"clamp\" }\n"
           "[[event]]\nat = 0.2\nset = { \"fix.0.select\" = \"the rest\" }\n"
           "[[event]]\nat = 0.3\nfix = { select = \"both\" }\n" +
           names);
  const SelectNamed clamp{"clamp", {{SelectPlane{0, 0.0, {}}}}};
  const SelectNamed rest{"the rest", {{SelectSet{SetOperation::kNot, {{clamp}}}}}};
  const SelectNamed both{
      "both", {{SelectSet{SetOperation::kAnyOf, {{rest}, {clamp}, {SelectNearest{{1, 2, 3}}}}}}}};
  EXPECT_EQ(scene.fix[0].select, Selection(clamp));
  EXPECT_EQ(scene.force[0].select,
            Selection(SelectSet{SetOperation::kAllOf, {{both}, {SelectSurface{}}}}));
  ASSERT_EQ(scene.selection.size(), 3U);
  EXPECT_EQ(scene.selection[0].name, "both");
  EXPECT_EQ(scene.selection[0].select, both.of[0].selection);
  EXPECT_EQ(std::get<Unfix>(scene.event[0].edits[0]).select, Selection(clamp));
  EXPECT_EQ(std::get<SetFix>(scene.event[1].edits[0]).fix.select, Selection(rest));
  EXPECT_EQ(std::get<SetFix>(scene.event[2].edits[0]).fix.select, Selection(both));
  const auto echo = nlohmann::json::parse(scene.echo);
  EXPECT_EQ(echo["fix"][0]["select"], "clamp");
  EXPECT_EQ(echo["selection"]["the rest"]["not"], "clamp");
  EXPECT_EQ(echo["selection"]["both"]["any_of"].size(), 3U);
}

TEST_F(SceneReader, RefusesNamedSelectionsThatMakeNoSense) {
  const auto refused = [this](const std::string& select, const std::string& names) {
    return refusal(std::string(kSmall) + "[[fix]]\nselect = " + select + "\n" + names);
  };
  const std::string clamp = "[selection.clamp]\nsurface = true\n[selection.tip]\nall = true\n";
  const std::string unknown = refused("\"clmp\"", clamp);
  EXPECT_NE(unknown.find("8:1: fix.0.select = \"clmp\""), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("did you mean clamp? the scene has clamp or tip."), std::string::npos)
      << unknown;
  const std::string inner = refused("{ not = { all_of = [\"clamp\", \"tipp\"] } }", clamp);
  EXPECT_NE(inner.find("fix.0.select.not.all_of = \"tipp\""), std::string::npos) << inner;
  EXPECT_NE(refused("\"clamp\"", "").find("no named selections"), std::string::npos);
  const std::string itself = refused("\"a\"",
                                     "[selection.a]\nnot = \"b\"\n"
                                     "[selection.b]\nany_of = [{ all = true }, \"a\"]\n");
  EXPECT_NE(itself.find("refer to itself: a → b → a."), std::string::npos) << itself;
  EXPECT_NE(refused("7", clamp).find("must be a selection"), std::string::npos);
  EXPECT_NE(refused("{ all_of = [] }", clamp).find("one or more selections"), std::string::npos);
  EXPECT_NE(refused("{ all_of = \"clamp\" }", clamp).find("must be a list"), std::string::npos);
  EXPECT_NE(refused("{ any_of = [3] }", clamp).find("not a"), std::string::npos);
  EXPECT_NE(refused("{ not = [\"clamp\"] }", clamp).find("must be a selection"), std::string::npos);
  EXPECT_NE(refused("\"clamp\"", "[selection]\nclamp = \"tip\"\n").find("must be a table"),
            std::string::npos);
  EXPECT_NE(refused("\"clamp\"", "[[selection]]\nall = true\n").find("must be a table"),
            std::string::npos);
  EXPECT_NE(refused("{ faces = { normal = [0, 0, 0] } }", "").find("must not be zero"),
            std::string::npos);
  // A definition that nobody uses is checked as well.
  EXPECT_NE(refused("{ all = true }", "[selection.c]\nall = false\n").find("selection.c.all"),
            std::string::npos);
  EXPECT_NE(refusal(std::string(kSmall) + clamp +
                    "[[event]]\nat = 0.1\nset = { \"selection.clamp.all\" = true }\n")
                .find("cannot change during a run"),
            std::string::npos);
  // Names within names, which would stand for 2^40 selections.
  std::string doubled = "[selection.n0]\nall = true\n";
  for (int i = 1; i <= 40; ++i) {
    doubled += "[selection.n" + std::to_string(i) + "]\nany_of = [\"n" + std::to_string(i - 1) +
               "\", \"n" + std::to_string(i - 1) + "\"]\n";
  }
  EXPECT_NE(refused("{ all = true }", doubled).find("more than 10000 selections"),
            std::string::npos);
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
  expect_refused_lines("[material_regoin]\n", "scene.toml:7:2: unknown key material_regoin",
                       {"did you mean material_region?"});
  expect_refused_lines("[damping]\nviscousity = 1\n",
                       "scene.toml:8:1: unknown key damping.viscousity",
                       {"did you mean viscosity?"});
  expect_refused_lines("[environment]\nkind = \"attraction\"\nsoftning = 1\n",
                       "scene.toml:9:1: unknown key environment.softning",
                       {"did you mean softening?"});
  expect_refused_lines("[[fix]]\nselect = { all = true }\npenality = 1\n",
                       "scene.toml:9:1: unknown key fix.0.penality", {"did you mean penalty?"});
  expect_refused_lines("[[constraint]]\nkind = \"distance\"\nlenght = 1\n",
                       "scene.toml:9:1: unknown key constraint.0.lenght", {"did you mean length?"});
  expect_refused_lines("[[material_region]]\nselect = { all = true }\nyoungs_modlus = 1\n",
                       "scene.toml:9:1: unknown key material_region.0.youngs_modlus",
                       {"did you mean youngs_modulus?"});
  expect_refused_lines("[[event]]\nat = 1\nunfx = { all = true }\n",
                       "scene.toml:9:1: unknown key event.0.unfx", {"did you mean unfix?"});
  expect_refused_lines(
      "[[event]]\nat = 1\nmomentum = { select = { all = true }, valu = [0, 0, 1] }\n",
      "scene.toml:9:39: unknown key event.0.momentum.valu", {"did you mean value?"});
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
                       {"valid are integrator, step, end, retry"});
  expect_refused_lines("[" + std::string(5000, 'q') + "]\n", "scene.toml:7:2: unknown key qqq",
                       {"valid are mesh, material"});
}

TEST_F(SceneReader, SolversAndTheirLinearSolvers) {
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    const Scene scene = read(kSmall + std::string("[solver]\nkind = \"newton\"\nlinear = \"") +
                             to_string(linear) + "\"\n");
    EXPECT_EQ(scene.solver.kind, "newton");
    EXPECT_EQ(scene.solver.linear, linear);
    EXPECT_NE(scene.echo.find("\"linear\": \"" + to_string(linear) + "\""), std::string::npos);
  }
  const Scene ceres = read(kSmall + std::string("[solver]\nkind = \"ceres\"\nlinear = \"auto\"\n"));
  EXPECT_EQ(ceres.solver.kind, "ceres");
  EXPECT_EQ(ceres.solver.linear, LinearSolver::kAuto);

  expect_refused_lines("[solver]\nkind = \"newtn\"\n", "scene.toml:8:1: solver.kind",
                       {"did you mean newton?"});
  expect_refused_lines("[solver]\nkind = \"newton\"\nlinear = \"matrixfree\"\n",
                       "scene.toml:9:1: solver.linear", {"did you mean matrix-free?"});
  for (const char* linear : {"matrix-free", "cg", "factor"}) {
    expect_refused_lines(std::string("[solver]\nlinear = \"") + linear + "\"\nkind = \"ceres\"\n",
                         "scene.toml:8:1: solver.linear",
                         {linear, "solver.kind = \"newton\"", "leave linear out"});
  }
}

TEST_F(SceneReader, UnknownWordsAreRefusedWithTheNearest) {
  expect_refused_lines("[time]\nintegrator = \"mid-point\"\n",
                       "scene.toml:8:1: time.integrator = \"mid-point\"",
                       {"did you mean midpoint?"});
  expect_refused_lines("[time]\nintegrator = \"rk4\"\n", "scene.toml:8:1: time.integrator",
                       {"explicit, verlet, midpoint, backward-euler or energy-momentum"});
  expect_refusal(kSmall, "--set material.model=neohookean: material.model",
                 {"did you mean neo-hookean?"}, {"material.model=neohookean"});
  expect_refused_lines("[environment]\nkind = \"wind\"\n", "scene.toml:8:1: environment.kind",
                       {"none, gravity or attraction"});
  // What only programs can set has no word in a file.
  expect_refused_lines("[environment]\nkind = \"custom\"\n", "scene.toml:8:1: environment.kind",
                       {"none, gravity or attraction"});
  expect_refusal(kSmall, "--set material.model=custom: material.model",
                 {"stvk, neo-hookean, mooney-rivlin or yeoh"}, {"material.model=custom"});
  expect_refusal("[mesh]\ngenerate = { kind = \"ball\" }\n",
                 "scene.toml:2:14: mesh.generate.kind = \"ball\"", {"beam, box, cube"});
}

TEST_F(SceneReader, UnknownKindsAndModesAreRefusedWithTheNearest) {
  expect_refused_lines("[environment]\nkind = \"atraction\"\n", "scene.toml:8:1: environment.kind",
                       {"did you mean attraction?"});
  expect_refused_lines("[[fix]]\nselect = { all = true }\nmode = \"penalties\"\n",
                       "scene.toml:9:1: fix.0.mode = \"penalties\"", {"did you mean penalty?"});
  expect_refused_lines("[[fix]]\nselect = { all = true }\nmode = \"soft\"\n",
                       "scene.toml:9:1: fix.0.mode = \"soft\"", {"exact or penalty"});
  expect_refused_lines("[[constraint]]\nkind = \"distanse\"\n",
                       "scene.toml:8:1: constraint.0.kind = \"distanse\"",
                       {"did you mean distance?"});
  expect_refused_lines("[[constraint]]\nkind = \"weld\"\n",
                       "scene.toml:8:1: constraint.0.kind = \"weld\"",
                       {"distance, plane, line or rigid"});
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
                       {"no named selections", "give a selection"});
  expect_refused_lines("[[fix]]\nselect = 3\n", "scene.toml:8:1: fix.0.select",
                       {"must be a selection", "not a"});
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
                 "scene.toml:3:1: mesh.generate",
                 {"mesh.file and mesh.generate", "Leave one of the two out"});
  expect_refusal("[mesh]\ngenerate = { kind = \"tetrahedron\" }\n",
                 "--set mesh.file=a.vtu: mesh.file", {"Leave one of the two out"},
                 {"mesh.file=a.vtu"});
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
  refused("kind = \"tetrahedron\"\ncells = 2\n", "3:1: mesh.generate.cells does not belong to",
          {"kind = \"tetrahedron\"", "takes size."});
  refused("kind = \"cube\"\nsize = 2\n", "1:1: mesh.generate.cells is missing",
          {"number of cells along an edge"});
}

TEST_F(SceneReader, MaterialParametersMustFitTogether) {
  expect_refusal(std::string(kSmall) + "mu = 3e5\n", "scene.toml:4:1: material.mu",
                 {"youngs_modulus and poissons_ratio"});
  expect_refusal(kSmall, "--set material.mu=3e5: material.mu", {"cannot be combined"},
                 {"material.density=2000", "material.mu=3e5"});
  expect_refusal("[mesh]\nfile = \"a.vtu\"\n[material]\nmu = 1.0\nlambda = -0.7\n",
                 "scene.toml:3:1: material: ", {"lambda = -0.7"});
}

// A scene of one material with these lines.
std::string with_material(const std::string& lines) {
  return "[mesh]\nfile = \"bar.vtu\"\n[material]\n" + lines;
}

TEST_F(SceneReader, YeohIsGivenByItsOwnParameters) {
  const Scene scene = read(
      with_material("model = \"yeoh\"\nc10 = 0.19e6\nc20 = -1.45e3\nc30 = 38.8\nkappa = 3e6\n"));
  const Yeoh material = std::get<Yeoh>(make_material(scene.material));
  EXPECT_EQ(material.c10(), 0.19e6);
  EXPECT_EQ(material.c20(), -1.45e3);
  EXPECT_EQ(material.c30(), 38.8);
  EXPECT_EQ(material.kappa(), 3e6);
  EXPECT_EQ(scene.material.density, 1000.0);
  const auto echo = nlohmann::json::parse(scene.echo).at("material");
  EXPECT_EQ(echo, nlohmann::json::parse(R"({"model": "yeoh", "c10": 190000.0, "c20": -1450.0,
                                            "c30": 38.8, "kappa": 3e6, "density": 1000.0})"));
}

TEST_F(SceneReader, YeohIsGivenByYoungsModulusAndPoissonsRatio) {
  const Scene scene = read(std::string(kSmall) + "model = \"yeoh\"\nc20 = -2e3\nc30 = 0\n");
  const Yeoh material = std::get<Yeoh>(make_material(scene.material));
  const double mu = 1e6 / 2.8;
  EXPECT_NEAR(material.c10(), 0.5 * mu, 1e-9);
  EXPECT_NEAR(material.kappa(), 1e6 / (3.0 * (1.0 - 0.8)), 1e-8);
  EXPECT_EQ(material.c20(), -2e3);
  EXPECT_EQ(material.c30(), 0.0);
}

TEST_F(SceneReader, YeohNeedsOneCompleteSetOfParameters) {
  const std::string own = "model = \"yeoh\"\nc10 = 1e5\nc20 = 0\nc30 = 0\nkappa = 1e6\n";
  ASSERT_NO_THROW(read(with_material(own)));
  const std::vector<std::string> both = {"c10, c20, c30 and kappa",
                                         "youngs_modulus, poissons_ratio, c20 and c30"};
  for (const char* missing : {"c10", "c20", "c30", "kappa"}) {
    std::string text = own;
    const auto begin = text.find(std::string(missing) + " =");
    text.erase(begin, text.find('\n', begin) + 1 - begin);
    expect_refusal(with_material(text),
                   std::string("scene.toml:3:1: material.") + missing + " is missing", both);
  }
  expect_refusal(with_material(own + "youngs_modulus = 1e6\npoissons_ratio = 0.4\n"),
                 "scene.toml:3:1: material.c10 cannot be combined", both);
  expect_refusal(std::string(kSmall) + "model = \"yeoh\"\nc20 = 0\n",
                 "scene.toml:4:1: material.c30 is missing", both);
  expect_refusal(with_material(own + "mu = 1e5\n"), "scene.toml:3:1: material.mu cannot", both);
  expect_refusal(with_material("model = \"stvk\"\nmu = 1\nlambda = 1\nc20 = 1\n"),
                 "scene.toml:3:1: material.c20 cannot", {"mu and lambda"});
  const auto refused_value = [&](const std::string& key, const std::string& value,
                                 const std::string& why) {
    const std::string set = std::string("material.").append(key).append("=").append(value);
    expect_refusal(with_material(own), "--set " + set + ": material." + key + " = " + value, {why},
                   {set});
  };
  refused_value("c10", "0", "above 0");
  refused_value("c10", "-1", "above 0");
  refused_value("kappa", "0", "above 0");
  refused_value("c20", "1e+31", "between 1e-30 and 1e30");
  refused_value("c30", "nan", "finite");
}

TEST_F(SceneReader, TheVolumetricPartIsChosenByItsName) {
  const auto part_of = [this](const std::string& lines) {
    return std::get<NeoHookean>(make_material(read(kSmall + lines).material)).volumetric();
  };
  EXPECT_EQ(part_of(""), VolumetricPart::kLogarithmic);
  EXPECT_EQ(part_of("volumetric = \"log\"\n"), VolumetricPart::kLogarithmic);
  EXPECT_EQ(part_of("volumetric = \"quadratic\"\n"), VolumetricPart::kQuadratic);
  const Scene mooney = read(std::string(kSmall) +
                            "model = \"mooney-rivlin\"\nratio = 0.2\nvolumetric = \"quadratic\"\n");
  EXPECT_EQ(std::get<MooneyRivlin>(make_material(mooney.material)).volumetric(),
            VolumetricPart::kQuadratic);
  // The echo has it only if the scene has it.
  const auto echo_of = [this](const std::string& lines) {
    return nlohmann::json::parse(read(kSmall + lines).echo).at("material");
  };
  EXPECT_FALSE(echo_of("").contains("volumetric"));
  EXPECT_EQ(echo_of("volumetric = \"log\"\n").at("volumetric"), "log");
  EXPECT_EQ(echo_of("volumetric = \"quadratic\"\n").at("volumetric"), "quadratic");
}

TEST_F(SceneReader, TheVolumetricPartIsChecked) {
  expect_refusal(std::string(kSmall) + "volumetric = \"quadratc\"\n",
                 "scene.toml:7:1: material.volumetric = \"quadratc\"", {"did you mean quadratic?"});
  expect_refusal(std::string(kSmall) + "volumetric = \"cubic\"\n",
                 "scene.toml:7:1: material.volumetric = \"cubic\"", {"log or quadratic"});
  expect_refusal(std::string(kSmall) + "volumetric = 2\n", "scene.toml:7:1: material.volumetric",
                 {"text in quotes"});
  for (const std::string model : {"model = \"stvk\"\n", "model = \"yeoh\"\nc20 = 0\nc30 = 0\n"}) {
    expect_refusal(kSmall + model + "volumetric = \"log\"\n",
                   "scene.toml:4:1: material.volumetric has no meaning", {"leave it out"});
  }
}

// Both laws come back from a file that the writer wrote, also when an event chooses them.
TEST_F(SceneReader, MaterialsSurviveWritingAndReading) {
  const std::string quadratic = std::string(kSmall) + "volumetric = \"quadratic\"\n";
  const std::string own =
      with_material("model = \"yeoh\"\nc10 = 1e5\nc20 = -3e3\nc30 = 50\nkappa = 1e6\n");
  const std::string young = std::string(kSmall) + "model = \"yeoh\"\nc20 = -3e3\nc30 = 50\n";
  const std::string event =
      "[[event]]\nat = 0.5\nunset = [\"material.volumetric\"]\nset = { \"material.model\" = "
      "\"yeoh\", \"material.c20\" = 0, \"material.c30\" = 40 }\n";
  for (const std::string& text : {quadratic, own, young, quadratic + event}) {
    const Scene scene = read(text);
    const std::string copy = (folder_ / "copy.toml").string();
    write_scene(scene, copy);
    const Scene again = read_scene(copy);
    EXPECT_EQ(scene_text(again, folder_.string()), scene_text(scene, folder_.string())) << text;
    EXPECT_EQ(nlohmann::json::parse(again.echo).at("material"),
              nlohmann::json::parse(scene.echo).at("material"));
    ASSERT_EQ(again.event.size(), scene.event.size());
    for (const EventSettings& changed : again.event) {
      const auto& edit = std::get<SetMaterial>(changed.edits.at(0));
      EXPECT_EQ(std::get<Yeoh>(make_material(edit.material)).c30(), 40.0);
    }
  }
}

// What an engineer gets to read who selects in two ways or gives two targets.
TEST_F(SceneReader, KeysTooManyAreToldWithTheOthers) {
  const std::string fix = "[[fix]]\nselect = { vertices = [3, 4] }\n";
  expect_refused_lines(fix + "targets = [[0, 0, 0]]\n", "scene.toml:9:1: fix.0.targets",
                       {"1 places for the 2 vertices"});
  expect_refused_lines(fix + "targets = [[0, 0, 0], [0, 0, 1]]\ntarget = [0, 0, 0]\n",
                       "scene.toml:9:1: fix.0.targets", {"Leave all but one of them out"});
  expect_refused_lines("[[fix]]\nselect = { all = true }\ntargets = [[0, 0, 0]]\n",
                       "scene.toml:9:1: fix.0.targets", {"needs select = { vertices = [...] }"});
  expect_refused_lines("[[event]]\nat = 0\nunfix = { all = true, select = { all = true } }\n",
                       "scene.toml:9:23: event.0.unfix.select", {"selected in two ways"});
  expect_refused_lines("[[event]]\nat = 0\nunfix = { all = true, fix = 0 }\n",
                       "scene.toml:9:23: event.0.unfix.fix = 0",
                       {"at that time there is no [[fix]]"});
  expect_refused_lines(fix + "[[event]]\nat = 0\nunfix = { all = true, fix = 1 }\n",
                       "scene.toml:11:23: event.0.unfix.fix = 1",
                       {"the only [[fix]] has the number 0"});
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
                       "scene.toml:10:1: fix.0.offset", {"target and offset", "Leave one"});
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

TEST_F(SceneReader, ReadsProbesAndTheKeysOfOutput) {
  const Scene scene = read(std::string(kSmall) + R"(
[output]
history_every = 5
fields = ["default", "pressure"]
precision = "float32"
compression = "none"
[[probe]]
name = "tip_1"
select = { plane = { axis = "x", at = 4.0 } }
quantity = "reaction"
every = 3
[[probe]]
name = "middle"
point = [2.0, 0.5, 0.5]
quantity = "cauchy_stress"
)");
  EXPECT_EQ(scene.output.history_every, 5);
  EXPECT_EQ(scene.output.fields, (std::vector<std::string>{"default", "pressure"}));
  EXPECT_EQ(scene.output.precision, FramePrecision::kFloat32);
  EXPECT_EQ(scene.output.compression, FrameCompression::kNone);
  ASSERT_EQ(scene.probe.size(), 2U);
  EXPECT_EQ(scene.probe[0].name, "tip_1");
  EXPECT_EQ(std::get<SelectPlane>(scene.probe[0].select).at, 4.0);
  EXPECT_FALSE(scene.probe[0].point.has_value());
  EXPECT_EQ(scene.probe[0].quantity, ProbeQuantity::kReaction);
  EXPECT_EQ(scene.probe[0].every, 3);
  EXPECT_EQ(*scene.probe[1].point, Vector3(2.0, 0.5, 0.5));
  EXPECT_EQ(scene.probe[1].quantity, ProbeQuantity::kCauchyStress);
  EXPECT_EQ(scene.probe[1].every, 1);
  EXPECT_NE(scene.echo.find("\"middle\""), std::string::npos);
}

TEST_F(SceneReader, ProbesAndTheKeysOfOutputAreChecked) {
  const std::string tip = "[[probe]]\nname = \"tip\"\n";
  const std::string all = "select = { all = true }\n";
  expect_refused_lines(tip + "quantity = \"velocity\"\n", "scene.toml:7:1: probe.0.select",
                       {"point = [x, y, z]"});
  expect_refused_lines(tip + all + "point = [0, 0, 0]\nquantity = \"velocity\"\n",
                       "scene.toml:10:1: probe.0.point is one key too many");
  expect_refused_lines(tip + all + "quantity = \"velocty\"\n",
                       "scene.toml:10:1: probe.0.quantity = \"velocty\"",
                       {"did you mean velocity?"});
  expect_refused_lines(tip + all, "scene.toml:7:1: probe.0.quantity is missing");
  expect_refused_lines("[[probe]]\nquantity = \"force\"\n" + all,
                       "scene.toml:7:1: probe.0.name is missing");
  expect_refused_lines("[[probe]]\nname = \"a b\"\nquantity = \"force\"\n" + all,
                       "scene.toml:8:1: probe.0.name = \"a b\"", {"letters"});
  expect_refused_lines(tip + "point = [0, 0, 0]\nquantity = \"force\"\n",
                       "scene.toml:10:1: probe.0.quantity = \"force\" is a sum");
  expect_refused_lines(tip + all + "quantity = \"force\"\nevery = 0\n",
                       "scene.toml:11:1: probe.0.every");
  expect_refused_lines("[output]\nfields = [\"displacment\"]\n",
                       "scene.toml:8:1: output.fields has \"displacment\"",
                       {"did you mean \"displacement\"?", "von_mises_nodal"});
  expect_refused_lines("[output]\ncompression = \"gzip\"\n", "scene.toml:8:1: output.compression",
                       {"lz4, zlib or none"});
  expect_refused_lines("[output]\nprecision = \"double\"\n", "scene.toml:8:1: output.precision",
                       {"float32 or float64"});
  expect_refused_lines("[output]\nhistory_every = 0\n", "scene.toml:8:1: output.history_every");
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
    expect_refusal(kWhole, "--set " + excerpt(text) + ": ", parts, {text});
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

// What came with constraints, damping, regions and events; the lines follow the small scene's.
constexpr const char* kMechanics = R"(
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

TEST_F(SceneReader, DampingIsReadAndNotNegative) {
  const Scene none = read(kSmall);
  EXPECT_EQ(none.damping.drag, 0.0);
  EXPECT_EQ(none.damping.mass_damping, 0.0);
  EXPECT_EQ(none.damping.viscosity, 0.0);
  const Scene scene = read(std::string(kSmall) + kMechanics);
  EXPECT_EQ(scene.damping.drag, 0.25);
  EXPECT_EQ(scene.damping.mass_damping, 2.0);
  EXPECT_EQ(scene.damping.viscosity, 40.5);
  for (const std::string key : {"drag", "mass_damping", "viscosity"}) {
    expect_refused_lines("[damping]\n" + key + " = -0.1\n",
                         "scene.toml:8:1: damping." + key + " = -0.1", {"0 or more"});
    for (const std::string value : {"inf", "nan"}) {
      expect_refused_lines("[damping]\n" + key + " = " + value + "\n",
                           "scene.toml:8:1: damping." + key, {"finite"});
    }
    expect_refused_lines("[damping]\n" + key + " = \"strong\"\n", "scene.toml:8:1: damping." + key,
                         {"must be a number"});
  }
}

TEST_F(SceneReader, AttractionIsRead) {
  EXPECT_EQ(read(kSmall).environment.softening, 0.0);
  const Scene scene = read(std::string(kSmall) + kMechanics);
  EXPECT_EQ(scene.environment.kind, EnvironmentKind::kAttraction);
  EXPECT_EQ(scene.environment.strength, 1e4);
  EXPECT_EQ(scene.environment.softening, 0.125);
  const std::string attraction = "[environment]\nkind = \"attraction\"\n";
  EXPECT_EQ(read(kSmall + attraction).environment.softening, 0.0);
  EXPECT_EQ(read(kSmall + attraction).environment.strength, EnvironmentSettings{}.strength);
  expect_refused_lines(attraction + "strength = -1\n", "scene.toml:9:1: environment.strength = -1",
                       {"0 or more"});
  expect_refused_lines(attraction + "softening = -1e-3\n", "scene.toml:9:1: environment.softening",
                       {"-0.001", "0 or more"});
  expect_refused_lines(attraction + "softening = inf\n", "scene.toml:9:1: environment.softening",
                       {"finite"});
}

TEST_F(SceneReader, MovingFixesAndPenaltiesAreRead) {
  const Scene scene = read(std::string(kSmall) + kMechanics);
  ASSERT_EQ(scene.fix.size(), 2U);
  EXPECT_EQ(scene.fix[0].velocity, Vector3(0, 0.5, 0));
  EXPECT_EQ(scene.fix[0].components, (std::array<bool, 3>{true, true, false}));
  EXPECT_FALSE(scene.fix[0].is_penalty);
  EXPECT_EQ(scene.fix[1].velocity, Vector3::Zero());
  EXPECT_TRUE(scene.fix[1].is_penalty);
  EXPECT_EQ(scene.fix[1].penalty, 1e5);
  EXPECT_EQ(scene.fix[1].offset, Vector3(0, 0, 0.1));
  EXPECT_FALSE(scene.fix[1].target);

  const std::string fix = "[[fix]]\nselect = { all = true }\n";
  expect_refused_lines(fix + "mode = \"penalty\"\n", "scene.toml:7:1: fix.0.penalty is missing",
                       {"N/m"});
  for (const char* value : {"0", "-1e5"}) {
    expect_refused_lines(fix + "mode = \"penalty\"\npenalty = " + value + "\n",
                         "scene.toml:10:1: fix.0.penalty", {"above 0"});
  }
  expect_refused_lines(fix + "mode = \"penalty\"\npenalty = inf\n",
                       "scene.toml:10:1: fix.0.penalty", {"finite"});
  expect_refused_lines(fix + "velocity = 1\n", "scene.toml:9:1: fix.0.velocity",
                       {"must be a list"});
  expect_refused_lines(fix + "velocity = [0, nan, 0]\n", "scene.toml:9:1: fix.0.velocity",
                       {"finite"});
}

TEST_F(SceneReader, ConstraintsAreRead) {
  EXPECT_TRUE(read(kSmall).constraint.empty());
  const Scene scene = read(std::string(kSmall) + kMechanics);
  ASSERT_EQ(scene.constraint.size(), 5U);
  const ConstraintSettings& distance = scene.constraint[0];
  EXPECT_EQ(distance.kind, ConstraintKind::kDistance);
  EXPECT_EQ(distance.vertices, (std::array<std::int64_t, 2>{3, 40}));
  EXPECT_EQ(distance.length, 1.5);
  EXPECT_EQ(distance.where, path_ + ":41:1: constraint.0");
  const ConstraintSettings& plane = scene.constraint[1];
  EXPECT_EQ(plane.kind, ConstraintKind::kPlane);
  EXPECT_EQ(std::get<SelectVertices>(plane.select).ids, (std::vector<std::int64_t>{5}));
  EXPECT_EQ(plane.point, Vector3(0, 0, 1));
  EXPECT_EQ(plane.direction.normalized(), Vector3(0, 0, 1));
  const ConstraintSettings& line = scene.constraint[2];
  EXPECT_EQ(line.kind, ConstraintKind::kLine);
  EXPECT_FALSE(line.point);
  EXPECT_LT((line.direction.normalized() - Vector3(0, 0.6, 0.8)).norm(), 1e-15);
  const ConstraintSettings& free_handle = scene.constraint[3];
  EXPECT_EQ(free_handle.kind, ConstraintKind::kRigid);
  EXPECT_FALSE(free_handle.is_driven());
  const ConstraintSettings& driven = scene.constraint[4];
  EXPECT_EQ(driven.kind, ConstraintKind::kRigid);
  EXPECT_EQ(std::get<SelectGroup>(driven.select).name, "grip");
  EXPECT_TRUE(driven.is_driven());
  EXPECT_EQ(driven.velocity, Vector3(1, 0, 0));
  EXPECT_EQ(driven.angular_velocity, Vector3(0, 0, 2));

  const std::string rest = "[[constraint]]\nkind = \"distance\"\nvertices = [0, 1]\n";
  EXPECT_FALSE(read(kSmall + rest).constraint[0].length);
  EXPECT_TRUE(
      read(kSmall + std::string("[[constraint]]\nkind = \"rigid\"\nselect = { all = true }\n"
                                "velocity = [0, 0, 0]\n"))
          .constraint[0]
          .is_driven());
}

TEST_F(SceneReader, ConstraintsAreChecked) {
  const auto refused = [this](const std::string& lines, const std::string& start,
                              const std::vector<std::string>& parts = {}) {
    expect_refused_lines("[[constraint]]\n" + lines, "scene.toml:" + start, parts);
  };
  refused("", "7:1: constraint.0.kind is missing", {"\"distance\"", "\"rigid\""});
  refused("vertices = [0, 1]\n", "7:1: constraint.0.kind is missing");
  refused("kind = 3\n", "8:1: constraint.0.kind", {"text in quotes"});

  const std::string distance = "kind = \"distance\"\n";
  refused(distance, "7:1: constraint.0.vertices is missing", {"[a, b]"});
  for (const char* pair : {"[4, 4]", "[4]", "[1, 2, 3]"}) {
    refused(distance + "vertices = " + pair + "\n", "9:1: constraint.0.vertices",
            {"two different vertices"});
  }
  refused(distance + "vertices = []\n", "9:1: constraint.0.vertices", {"has 0 entries"});
  refused(distance + "vertices = [-1, 2]\n", "9:1: constraint.0.vertices holds -1", {"0 or more"});
  refused(distance + "vertices = 3\n", "9:1: constraint.0.vertices", {"must be a list"});
  for (const char* length : {"0", "-1.0"}) {
    refused(distance + "vertices = [0, 1]\nlength = " + length + "\n", "10:1: constraint.0.length",
            {"above 0"});
  }
  refused(distance + "vertices = [0, 1]\nlength = inf\n", "10:1: constraint.0.length", {"finite"});

  const std::string all = "select = { all = true }\n";
  for (const auto& [kind, key] : {std::pair("plane", "normal"), std::pair("line", "direction")}) {
    const std::string head = std::string("kind = \"") + kind + "\"\n";
    const std::string name = std::string("constraint.0.") + key;
    refused(head + key + " = [1, 0, 0]\n", "7:1: constraint.0.select is missing");
    refused(head + all, "7:1: " + name + " is missing", {"[", "]"});
    refused(head + all + key + " = [0, 0.0, 0]\n", "10:1: " + name, {"not be zero"});
    refused(head + all + key + " = [0, 1]\n", "10:1: " + name, {"has 2 entries"});
    refused(head + all + key + " = [0, inf, 0]\n", "10:1: " + name, {"finite"});
    refused(head + all + key + " = [0, 1, 0]\npoint = 0\n", "11:1: constraint.0.point",
            {"must be a list"});
  }
  refused("kind = \"rigid\"\n", "7:1: constraint.0.select is missing");
  refused("kind = \"rigid\"\n" + all + "velocity = [1, 0, 0]\nabout = [0, 0, 0]\n",
          "11:1: constraint.0.about", {"needs `angular_velocity`"});
  refused("kind = \"rigid\"\n" + all + "angular_velocity = 3\n",
          "10:1: constraint.0.angular_velocity", {"must be a list"});

  expect_refused_lines("[constraint]\n", "scene.toml:7:2: constraint", {"[[constraint]]"});
}

TEST_F(SceneReader, ConstraintsTakeTheKeysOfTheirKindOnly) {
  const auto refused = [this](const std::string& kind, const std::string& own,
                              const std::string& key, const std::string& value,
                              const std::string& takes) {
    expect_refused_lines(
        "[[constraint]]\n" + key + " = " + value + "\nkind = \"" + kind + "\"\n" + own,
        "scene.toml:8:1: constraint.0." + key, {"\"" + kind + "\"", takes});
  };
  const std::string all = "select = { all = true }\n";
  const std::string pair = "vertices = [0, 1]\n";
  refused("distance", pair, "select", "{ all = true }", "vertices or length");
  refused("distance", pair, "normal", "[1, 0, 0]", "vertices or length");
  refused("distance", pair, "velocity", "[1, 0, 0]", "vertices or length");
  refused("plane", all + "normal = [1, 0, 0]\n", "direction", "[1, 0, 0]",
          "select, point or normal");
  refused("plane", all + "normal = [1, 0, 0]\n", "length", "1", "select, point or normal");
  refused("line", all + "direction = [1, 0, 0]\n", "normal", "[1, 0, 0]",
          "select, point or direction");
  refused("line", all + "direction = [1, 0, 0]\n", "vertices", "[1, 2]",
          "select, point or direction");
  refused("rigid", all, "point", "[1, 0, 0]",
          "select, velocity, angular_velocity, about or amplitude");
  refused("rigid", all, "length", "1", "select, velocity, angular_velocity, about or amplitude");
}

TEST_F(SceneReader, MaterialRegionsAreRead) {
  EXPECT_TRUE(read(kSmall).material_region.empty());
  const Scene scene = read(std::string(kSmall) + kMechanics);
  ASSERT_EQ(scene.material_region.size(), 2U);
  const MaterialRegionSettings& first = scene.material_region[0];
  EXPECT_EQ(std::get<SelectBox>(first.select).max, Vector3(1, 1, 1));
  EXPECT_EQ(first.material.model, "stvk");
  EXPECT_EQ(first.material.mu, 3e5);
  EXPECT_FALSE(first.material.youngs_modulus);
  EXPECT_EQ(first.material.density, 500.0);
  EXPECT_EQ(first.where, path_ + ":8:1: material_region.0");
  const MaterialRegionSettings& second = scene.material_region[1];
  EXPECT_EQ(second.material.model, MaterialSettings{}.model);
  EXPECT_EQ(second.material.youngs_modulus, 2e6);
  EXPECT_EQ(second.material.density, MaterialSettings{}.density);
}

TEST_F(SceneReader, MaterialRegionsAreChecked) {
  const std::string region = "[[material_region]]\n";
  const std::string all = "select = { all = true }\n";
  const std::string moduli = "youngs_modulus = 1\npoissons_ratio = 0\n";
  expect_refused_lines(region + moduli, "scene.toml:7:1: material_region.0.select is missing");
  const std::string missing = refusal(kSmall + region + all);
  EXPECT_EQ(missing.find("scene.toml:7:1: material_region.0"), 0U) << missing;
  EXPECT_NE(missing.find("youngs_modulus"), std::string::npos) << missing;
  expect_refused_lines(region + all + moduli + "density = 0\n",
                       "scene.toml:11:1: material_region.0.density = 0", {"above 0"});
  expect_refused_lines(region + all + "youngs_modulus = -1\npoissons_ratio = 0\n",
                       "scene.toml:9:1: material_region.0.youngs_modulus = -1", {"above 0"});
  const std::string both = refusal(kSmall + region + all + moduli + "mu = 1\n");
  EXPECT_EQ(both.find("scene.toml:7:1: material_region.0"), 0U) << both;
  EXPECT_NE(both.find("mu"), std::string::npos) << both;
  expect_refused_lines("[material_region]\n", "scene.toml:7:2: material_region",
                       {"[[material_region]]"});
}

TEST_F(SceneReader, EventsAreReadInTheOrderOfTheirTimes) {
  EXPECT_TRUE(read(kSmall).event.empty());
  const Scene scene = read(std::string(kSmall) + kMechanics);
  ASSERT_EQ(scene.event.size(), 2U);
  EXPECT_EQ(scene.event[0].at, 0.25);
  EXPECT_EQ(scene.event[0].where, path_ + ":76:1: event.1");
  EXPECT_EQ(scene.event[1].at, 0.75);
  EXPECT_EQ(scene.event[1].where, path_ + ":71:1: event.0");
  // The scene itself is as it is at the start.
  EXPECT_EQ(scene.time.step, TimeSettings{}.step);
  EXPECT_EQ(scene.damping.drag, 0.25);

  const Scene ties = read(kSmall + std::string("[[event]]\nat = 1\nset = { \"time.end\" = 3 }\n"
                                               "[[event]]\nat = 1\nset = { \"time.end\" = 2 }\n"));
  ASSERT_EQ(ties.event.size(), 2U);
  EXPECT_EQ(std::get<SetTime>(ties.event[0].edits.at(0)).time.end, 3.0);
  EXPECT_EQ(std::get<SetTime>(ties.event[1].edits.at(0)).time.end, 2.0);
}

// The edits of a kind that an event makes.
template <class T>
std::vector<T> edits_of(const EventSettings& event) {
  std::vector<T> edits;
  for (const Edit& edit : event.edits) {
    if (const T* found = std::get_if<T>(&edit)) edits.push_back(*found);
  }
  return edits;
}

TEST_F(SceneReader, EventsSetWhatCanChange) {
  const Scene scene = read(std::string(kSmall) + kMechanics + R"([[event]]
at = 0.5
set = { "time.integrator" = "backward-euler", "time.step" = 0.1, "solver.tolerance" = 1e-4, "material.youngs_modulus" = 5e5, "material_region.1.poissons_ratio" = 0.2, "damping.viscosity" = 3, "environment.kind" = "gravity", "environment.direction" = [1, 0, 0], "force.0.vector" = [0, 0, 7], "fix.0.velocity" = [0.5, 0, 0], "constraint.0.length" = 0.1 }
)");
  ASSERT_EQ(scene.event.size(), 3U);
  const EventSettings& event = scene.event[1];
  EXPECT_EQ(event.at, 0.5);
  EXPECT_EQ(event.edits.size(), 9U);  // one a section
  const auto time = edits_of<SetTime>(event);
  ASSERT_EQ(time.size(), 1U);
  EXPECT_EQ(time[0].time.integrator, Integrator::kBackwardEuler);
  EXPECT_EQ(time[0].time.step, 0.1);
  EXPECT_EQ(time[0].time.end, TimeSettings{}.end);
  const auto solver = edits_of<SetSolver>(event);
  ASSERT_EQ(solver.size(), 1U);
  EXPECT_EQ(solver[0].solver.tolerance, 1e-4);
  const auto material = edits_of<SetMaterial>(event);
  ASSERT_EQ(material.size(), 2U);
  EXPECT_EQ(material[0].region, 0);
  EXPECT_EQ(material[0].material.youngs_modulus, 5e5);
  EXPECT_EQ(material[0].material.poissons_ratio, 0.4);
  EXPECT_EQ(material[1].region, 2);  // [material] is the first
  EXPECT_EQ(material[1].material.youngs_modulus, 2e6);
  EXPECT_EQ(material[1].material.poissons_ratio, 0.2);
  const auto damping = edits_of<SetDamping>(event);
  ASSERT_EQ(damping.size(), 1U);
  EXPECT_EQ(damping[0].damping.viscosity, 3.0);
  EXPECT_EQ(damping[0].damping.drag, 0.25);
  const auto environment = edits_of<SetEnvironment>(event);
  ASSERT_EQ(environment.size(), 1U);
  EXPECT_EQ(environment[0].environment.kind, EnvironmentKind::kGravity);
  EXPECT_EQ(environment[0].environment.strength, 1e4);
  EXPECT_EQ(environment[0].environment.direction, Vector3(1, 0, 0));
  const auto force = edits_of<SetForce>(event);
  ASSERT_EQ(force.size(), 1U);
  EXPECT_EQ(force[0].index, 0U);
  EXPECT_EQ(force[0].force.vector, Vector3(0, 0, 7));
  const auto fix = edits_of<SetFix>(event);
  ASSERT_EQ(fix.size(), 1U);
  EXPECT_EQ(fix[0].index, 0U);
  EXPECT_EQ(fix[0].fix.velocity, Vector3(0.5, 0, 0));
  const auto constraint = edits_of<SetConstraint>(event);
  ASSERT_EQ(constraint.size(), 1U);
  EXPECT_EQ(constraint[0].index, 0U);
  EXPECT_EQ(constraint[0].constraint.length, 0.1);
}

TEST_F(SceneReader, EventsSetTheSolver) {
  const std::string text = kSmall + std::string("[solver]\nkind = \"ceres\"\ntolerance = 1e-6\n");
  const Scene scene = read(
      text +
      "[[event]]\nat = 0.1\nset = { \"solver.kind\" = \"newton\", \"solver.linear\" = \"cg\" }\n"
      "[[event]]\nat = 0.2\nset = { \"solver.linear\" = \"factor\" }\n"
      "[[event]]\nat = 0.3\nset = { \"solver.kind\" = \"ceres\", \"solver.linear\" = \"auto\" }\n");
  ASSERT_EQ(scene.event.size(), 3U);
  const std::vector<std::pair<std::string, LinearSolver>> expected{
      {"newton", LinearSolver::kCg},
      {"newton", LinearSolver::kFactor},
      {"ceres", LinearSolver::kAuto}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto edits = edits_of<SetSolver>(scene.event[i]);
    ASSERT_EQ(edits.size(), 1U);
    EXPECT_EQ(edits[0].solver.kind, expected[i].first);
    EXPECT_EQ(edits[0].solver.linear, expected[i].second);
    EXPECT_EQ(edits[0].solver.tolerance, 1e-6);
  }
  EXPECT_EQ(scene.solver.kind, "ceres");
  expect_refusal(text + "[[event]]\nat = 0.1\nset = { \"solver.linear\" = \"cg\" }\n",
                 "scene.toml:12:9: event at 0.1 s: solver.linear", {"ceres"});
}

TEST_F(SceneReader, EventsSetNumbersToTheLastBit) {
  for (const char* number : {"0.1", "0.30000000000000004", "1e-3", "2.2250738585072014e-308",
                             "123456789.12345679", "3", "1_000", "1.7976931348623157e+308"}) {
    const Scene scene =
        read(kSmall + std::string("[[event]]\nat = 1\nset = { \"damping.drag\" = ") + number +
             " }\n[damping]\nviscosity = " + number + "\n");
    EXPECT_EQ(edits_of<SetDamping>(scene.event.at(0)).at(0).damping.drag, scene.damping.viscosity)
        << number;
  }
  const Scene scene = read(kSmall + std::string("[[event]]\nat = 1\nset = { \"environment.kind\" = "
                                                "\"gravity\", \"environment.direction\" = [3, "
                                                "0.1, 1e-3] }\n"));
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event.at(0)).at(0).environment.direction,
            Vector3(3, 0.1, 1e-3).normalized());
}

TEST_F(SceneReader, LaterEventsSeeWhatEarlierOnesSet) {
  const Scene scene = read(kSmall + std::string(R"([[event]]
at = 3
set = { "damping.viscosity" = 5 }
[[event]]
at = 1
set = { "damping.drag" = 1, "environment.kind" = "gravity", "time.step" = 1e-3 }
[[event]]
at = 2
set = { "damping.mass_damping" = 2, "environment.strength" = 3, "time.integrator" = "verlet" }
)"));
  ASSERT_EQ(scene.event.size(), 3U);
  EXPECT_EQ(edits_of<SetTime>(scene.event[1]).at(0).time.step, 1e-3);
  EXPECT_EQ(edits_of<SetTime>(scene.event[1]).at(0).time.integrator, Integrator::kVerlet);
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event[1]).at(0).environment.kind,
            EnvironmentKind::kGravity);
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event[1]).at(0).environment.strength, 3.0);
  const Damping last = edits_of<SetDamping>(scene.event[2]).at(0).damping;
  EXPECT_EQ(last.drag, 1.0);
  EXPECT_EQ(last.mass_damping, 2.0);
  EXPECT_EQ(last.viscosity, 5.0);
  // And so do the checks: what the earlier event set does not go with the later one.
  expect_refused_lines(
      "[[event]]\nat = 2\nset = { \"environment.strength\" = 3 }\n"
      "[[event]]\nat = 1\nset = { \"environment.direction\" = [1, 0, 0] }\n",
      "scene.toml:12:9: event at 1 s: environment.kind is missing");
}

TEST_F(SceneReader, EventsTakeOneTableOrAList) {
  const std::string event = kSmall + std::string("[[event]]\nat = 0.5\n");
  const std::string fix = "{ select = { all = true }, components = \"z\" }";
  EXPECT_EQ(edits_of<SetFix>(read(event + "fix = " + fix).event[0]).size(), 1U);
  const auto fixes = edits_of<SetFix>(read(event + "fix = [" + fix +
                                           ", { select = { group = \"a\" }, mode = "
                                           "\"penalty\", penalty = 3 }]\n")
                                          .event[0]);
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_FALSE(fixes[0].index);  // added
  EXPECT_EQ(fixes[0].fix.components, (std::array<bool, 3>{false, false, true}));
  EXPECT_TRUE(fixes[1].fix.is_penalty);
  EXPECT_EQ(fixes[1].fix.penalty, 3.0);

  const std::string force = "{ select = { all = true }, vector = [0, 1, 0], until = 2 }";
  const auto one = edits_of<SetForce>(read(event + "force = " + force).event[0]);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_FALSE(one[0].index);
  EXPECT_EQ(one[0].force.vector, Vector3(0, 1, 0));
  EXPECT_EQ(one[0].force.until, 2.0);
  EXPECT_EQ(
      edits_of<SetForce>(read(event + "force = [" + force + ", " + force + "]\n").event[0]).size(),
      2U);

  const std::string momentum = "{ select = { nearest = [0, 0, 0] }, value = [0, 0, 3] }";
  const auto kick = edits_of<SetMomentum>(read(event + "momentum = " + momentum).event[0]);
  ASSERT_EQ(kick.size(), 1U);
  EXPECT_EQ(kick[0].momentum.value, Vector3(0, 0, 3));
  EXPECT_EQ(edits_of<SetMomentum>(
                read(event + "momentum = [" + momentum + ", " + momentum + "]\n").event[0])
                .size(),
            2U);

  const std::string rod = "{ kind = \"distance\", vertices = [0, 1] }";
  const auto rods = edits_of<SetConstraint>(read(event + "constraint = " + rod).event[0]);
  ASSERT_EQ(rods.size(), 1U);
  EXPECT_FALSE(rods[0].index);
  EXPECT_EQ(rods[0].constraint.vertices, (std::array<std::int64_t, 2>{0, 1}));
  EXPECT_EQ(edits_of<SetConstraint>(read(event + "constraint = [" + rod +
                                         ", { kind = \"rigid\", select = { all = true } }]\n")
                                        .event[0])
                .size(),
            2U);

  // As sections of their own.
  const Scene sections = read(event +
                              "[event.set]\n\"time.step\" = 1e-3\n[event.unfix]\nall = true\n"
                              "[[event.fix]]\nselect = { all = true }\n[[event.fix]]\nselect = { "
                              "group = \"a\" }\n[event.momentum]\nselect = { all = true }\nvalue = "
                              "[0, 0, 1]\n");
  EXPECT_EQ(edits_of<SetTime>(sections.event[0]).at(0).time.step, 1e-3);
  EXPECT_EQ(edits_of<SetFix>(sections.event[0]).size(), 2U);
  EXPECT_EQ(edits_of<SetMomentum>(sections.event[0]).size(), 1U);
  EXPECT_EQ(edits_of<Unfix>(sections.event[0]).size(), 1U);
}

TEST_F(SceneReader, EventsUnfixInBothForms) {
  const std::string event = kSmall + std::string("[[event]]\nat = 0.5\nunfix = ");
  for (const std::string& text :
       {event + "{ select = { plane = { axis = \"y\", at = 2 } } }\n",
        event + "{ plane = { axis = \"y\", at = 2 } }\n",
        kSmall + std::string("[[event]]\nat = 0.5\n[event.unfix.plane]\naxis = \"y\"\nat = 2\n")}) {
    const auto unfix = edits_of<Unfix>(read(text).event[0]);
    ASSERT_EQ(unfix.size(), 1U);
    EXPECT_EQ(std::get<SelectPlane>(unfix[0].select).axis, 1);
    EXPECT_EQ(std::get<SelectPlane>(unfix[0].select).at, 2.0);
    EXPECT_NE(unfix[0].where.find("event.0.unfix"), std::string::npos) << unfix[0].where;
  }
  const std::string at = "[[event]]\nat = 0.5\nunfix = ";
  expect_refused_lines(at + "{ all = true, select = { all = true } }\n",
                       "scene.toml:9:", {"event.0.unfix"});
  expect_refused_lines(at + "{}\n", "scene.toml:9:1: event.0.unfix", {"plane, box"});
  expect_refused_lines(at + "{ select = {} }\n", "scene.toml:9:11: event.0.unfix.select is empty",
                       {"plane, box"});
  expect_refused_lines(at + "{ all = true, surface = true }\n", "scene.toml:9:1: event.0.unfix",
                       {"both", "one of"});
  expect_refused_lines(at + "{ plne = { axis = \"x\", at = 0 } }\n",
                       "scene.toml:9:11: unknown key event.0.unfix.plne", {"did you mean plane?"});
  expect_refused_lines(at + "true\n", "scene.toml:9:1: event.0.unfix", {"must be a table"});
}

TEST_F(SceneReader, EventsAreChecked) {
  const auto refused = [this](const std::string& lines, const std::string& start,
                              const std::vector<std::string>& parts = {}) {
    expect_refused_lines("[[event]]\n" + lines, "scene.toml:" + start, parts);
  };
  refused("", "7:1: event.0.at is missing", {"in s"});
  refused("set = { \"time.step\" = 1e-3 }\n", "7:1: event.0.at is missing");
  refused("at = \"later\"\n", "8:1: event.0.at", {"must be a number"});
  refused("at = nan\n", "8:1: event.0.at", {"finite"});
  refused("at = inf\n", "8:1: event.0.at", {"finite"});
  const std::vector<std::string> every{"set", "fix", "unfix", "constraint", "force", "momentum"};
  refused("at = 1\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nset = {}\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nfix = []\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nset = [1]\n", "9:1: event.0.set", {"must be a table"});
  refused("at = 1\nset = 3\n", "9:1: event.0.set", {"must be a table"});
  refused("at = 1\nfix = 3\n", "9:1: event.0.fix", {"must be a table"});
  refused("at = 1\nfix = { mode = \"exact\" }\n", "9:7: event.0.fix.select is missing");
  refused("at = 1\nfix = [{ select = { all = true } }, { }]\n", "9:37: event.0.fix.1.select");
  refused("at = 1\nfix = { select = { all = true }, mode = \"penalty\" }\n",
          "9:7: event.0.fix.penalty is missing");
  refused("at = 1\nforce = { select = { all = true } }\n", "9:9: event.0.force.vector is missing");
  refused("at = 1\nmomentum = { select = { all = true } }\n",
          "9:12: event.0.momentum.value is missing", {"kg m/s"});
  refused("at = 1\nconstraint = { vertices = [0, 1] }\n",
          "9:14: event.0.constraint.kind is missing");
  refused("at = 1\nconstraint = { kind = \"distance\", vertices = [1, 1] }\n",
          "9:35: event.0.constraint.vertices", {"different"});
  expect_refused_lines("[event]\nat = 1\n", "scene.toml:7:2: event", {"[[event]]"});
}

// An event at 0.5 s whose `set` stands in line 9, from column 9 on.
TEST_F(SceneReader, EventsSetOnlyWhatCanChange) {
  const auto refused = [this](const std::string& key, const std::string& value,
                              const std::vector<std::string>& parts) {
    expect_refused_lines("[[event]]\nat = 0.5\nset = { \"" + key + "\" = " + value + " }\n",
                         "scene.toml:9:9: event.0.set." + key, parts);
  };
  refused("material.density", "500", {"cannot change", "before the start"});
  refused("material_region.0.density", "500", {"cannot change", "before the start"});
  refused("mesh.scale", "2", {"cannot change"});
  refused("mesh.file", "\"b.vtu\"", {"cannot change"});
  refused("mesh", "3", {"cannot change"});
  refused("initial.velocity", "[0, 0, 1]", {"cannot change", "momentum"});
  refused("initial.momentum.0.value", "[0, 0, 1]", {"cannot change", "momentum"});
  refused("output.every", "2", {"cannot change"});
  refused("enviroment.kind", "\"none\"", {"did you mean environment?"});
  refused("velocity", "3", {"time, solver", "constraint"});
  refused("event.0.at", "3", {"not a key that can change"});
  for (const char* list : {"force", "fix", "constraint", "material_region"}) {
    refused(list, "3", {"number of the entry", std::string(list) + ".0."});
    refused(std::string(list) + ".vector", "[0, 0, 1]", {"number of the entry"});
    refused(std::string(list) + ".-1.vector", "[0, 0, 1]", {"number of the entry"});
    refused(std::string(list) + ".99999999999999999999.vector", "[0, 0, 1]",
            {"number of the entry"});
  }
  refused("time", "{ step = 1e-3 }", {"is a table", "in"});
  refused("fix.0", "{ select = { all = true } }", {"is a table"});
  // Without quotes it is a table too.
  expect_refused_lines("[[event]]\nat = 0.5\nset = { time.step = 1e-3 }\n",
                       "scene.toml:9:9: event.0.set.time", {"quotes", "\"time.step\""});
}

TEST_F(SceneReader, EventsAreToBlameForTheirValues) {
  const auto refused = [this](const std::string& key, const std::string& value,
                              const std::string& rest, const std::vector<std::string>& parts) {
    expect_refused_lines("[[event]]\nat = 0.5\nset = { \"" + key + "\" = " + value + " }\n",
                         "scene.toml:9:9: event at 0.5 s: " + rest, parts);
  };
  refused("time.stp", "1e-3", "unknown key time.stp", {"did you mean step?"});
  refused("time.step", "-1", "time.step = -1", {"above 0"});
  refused("time.step", "nan", "time.step", {"finite"});
  refused("time.step", "\"fast\"", "time.step = \"fast\"", {"\"auto\""});
  refused("time.step", "\"auto\"", "time.step = \"auto\"", {"explicit and verlet"});
  refused("time.end", "[1]", "time.end", {"must be a number", "not a list"});
  refused("time.integrator", "\"mid-point\"", "time.integrator = \"mid-point\"",
          {"did you mean midpoint?"});
  refused("material.youngs_modulus", "0", "material.youngs_modulus = 0", {"above 0"});
  refused("material.poissons_ratio", "0.5", "material.poissons_ratio = 0.5", {"-1 and 0.5"});
  refused("material.mu", "3e5", "material.mu", {"youngs_modulus"});
  refused("solver.tolerance", "2", "solver.tolerance = 2", {"between 0 and 1"});
  refused("damping.drag", "-1", "damping.drag = -1", {"0 or more"});
  refused("environment.kind", "\"wind\"", "environment.kind = \"wind\"", {"attraction"});
  refused("environment.strength", "3", "environment.kind is missing", {"gravity"});
  // The place is that of the event with the value, not of a later one.
  expect_refused_lines(
      "[[event]]\nat = 2\nset = { \"time.step\" = 1 }\n"
      "[[event]]\nat = 1\nset = { \"time.end\" = -1 }\n",
      "scene.toml:12:9: event at 1 s: time.end = -1");
  expect_refused_lines("[[event]]\nat = 1\n[event.set]\n\"time.end\" = -1\n",
                       "scene.toml:10:1: event at 1 s: time.end = -1");
}

// Each value is right by itself, but not beside what the scene says: the event is named.
TEST_F(SceneReader, EventsAreToBlameForWhatDoesNotFitTheScene) {
  const auto refused = [this](const std::string& lines, const std::string& set,
                              const std::vector<std::string>& parts) {
    const std::string text = kSmall + std::string("[[event]]\nat = 0.5\nset = { ") + set + " }\n";
    const std::string message = refusal(text + lines);
    EXPECT_NE(message.find("event at 0.5 s"), std::string::npos) << message;
    EXPECT_NE(message.find("scene.toml:9:9"), std::string::npos) << message;
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "no \"" << part << "\" in: " << message;
    }
  };
  refused("[time]\nintegrator = \"verlet\"\nstep = \"auto\"\n",
          "\"time.integrator\" = \"midpoint\"", {"time.step", "auto"});
  refused("[[fix]]\nselect = { all = true }\n", "\"fix.0.mode\" = \"penalty\"",
          {"fix.0.penalty", "missing"});
  refused("[[fix]]\nselect = { all = true }\noffset = [0, 0, 1]\n", "\"fix.0.target\" = [0, 0, 0]",
          {"offset"});
  refused("[[fix]]\nselect = { group = \"a\" }\n", "\"fix.0.select.all\" = true", {"group", "all"});
  refused("[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\nuntil = 1\n",
          "\"force.0.from\" = 2", {"later than from"});
  refused("[[constraint]]\nkind = \"rigid\"\nselect = { all = true }\n",
          "\"constraint.0.kind\" = \"distance\"", {"select", "distance"});
  refused("", "\"material.model\" = \"mooney-rivlin\"", {"ratio"});
}

TEST_F(SceneReader, EventsSetOnlyEntriesThatExist) {
  const std::string region =
      "[[material_region]]\nselect = { all = true }\nyoungs_modulus = 1\npoissons_ratio = 0.3\n";
  const auto refused = [this](const std::string& lines, const std::string& set,
                              const std::vector<std::string>& parts) {
    expect_refused_lines("[[event]]\nat = 0.5\nset = { " + set + " }\n" + lines,
                         "scene.toml:9:", parts);
  };
  refused(region, "\"material_region.3.youngs_modulus\" = 1",
          {"9:9: event.0.set.material_region.3.youngs_modulus", "the scene has 1 of them"});
  refused("", "\"material_region.0.youngs_modulus\" = 1",
          {"material_region.0", "the scene has 0 of them"});
  refused("[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n",
          "\"force.2.vector\" = [0, 0, 1]", {"force is a list with 1 entries"});
  refused("[[fix]]\nselect = { all = true }\n", "\"fix.7.velocity\" = [0, 0, 1]",
          {"fix is a list with 1 entries"});
  refused("", "\"constraint.1.length\" = 1", {"event at 0.5 s", "constraint"});
  refused("", "\"force.0.vector\" = [0, 0, 1]", {"event at 0.5 s", "force.0.select is missing"});
  // A material region is part of the body's structure: none can be added or moved during a run.
  refused("",
          "\"material_region.0.select.all\" = true, \"material_region.0.youngs_modulus\" = 1, "
          "\"material_region.0.poissons_ratio\" = 0.1",
          {"material_region.0"});
  refused(region, "\"material_region.0.select.all\" = true", {"material_region.0.select"});
}

// An entry that an earlier event added with `fix = …` is not the one that `set` counts.
TEST_F(SceneReader, EventsSetTheEntryThatTheyName) {
  const Scene scene = read(kSmall + std::string(R"([[force]]
select = { vertices = [0] }
vector = [1, 0, 0]
[[event]]
at = 1
force = { select = { vertices = [1] }, vector = [2, 0, 0] }
[[event]]
at = 2
set = { "force.1.select.vertices" = [2], "force.1.vector" = [3, 0, 0] }
[[event]]
at = 3
set = { "force.1.vector" = [4, 0, 0] }
)"));
  // What the run does with the edits, in order.
  std::vector<ForceSettings> forces = scene.force;
  for (const EventSettings& event : scene.event) {
    for (const SetForce& edit : edits_of<SetForce>(event)) {
      if (edit.index) {
        forces.at(*edit.index) = edit.force;
      } else {
        forces.push_back(edit.force);
      }
    }
  }
  // Either the second event changed the first's force, or it added one that the third changed.
  const auto vertex = [&](std::size_t i) {
    return std::get<SelectVertices>(forces.at(i).select).ids.at(0);
  };
  for (std::size_t i = 0; i < forces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(vertex(i), vertex(j)) << i << " " << j;
  }
  EXPECT_EQ(forces.back().vector, Vector3(4, 0, 0));
}

// Names of groups are any text, and numbers any number, also where a later event reads them again.
TEST_F(SceneReader, EventsKeepWhatEarlierOnesAdded) {
  for (const char* name : {R"("plain")", R"("with \"quotes\"")", R"("it's")", R"("a\\b")",
                           R"("two\nlines")", R"("tab\there")", R"("\u00e9\u4e2d")",
                           R"("a = 1 # no comment")", R"("'''\"\"\"")", R"("\u0001")"}) {
    const std::string select = std::string("select = { group = ") + name + " }";
    const Scene scene =
        read(kSmall + ("[[event]]\nat = 1\nfix = { " + select +
                       ", velocity = [0.1, 1e-300, 0] }\nforce = [{ " + select +
                       ", vector = [1, 2, 3], until = inf }, { " + select +
                       ", vector = [0.30000000000000004, 0, 0] }]\n"
                       "constraint = { kind = \"rigid\", " +
                       select +
                       " }\n[[event]]\nat = 2\nset = { \"fix.0.components\" = \"xy\", "
                       "\"force.1.until\" = 7, \"constraint.0.velocity\" = [0, 0, 1] }\n"));
    ASSERT_EQ(scene.event.size(), 2U) << name;
    const auto before = edits_of<SetFix>(scene.event[0]);
    const auto fix = edits_of<SetFix>(scene.event[1]);
    ASSERT_EQ(fix.size(), 1U) << name;
    EXPECT_EQ(std::get<SelectGroup>(fix[0].fix.select).name,
              std::get<SelectGroup>(before.at(0).fix.select).name);
    EXPECT_EQ(fix[0].index, 0U);
    EXPECT_EQ(fix[0].fix.velocity, Vector3(0.1, 1e-300, 0));
    EXPECT_EQ(fix[0].fix.components, (std::array<bool, 3>{true, true, false}));
    const auto force = edits_of<SetForce>(scene.event[1]);
    ASSERT_EQ(force.size(), 1U) << name;
    EXPECT_EQ(force[0].index, 1U);
    EXPECT_EQ(force[0].force.vector, Vector3(0.30000000000000004, 0, 0));
    EXPECT_EQ(force[0].force.until, 7.0);
    const auto constraint = edits_of<SetConstraint>(scene.event[1]);
    ASSERT_EQ(constraint.size(), 1U) << name;
    EXPECT_EQ(constraint[0].index, 0U);
    EXPECT_TRUE(constraint[0].constraint.is_driven());
  }
}

TEST_F(SceneReader, OverridesChangeEvents) {
  const std::string text = std::string(kSmall) + kMechanics;
  const Scene scene =
      read(text, {"event.0.at=0.125", "event.0.set={\"time.step\"=1e-4}",
                  "event.1.fix={select={all=true}}", "event.2={at=2, unfix={all=true}}"});
  ASSERT_EQ(scene.event.size(), 3U);
  EXPECT_EQ(scene.event[0].at, 0.125);
  EXPECT_EQ(edits_of<SetTime>(scene.event[0]).at(0).time.step, 1e-4);
  EXPECT_TRUE(edits_of<SetDamping>(scene.event[0]).empty());
  EXPECT_EQ(edits_of<SetFix>(scene.event[1]).size(), 1U);
  EXPECT_EQ(scene.event[2].at, 2.0);
  // Events change the scene with the overrides in it.
  EXPECT_EQ(edits_of<SetTime>(read(text, {"time.end=7"}).event[1]).at(0).time.end, 7.0);

  expect_refusal(text, "--set event.0.at=soon: event.0.at", {"must be a number"},
                 {"event.0.at=soon"});
  expect_refusal(text, "--set event.5.at=1: event is a list with 2 entries", {}, {"event.5.at=1"});
  expect_refusal(text, "--set event.0.set={\"time.step\"=-1}: event at 0.75 s: time.step = -1",
                 {"above 0"}, {"event.0.set={\"time.step\"=-1}"});
  expect_refusal(text, "--set damping.drag=-1: damping.drag = -1", {"0 or more"},
                 {"damping.drag=-1"});
  expect_refusal(text, "--set constraint.0.length=0: constraint.0.length = 0", {"above 0"},
                 {"constraint.0.length=0"});
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

TEST_F(SceneReader, TheEchoHasConstraintsRegionsAndEvents) {
  using Json = nlohmann::ordered_json;
  const Json echo = Json::parse(read(std::string(kSmall) + kMechanics).echo);
  EXPECT_EQ(echo["damping"]["drag"], 0.25);
  EXPECT_EQ(echo["damping"]["mass_damping"], 2.0);
  EXPECT_EQ(echo["damping"]["viscosity"], 40.5);
  EXPECT_EQ(echo["environment"]["kind"], "attraction");
  EXPECT_EQ(echo["environment"]["softening"], 0.125);
  ASSERT_EQ(echo["material_region"].size(), 2U);
  EXPECT_EQ(echo["material_region"][0]["model"], "stvk");
  EXPECT_EQ(echo["material_region"][0]["density"], 500.0);
  EXPECT_EQ(echo["material_region"][1]["select"]["group"], "core");
  EXPECT_EQ(echo["fix"][0]["velocity"], Json({0.0, 0.5, 0.0}));
  EXPECT_EQ(echo["fix"][0]["mode"], "exact");
  EXPECT_EQ(echo["fix"][1]["mode"], "penalty");
  EXPECT_EQ(echo["fix"][1]["penalty"], 1e5);
  ASSERT_EQ(echo["constraint"].size(), 5U);
  EXPECT_EQ(echo["constraint"][0]["kind"], "distance");
  EXPECT_EQ(echo["constraint"][0]["vertices"], Json({3, 40}));
  EXPECT_EQ(echo["constraint"][0]["length"], 1.5);
  EXPECT_EQ(echo["constraint"][1]["point"], Json({0.0, 0.0, 1.0}));
  EXPECT_EQ(echo["constraint"][2]["kind"], "line");
  EXPECT_FALSE(echo["constraint"][3].contains("velocity"));
  EXPECT_EQ(echo["constraint"][4]["angular_velocity"], Json({0.0, 0.0, 2.0}));
  ASSERT_EQ(echo["event"].size(), 2U);
  EXPECT_EQ(echo["event"][0]["at"], 0.25);
  EXPECT_EQ(echo["event"][0]["unfix"]["select"]["vertices"], Json({0, 1}));
  EXPECT_EQ(echo["event"][0]["fix"][1]["components"], "z");
  EXPECT_EQ(echo["event"][1]["set"]["time.step"], 5e-3);
  EXPECT_EQ(echo["event"][1]["momentum"]["value"], Json({0, 0, 1}));
  const Json none = Json::parse(read(kSmall).echo);
  for (const char* key : {"drag", "mass_damping", "viscosity"})
    EXPECT_EQ(none["damping"][key], 0.0);
}

TEST_F(SceneReader, TheEchoOfAnEventSurvivesWhatJsonDoesNotHave) {
  const Scene scene =
      read(kSmall + std::string("[[event]]\nat = 1\nforce = { select = { all = true "
                                "}, vector = [0, 0, 1], until = inf }\n"));
  const auto echo = nlohmann::json::parse(scene.echo);
  EXPECT_EQ(echo["event"][0]["force"]["vector"], nlohmann::json({0, 0, 1}));
}

TEST_F(SceneReader, TheEchoReadsBackAsTheSameScene) {
  for (const std::string& text :
       {std::string(kWhole), std::string(kSmall),
        kSmall + std::string(kMechanics).substr(0, std::string(kMechanics).find("[[event]]")),
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
  const auto refused = [this](const std::string& whole, std::size_t stride) {
    int count = 0;
    for (std::size_t i = 0; i < whole.size(); i += stride) {
      for (const char byte : {'\0', '"', '[', '=', '9', '\xff'}) {
        std::string damaged = whole;
        damaged[i] = byte;
        count += refusal(damaged) == "accepted" ? 0 : 1;
      }
      count += refusal(whole.substr(0, i)) == "accepted" ? 0 : 1;
    }
    return count;
  };
  EXPECT_GT(refused(kWhole, 1), 1000);
  EXPECT_GT(refused(std::string(kSmall) + kMechanics, 5), 1000);
}

TEST_F(SceneReader, EventsTakeKeysOutAndMoveSingleVertices) {
  const Scene scene = read(kSmall + std::string(R"([[fix]]
select = { vertices = [0, 1] }
targets = [[0, 0, 0], [1, 0, 0]]
[[constraint]]
kind = "distance"
vertices = [1, 2]
length = 1.0
[[event]]
at = 1
unset = ["fix.0.targets", "constraint.0.length", "fix.0.select"]
set = { "fix.0.select.vertices" = [2] }
unfix = { all = true, fix = 0 }
remove_constraint = 0
shift = { vertices = [1, 2], displacement = [[0, 0, 1], [0, 1, 0]] }
[[event]]
at = 2
shift = [{ vertices = [0], impulse = [[1, 2, 3]] }, { vertices = [1], impulse = [[1, 2, 3]] }]
)"));
  ASSERT_EQ(scene.fix.at(0).targets.size(), 2U);
  EXPECT_EQ(scene.fix[0].targets[1], Vector3::UnitX());
  const EventSettings& event = scene.event.at(0);
  ASSERT_EQ(event.edits.size(), 5U);
  const SetConstraint rod = edits_of<SetConstraint>(event).at(0);
  EXPECT_FALSE(rod.constraint.length.has_value());
  const SetFix fix = edits_of<SetFix>(event).at(0);
  EXPECT_EQ(fix.index, 0U);
  EXPECT_TRUE(fix.fix.targets.empty());
  EXPECT_EQ(fix.fix.select, Selection(SelectVertices{{2}}));
  EXPECT_EQ(edits_of<Unfix>(event).at(0).fix, 0U);
  EXPECT_EQ(edits_of<RemoveConstraint>(event).at(0).index, 0U);
  const ShiftSettings shift = edits_of<ShiftState>(event).at(0).shift;
  EXPECT_EQ(shift.vertices, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(shift.displacement.at(1), Vector3::UnitY());
  EXPECT_TRUE(shift.impulse.empty());
  EXPECT_EQ(edits_of<ShiftState>(scene.event.at(1)).size(), 2U);

  const std::string event_head = kSmall + std::string("[[event]]\nat = 1\n");
  const auto refused = [&](const std::string& line, const std::string& message) {
    expect_refusal(event_head + line + "\n", "scene.toml:9:", {message});
  };
  refused("unset = [\"material.ratio\"]", "material.ratio is not set at that time");
  refused("unset = [\"material.youngs_modulus\"]", "poissons_ratio");
  refused("unset = [\"material.density\"]", "cannot change during a run");
  refused("unset = [\"mesh.scale\"]", "cannot change during a run");
  refused("unset = []", "at least one");
  refused("unset = [3]", "a list of texts");
  refused("unfix = { all = true, fix = 0 }", "at that time there is no [[fix]]");
  refused("remove_constraint = 0", "at that time there is no [[constraint]]");
  refused("shift = { displacement = [[0, 0, 1]] }", "vertices is missing");
  refused("shift = { vertices = [1] }", "does nothing");
  refused("shift = { vertices = [1, 2], impulse = [[0, 0, 1]] }", "1 entries for 2 vertices");
  refused("shift = { vertices = [1], impulse = [[0, 0]] }", "2 entries");
  refused("fix = { select = { all = true }, targets = [[0, 0, 1]] }",
          "needs select = { vertices = [...] }");
  refused("fix = { select = { vertices = [1] }, targets = [[0, 0, 1]], offset = [0, 0, 1] }",
          "Leave all but one of them out");
}

TEST_F(SceneReader, WholeNumbersThatDoublePrecisionDoesNotHoldAreRounded) {
  const std::string select = "select = { vertices = [9007199254740993] }";
  const std::string all = "[[force]]\n" + select +
                          "\nvector = [100000000000000001, -9007199254740993, 9007199254740993]\n"
                          "[[fix]]\n" +
                          select + "\ntarget = [9223372036854775807, -9223372036854775808, 3]\n";
  const Scene scene = read(kSmall + all +
                               "[[event]]\nat = 9007199254740993\nset = { \"force.0.vector\" = "
                               "[100000000000000001, 0, 0] }\n",
                           {"material.density=100000000000000001", "mesh.scale=9007199254740995"});
  EXPECT_EQ(scene.force[0].vector, Vector3(1e17, -9007199254740992.0, 9007199254740992.0));
  EXPECT_EQ(scene.fix[0].target, Vector3(0x1p63, -0x1p63, 3.0));
  EXPECT_EQ(scene.material.density, 1e17);
  EXPECT_EQ(scene.mesh.scale, 9007199254740996.0);
  EXPECT_EQ(scene.event[0].at, 9007199254740992.0);
  EXPECT_EQ(std::get<SetForce>(scene.event[0].edits[0]).force.vector, Vector3(1e17, 0, 0));
  // Ids are whole numbers and stay exact.
  EXPECT_EQ(std::get<SelectVertices>(scene.force[0].select).ids[0], 9007199254740993);
  expect_refusal(kSmall, "--set material.youngs_modulus=-9007199254740993: material.youngs_modulus",
                 {"above 0"}, {"material.youngs_modulus=-9007199254740993"});
  expect_refusal(kSmall, "--set time.step=-9007199254740993: time.step", {"above 0"},
                 {"time.step=-9007199254740993"});
}

TEST_F(SceneReader, WhatIsNestedTooDeeplyIsRefused) {
  std::string key;
  for (int i = 0; i < 35'000; ++i) key += "a.";
  key += "a";
  const std::string said = "deep at most";
  const std::string value = "x = { " + key + " = 1 }";
  expect_refused_lines(key + " = 1\n", "scene.toml:7:", {said});
  expect_refused_lines("[" + key + "]\n", "scene.toml:7:", {said});
  expect_refused_lines("[[" + key + "]]\n", "scene.toml:7:", {said});
  expect_refused_lines(value + "\n", "scene.toml:7:", {said});
  expect_refused_lines("x = " + std::string(100'000, '[') + "\n", "scene.toml:7:", {said});
  expect_refused_lines("[[event]]\nat = 0\nset = { " + key + " = 1 }\n", "scene.toml:9:", {said});
  expect_refused_lines("[[event]]\nat = 0\nset = { \"damping." + key + "\" = 1 }\n",
                       "scene.toml:9:", {said});
  expect_refused_lines("[[event]]\nat = 0\nunset = [\"damping." + key + "\"]\n",
                       "scene.toml:9:", {said});
  for (const std::string& override : {key + "=1", "damping." + key + "=1", value}) {
    const std::string message = refusal(kSmall, {override});
    EXPECT_NE(message.find(said), std::string::npos);
    EXPECT_LT(message.size(), 1000U) << "the key is not repeated whole";
  }
}

TEST_F(SceneReader, MaterialsOfSizesThatOverflowAreRefused) {
  for (const char* key :
       {"material.youngs_modulus", "material.density", "mesh.scale", "environment.strength"}) {
    for (const char* value : {"1e300", "1e-300", "1e308", "1e31", "1e-31"}) {
      const std::string override = std::string(key) + "=" + value;
      expect_refusal(kSmall, "--set " + override + ": " + key, {"between 1e-30 and 1e30"},
                     {"environment.kind=gravity", override});
    }
    read(kSmall, {"environment.kind=gravity", std::string(key) + "=1e30"});
    read(kSmall, {"environment.kind=gravity", std::string(key) + "=1e-30"});
  }
  expect_refused_lines("[[fix]]\nselect = { all = true }\nmode = \"penalty\"\npenalty = 1e308\n",
                       "scene.toml:10:1: fix.0.penalty", {"between 1e-30 and 1e30"});
  expect_refused_lines("[[event]]\nat = 0\nset = { \"material.youngs_modulus\" = 1e300 }\n",
                       "scene.toml:9:", {"material.youngs_modulus", "between 1e-30 and 1e30"});
  const std::string lame = "[mesh]\nfile = \"a.vtu\"\n[material]\n";
  expect_refusal(lame + "mu = 1e5\nlambda = -1e300\n", "scene.toml:5:1: material.lambda", {"1e30"});
  expect_refusal(lame + "mu = 1e300\nlambda = 0\n", "scene.toml:4:1: material.mu", {"1e30"});
  read(lame + "mu = 1e5\nlambda = 0\n");
}

}  // namespace
}  // namespace tetraction
