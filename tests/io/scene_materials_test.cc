
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "support/scene_reading.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST_F(SceneReader, MaterialParametersMustFitTogether) {
  expect_refusal(kSmall + "mu = 3e5\n", "scene.toml:4:1: material.mu",
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
  const Scene scene = read(kSmall + "model = \"yeoh\"\nc20 = -2e3\nc30 = 0\n");
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
  expect_refusal(kSmall + "model = \"yeoh\"\nc20 = 0\n", "scene.toml:4:1: material.c30 is missing",
                 both);
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
  const Scene mooney =
      read(kSmall + "model = \"mooney-rivlin\"\nratio = 0.2\nvolumetric = \"quadratic\"\n");
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
  expect_refusal(kSmall + "volumetric = \"quadratc\"\n",
                 "scene.toml:7:1: material.volumetric = \"quadratc\"", {"did you mean quadratic?"});
  expect_refusal(kSmall + "volumetric = \"cubic\"\n",
                 "scene.toml:7:1: material.volumetric = \"cubic\"", {"log or quadratic"});
  expect_refusal(kSmall + "volumetric = 2\n", "scene.toml:7:1: material.volumetric",
                 {"text in quotes"});
  for (const std::string model : {"model = \"stvk\"\n", "model = \"yeoh\"\nc20 = 0\nc30 = 0\n"}) {
    expect_refusal(kSmall + model + "volumetric = \"log\"\n",
                   "scene.toml:4:1: material.volumetric has no meaning", {"leave it out"});
  }
}

// Both laws come back from a file that the writer wrote, also when an event chooses them.
TEST_F(SceneReader, MaterialsSurviveWritingAndReading) {
  const std::string quadratic = kSmall + "volumetric = \"quadratic\"\n";
  const std::string own =
      with_material("model = \"yeoh\"\nc10 = 1e5\nc20 = -3e3\nc30 = 50\nkappa = 1e6\n");
  const std::string young = kSmall + "model = \"yeoh\"\nc20 = -3e3\nc30 = 50\n";
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

TEST_F(SceneReader, MaterialRegionsAreRead) {
  EXPECT_TRUE(read(kSmall).material_region.empty());
  const Scene scene = read(kSmall + kMechanics);
  ASSERT_EQ(scene.material_region.size(), 2U);
  const MaterialRegionSettings& first = scene.material_region[0];
  EXPECT_EQ(std::get<SelectBox>(first.select).max, Vector3(1, 1, 1));
  EXPECT_EQ(first.material.model, "stvk");
  EXPECT_EQ(number_of(first.material, "mu"), 3e5);
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
  refuses(region + moduli, "7:1: material_region.0.select is missing");
  const std::string missing = refusal(kSmall + region + all);
  EXPECT_EQ(missing.find("scene.toml:7:1: material_region.0"), 0U) << missing;
  EXPECT_NE(missing.find("youngs_modulus"), std::string::npos) << missing;
  refuses(region + all + moduli + "density = 0\n", "11:1: material_region.0.density = 0",
          {"above 0"});
  refuses(region + all + "youngs_modulus = -1\npoissons_ratio = 0\n",
          "9:1: material_region.0.youngs_modulus = -1", {"above 0"});
  const std::string both = refusal(kSmall + region + all + moduli + "mu = 1\n");
  EXPECT_EQ(both.find("scene.toml:7:1: material_region.0"), 0U) << both;
  EXPECT_NE(both.find("mu"), std::string::npos) << both;
  refuses("[material_region]\n", "7:2: material_region", {"[[material_region]]"});
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
  refuses("[[fix]]\nselect = { all = true }\nmode = \"penalty\"\npenalty = 1e308\n",
          "10:1: fix.0.penalty", {"between 1e-30 and 1e30"});
  refuses("[[event]]\nat = 0\nset = { \"material.youngs_modulus\" = 1e300 }\n",
          "9:", {"material.youngs_modulus", "between 1e-30 and 1e30"});
  const std::string lame = "[mesh]\nfile = \"a.vtu\"\n[material]\n";
  expect_refusal(lame + "mu = 1e5\nlambda = -1e300\n", "scene.toml:5:1: material.lambda", {"1e30"});
  expect_refusal(lame + "mu = 1e300\nlambda = 0\n", "scene.toml:4:1: material.mu", {"1e30"});
  read(lame + "mu = 1e5\nlambda = 0\n");
}

}  // namespace
}  // namespace tetraction
