#include "tetraction/io/scene_reader.h"

#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "core/quoting.h"
#include "support/messages.h"
#include "support/scene_reading.h"

namespace tetraction {
namespace {

using namespace testing_support;

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
  EXPECT_EQ(number_of(scene.material, "ratio"), 0.25);
  EXPECT_FALSE(number_of(scene.material, "mu"));
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
  EXPECT_EQ(
      number_of(read(mesh + "material = { model = \"stvk\", mu = 1, lambda = 2 }").material, "mu"),
      1.0);
  EXPECT_EQ(number_of(read(mesh +
                           "material = { model = \"mooney-rivlin\", mu1 = 1, mu2 = 0, lambda = 2 }")
                          .material,
                      "mu2"),
            0.0);
  for (const Integrator integrator : {Integrator::kExplicit, Integrator::kVerlet,
                                      Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    EXPECT_EQ(read(kSmall, {"time.integrator=" + to_string(integrator)}).time.integrator,
              integrator);
  }
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
  refuses("[material_regoin]\n", "7:2: unknown key material_regoin",
          {"did you mean material_region?"});
  refuses("[damping]\nviscousity = 1\n", "8:1: unknown key damping.viscousity",
          {"did you mean viscosity?"});
  refuses("[environment]\nkind = \"attraction\"\nsoftning = 1\n",
          "9:1: unknown key environment.softning", {"did you mean softening?"});
  refuses("[[fix]]\nselect = { all = true }\npenality = 1\n", "9:1: unknown key fix.0.penality",
          {"did you mean penalty?"});
  refuses("[[constraint]]\nkind = \"distance\"\nlenght = 1\n",
          "9:1: unknown key constraint.0.lenght", {"did you mean length?"});
  refuses("[[material_region]]\nselect = { all = true }\nyoungs_modlus = 1\n",
          "9:1: unknown key material_region.0.youngs_modlus", {"did you mean youngs_modulus?"});
  refuses("[[event]]\nat = 1\nunfx = { all = true }\n", "9:1: unknown key event.0.unfx",
          {"did you mean unfix?"});
  refuses("[[event]]\nat = 1\nmomentum = { select = { all = true }, valu = [0, 0, 1] }\n",
          "9:39: unknown key event.0.momentum.valu", {"did you mean value?"});
  refuses("[mehs]\n", "7:2: unknown key mehs", {"did you mean mesh?"});
  refuses("[enviroment]\n", "7:2: unknown key enviroment", {"did you mean environment?"});
  refuses("[time]\nStep = 1\n", "8:1: unknown key time.Step", {"did you mean step?"});
  refuses("[output]\ndir = \"x\"\n", "8:1: unknown key output.dir", {"did you mean directory?"});
  refuses("[[fix]]\nselect = { plne = 1 }\n", "8:12: unknown key fix.0.select.plne",
          {"did you mean plane?"});
  refuses("[initial]\nmomentum = [{ select = { all = true }, vlaue = [0, 0, 0] }]\n",
          "8:40: unknown key initial.momentum.0.vlaue", {"did you mean value?"});
}

TEST_F(SceneReader, UnknownKeysWithNothingNearListTheValidOnes) {
  refuses("[time]\nresolution = 1\n", "8:1: unknown key time.resolution",
          {"valid are integrator, step, end, retry"});
  refuses("[" + std::string(5000, 'q') + "]\n", "7:2: unknown key qqq",
          {"valid are mesh, material"});
}

TEST_F(SceneReader, SolversAndTheirLinearSolvers) {
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    const Scene scene =
        read(kSmall + "[solver]\nkind = \"newton\"\nlinear = \"" + to_string(linear) + "\"\n");
    EXPECT_EQ(scene.solver.kind, "newton");
    EXPECT_EQ(scene.solver.linear, linear);
    EXPECT_NE(scene.echo.find("\"linear\": \"" + to_string(linear) + "\""), std::string::npos);
  }
  const Scene ceres = read(kSmall + "[solver]\nkind = \"ceres\"\nlinear = \"auto\"\n");
  EXPECT_EQ(ceres.solver.kind, "ceres");
  EXPECT_EQ(ceres.solver.linear, LinearSolver::kAuto);

  refuses("[solver]\nkind = \"newtn\"\n", "8:1: solver.kind", {"did you mean newton?"});
  refuses("[solver]\nkind = \"newton\"\nlinear = \"matrixfree\"\n", "9:1: solver.linear",
          {"did you mean matrix-free?"});
  for (const char* linear : {"matrix-free", "cg", "factor"}) {
    refuses(std::string("[solver]\nlinear = \"") + linear + "\"\nkind = \"ceres\"\n",
            "8:1: solver.linear", {linear, "solver.kind = \"newton\"", "leave linear out"});
  }
}

TEST_F(SceneReader, UnknownWordsAreRefusedWithTheNearest) {
  refuses("[time]\nintegrator = \"mid-point\"\n", "8:1: time.integrator = \"mid-point\"",
          {"did you mean midpoint?"});
  refuses("[time]\nintegrator = \"rk4\"\n", "8:1: time.integrator",
          {"explicit, verlet, midpoint, backward-euler or energy-momentum"});
  expect_refusal(kSmall, "--set material.model=neohookean: material.model",
                 {"did you mean neo-hookean?"}, {"material.model=neohookean"});
  refuses("[environment]\nkind = \"wind\"\n", "8:1: environment.kind",
          {"none, gravity or attraction"});
  // Values that only programs can set have no word in a file.
  refuses("[environment]\nkind = \"custom\"\n", "8:1: environment.kind",
          {"none, gravity or attraction"});
  expect_refusal(kSmall, "--set material.model=custom: material.model",
                 {"stvk, neo-hookean, mooney-rivlin, yeoh, ogden or gent"},
                 {"material.model=custom"});
  expect_refusal("[mesh]\ngenerate = { kind = \"ball\" }\n",
                 "scene.toml:2:14: mesh.generate.kind = \"ball\"", {"beam, box, cube"});
}

TEST_F(SceneReader, UnknownKindsAndModesAreRefusedWithTheNearest) {
  refuses("[environment]\nkind = \"atraction\"\n", "8:1: environment.kind",
          {"did you mean attraction?"});
  refuses("[[fix]]\nselect = { all = true }\nmode = \"penalties\"\n",
          "9:1: fix.0.mode = \"penalties\"", {"did you mean penalty?"});
  refuses("[[fix]]\nselect = { all = true }\nmode = \"soft\"\n", "9:1: fix.0.mode = \"soft\"",
          {"exact or penalty"});
  refuses("[[constraint]]\nkind = \"distanse\"\n", "8:1: constraint.0.kind = \"distanse\"",
          {"did you mean distance?"});
  refuses("[[constraint]]\nkind = \"weld\"\n", "8:1: constraint.0.kind = \"weld\"",
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
  refuses("[[fix]]\n", "7:1: fix.0.select is missing", {"all = true"});
  refuses("[[force]]\nselect = { all = true }\n", "7:1: force.0.vector is missing");
  refuses("[[force]]\nvector = [0, 0, 1]\n", "7:1: force.0.select is missing");
  refuses("[[initial.momentum]]\nselect = { all = true }\n",
          "7:1: initial.momentum.0.value is missing");
  refuses("[environment]\nstrength = 9.81\n", "7:1: environment.kind is missing", {"gravity"});
  refuses("[[fix]]\nselect = { plane = { axis = \"x\" } }\n",
          "8:20: fix.0.select.plane.at is missing");
  refuses("[[fix]]\nselect = { plane = { at = 0 } }\n", "8:20: fix.0.select.plane.axis is missing");
  refuses("[[fix]]\nselect = { box = { min = [0, 0, 0] } }\n",
          "8:18: fix.0.select.box.max is missing");
  refuses("[[fix]]\nselect = { sphere = { center = [0, 0, 0] } }\n",
          "8:21: fix.0.select.sphere.radius is missing");
  expect_refusal("[mesh]\ngenerate = {}\n", "scene.toml:2:12: mesh.generate.kind is missing",
                 {"tetrahedron"});
  expect_refusal("[mesh]\ngenerate = { kind = \"box\", size = [1, 1, 1] }\n",
                 "scene.toml:2:12: mesh.generate.cells is missing");
  expect_refusal("[mesh]\ngenerate = { kind = \"cube\" }\n",
                 "scene.toml:2:12: mesh.generate.cells is missing");
}

TEST_F(SceneReader, WrongTypesAreNamed) {
  refuses("[time]\nend = \"long\"\n", "8:1: time.end must be a number", {"not a string"});
  refuses("[time]\nend = true\n", "8:1: time.end", {"not true or false"});
  refuses("[time]\nend = 1979-05-27\n", "8:1: time.end", {"date"});
  refuses("[time]\nstep = \"fast\"\n", "8:1: time.step = \"fast\"", {"\"auto\""});
  refuses("[time]\nstep = [1]\n", "8:1: time.step", {"not a list"});
  refuses("[output]\nevery = 2.0\n", "8:1: output.every must be a whole number", {"decimal point"});
  refuses("[output]\ndirectory = 3\n", "8:1: output.directory",
          {"text in quotes", "not a whole number"});
  refuses("[initial]\nvelocity = 3\n", "8:1: initial.velocity",
          {"[1.0, 0.0, 0.0]", "not a whole number"});
  refuses("[initial]\nvelocity = [1, 2]\n", "8:1: initial.velocity",
          {"has 2 entries", "must have 3"});
  refuses("[initial]\nvelocity = [1, 2, \"3\"]\n", "8:1: initial.velocity",
          {"list of numbers", "not a string"});
  refuses("[[fix]]\nselect = { vertices = [1, 2.5] }\n", "8:12: fix.0.select.vertices",
          {"whole numbers"});
  refuses("[[fix]]\nselect = \"all\"\n", "8:1: fix.0.select",
          {"no named selections", "give a selection"});
  refuses("[[fix]]\nselect = 3\n", "8:1: fix.0.select", {"must be a selection", "not a"});
  refuses("[[fix]]\nselect = { all = 1 }\n", "8:12: fix.0.select.all", {"true or false"});
  refuses("[fix]\n", "7:2: fix", {"[[fix]]", "brackets twice"});
  refuses("[[time]]\n", "7:3: time", {"[time]", "list of tables"});
  expect_refusal("fix = [1]\n" + kSmall, "scene.toml:1:1: fix", {"[[fix]]"});
  expect_refusal("time = 3\n" + kSmall, "scene.toml:1:1: time", {"table"});
}

TEST_F(SceneReader, NumbersThatAreNotFiniteAreRefused) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    for (const char* key :
         {"time.end", "time.step", "mesh.scale", "material.density", "material.youngs_modulus",
          "material.poissons_ratio", "solver.tolerance"}) {
      const std::string text = std::string(key) + "=" + value;
      expect_refusal(kSmall, "--set " + text + ": " + key, {"finite"}, {text});
    }
    refuses(std::string("[initial]\nvelocity = [0, ") + value + ", 0]\n", "8:1: initial.velocity",
            {"finite"});
  }
  const std::string force = "[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n";
  refuses(force + "until = nan\n", "10:1: force.0.until", {"finite"});
  refuses(force + "from = inf\n", "10:1: force.0.from", {"finite"});
  refuses(force + "until = -inf\n", "10:1: force.0.until", {"later"});
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
    expect_part(error.what(), "none.toml: cannot read the scene: No such file");
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

// A component of three numbers with defaults can be set alone.
TEST_F(SceneReader, OverridesSetComponents) {
  const std::string text =
      kSmall + "[[force]]\nselect = { all = true }\n[environment]\nkind = \"gravity\"\n";
  const Scene scene = read(text + "[[event]]\nat = 1\nset = { \"force.0.vector.0\" = 2 }\n",
                           {"force.0.vector.1=5", "initial.velocity.2=-1",
                            "environment.direction.0=1", "environment.direction.2=0"});
  EXPECT_EQ(scene.force.at(0).vector, Vector3(0.0, 5.0, 0.0));
  EXPECT_EQ(scene.initial.velocity, Vector3(0.0, 0.0, -1.0));
  // The default, (0, −1, 0), keeps its other component.
  EXPECT_NEAR((scene.environment.direction - Vector3(1.0, -1.0, 0.0).normalized()).norm(), 0.0,
              1e-15);
  EXPECT_EQ(std::get<SetForce>(scene.event.at(0).edits.at(0)).entry.vector, Vector3(2.0, 5.0, 0.0));
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

TEST_F(SceneReader, TheEchoHasConstraintsRegionsAndEvents) {
  using Json = nlohmann::ordered_json;
  const Json echo = Json::parse(read(kSmall + kMechanics).echo);
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
  const Scene scene = read(kSmall +
                           "[[event]]\nat = 1\nforce = { select = { all = true "
                           "}, vector = [0, 0, 1], until = inf }\n");
  const auto echo = nlohmann::json::parse(scene.echo);
  EXPECT_EQ(echo["event"][0]["force"]["vector"], nlohmann::json({0, 0, 1}));
}

TEST_F(SceneReader, TheEchoReadsBackAsTheSameScene) {
  for (const std::string& text :
       {kWhole, kSmall, kSmall + kMechanics.substr(0, kMechanics.find("[[event]]")),
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
  EXPECT_GT(refused(kSmall + kMechanics, 5), 1000);
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
  EXPECT_EQ(std::get<SetForce>(scene.event[0].edits[0]).entry.vector, Vector3(1e17, 0, 0));
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
  refuses(key + " = 1\n", "7:", {said});
  refuses("[" + key + "]\n", "7:", {said});
  refuses("[[" + key + "]]\n", "7:", {said});
  refuses(value + "\n", "7:", {said});
  refuses("x = " + std::string(100'000, '[') + "\n", "7:", {said});
  refuses("[[event]]\nat = 0\nset = { " + key + " = 1 }\n", "9:", {said});
  refuses("[[event]]\nat = 0\nset = { \"damping." + key + "\" = 1 }\n", "9:", {said});
  refuses("[[event]]\nat = 0\nunset = [\"damping." + key + "\"]\n", "9:", {said});
  for (const std::string& override : {key + "=1", "damping." + key + "=1", value}) {
    const std::string message = refusal(kSmall, {override});
    EXPECT_NE(message.find(said), std::string::npos);
    EXPECT_LT(message.size(), 1000U) << "the key is not repeated whole";
  }
}

}  // namespace
}  // namespace tetraction
