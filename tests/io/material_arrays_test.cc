// Material parameters that a scene takes from cell arrays of the mesh file.

#include <cmath>
#include <filesystem>

#include "support/folder_test.h"
#include "support/messages.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/scene_echo.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

using namespace testing_support;

class MaterialArrays : public FolderTest {
 protected:
  void SetUp() override {
    mesh_ = generate_box({1, 1, 1}, {2, 1, 1});
    Matrix modulus(1, mesh_.tetrahedron_count());
    Matrix density(1, mesh_.tetrahedron_count());
    for (Index e = 0; e < modulus.cols(); ++e) {
      modulus(0, e) = 1e5 * (1.0 + static_cast<double>(e));
      density(0, e) = 1000.0 + static_cast<double>(e);
    }
    mesh_.cell_arrays["E"] = modulus;
    mesh_.cell_arrays["rho"] = density;
    mesh_.cell_arrays["direction"] = Matrix::Ones(3, mesh_.tetrahedron_count());
  }

  Scene scene(const std::string& material, const std::string& rest = "") {
    write_mesh(mesh_, path("mesh.vtu"));
    write_text_file(path("scene.toml"), "[mesh]\nfile = \"mesh.vtu\"\n[material]\n" + material +
                                            "\n[time]\nstep = 1e-3\nend = 0.01\n" + rest);
    return read_scene(path("scene.toml"));
  }
  std::unique_ptr<MechanicalSystem> system(const Scene& scene) {
    return make_system(scene, read_scene_mesh(scene));
  }
  std::string refusal(const std::string& material) {
    try {
      system(scene(material));
    } catch (const InputError& error) {
      std::string message = error.what();
      const auto at = message.find("scene.toml");
      return at == std::string::npos ? message : message.substr(at);
    }
    return "accepted";
  }

  TetMesh mesh_;
};

TEST_F(MaterialArrays, GiveModuliAndDensities) {
  const Scene read = scene(
      "youngs_modulus = { array = \"E\" }\npoissons_ratio = 0.25\ndensity = { array = \"rho\" }");
  const auto body = system(read);
  for (Index e = 0; e < mesh_.tetrahedron_count(); ++e) {
    EXPECT_NEAR(body->elastic().lame(e).mu, 0.4e5 * (1.0 + static_cast<double>(e)), 1e-9);
    EXPECT_EQ(body->density(e), 1000.0 + static_cast<double>(e));
  }
  // The program's own writer and echo keep the names.
  const std::string text = scene_text(read, folder_.string());
  EXPECT_NE(text.find("youngs_modulus = { array = \"E\" }"), std::string::npos) << text;
  EXPECT_NE(text.find("density = { array = \"rho\" }"), std::string::npos) << text;
  write_text_file(path("again.toml"), text);
  EXPECT_EQ(read_scene(path("again.toml")).material.arrays, read.material.arrays);
  EXPECT_NE(scene_echo(read).find("\"array\": \"E\""), std::string::npos);
}

TEST_F(MaterialArrays, GiveParametersOfEachModel) {
  for (const char* material :
       {"model = \"stvk\"\nmu = { array = \"E\" }\nlambda = 1e5",
        "model = \"mooney-rivlin\"\nmu1 = { array = \"E\" }\nmu2 = 1e4\nlambda = { array = \"E\" }",
        "model = \"mooney-rivlin\"\nyoungs_modulus = { array = \"E\" }\npoissons_ratio = 0.3\n"
        "ratio = 0.2\nvolumetric = \"quadratic\"",
        "model = \"yeoh\"\nc10 = { array = \"E\" }\nc20 = -1\nc30 = 1\nkappa = 1e6"}) {
    const auto body = system(scene(material));
    EXPECT_LT(body->elastic().lame(0).mu, 0.6 * body->elastic().lame(1).mu) << material;
  }
}

TEST_F(MaterialArrays, AreReadInTheirRegionOnly) {
  mesh_.cell_arrays["E"](0, 2) = -1.0;
  const std::string region =
      "[[material_region]]\nselect = { box = { min = [0.5, -1, -1], max = [2, 2, 2] } }\n"
      "youngs_modulus = 1e6\npoissons_ratio = 0.25\n";
  const std::string material = "youngs_modulus = { array = \"E\" }\npoissons_ratio = 0.25";
  EXPECT_THROW(system(scene(material)), InputError);
  const auto mesh = generate_box({1, 1, 1}, {2, 1, 1});
  std::vector<Index> right;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    double x = 0.0;
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      x += 0.25 * mesh.vertices[static_cast<std::size_t>(v)].x();
    }
    if (x > 0.5) right.push_back(e);
  }
  mesh_.cell_arrays["E"](0, 2) = 1e5;
  mesh_.cell_arrays["E"](0, right.front()) = -1.0;
  const auto body = system(scene(material, region));
  EXPECT_NEAR(body->elastic().lame(right.front()).mu, 0.4e6, 1e-6);
}

TEST_F(MaterialArrays, RefusalsNamePlaceTetrahedronAndValue) {
  const std::string rest = "\npoissons_ratio = 0.25";
  mesh_.cell_arrays["E"](0, 7) = -3.0;
  EXPECT_EQ(refusal("youngs_modulus = { array = \"E\" }" + rest),
            "scene.toml:3:1: material.youngs_modulus: the cell array \"E\" of " + path("mesh.vtu") +
                " has the value -3 at tetrahedron 7; it must be above 0.");
  mesh_.cell_arrays["E"](0, 7) = std::nan("");
  expect_part(refusal("youngs_modulus = { array = \"E\" }" + rest),
              "has no value at tetrahedron 7");
  EXPECT_EQ(refusal("youngs_modulus = { array = \"F\" }" + rest),
            "scene.toml:3:1: material.youngs_modulus: the mesh " + path("mesh.vtu") +
                " has no cell array \"F\"; it has \"E\", \"direction\", \"rho\".");
  EXPECT_EQ(refusal("youngs_modulus = { array = \"direction\" }" + rest),
            "scene.toml:3:1: material.youngs_modulus: the cell array \"direction\" has 3 numbers "
            "for each tetrahedron, not one.");
  expect_part(refusal("youngs_modulus = 1e5\ndensity = { array = \"none\" }" + rest),
              "scene.toml:3:1: material.density: the mesh");
  // The condition is one between two parameters: λ > −2μ/3.
  mesh_.cell_arrays["E"](0, 7) = -1e5;
  expect_part(refusal("mu = 1e5\nlambda = { array = \"E\" }"), "material: tetrahedron 7: ");
  expect_part(refusal("youngs_modulus = { array = \"\" }" + rest), "youngs_modulus.array");
  expect_part(refusal("youngs_modulus = { arrays = \"E\" }" + rest), "unknown key");
  expect_part(refusal("youngs_modulus = { array = \"E\" }\nmu = 1e5" + rest),
              "material.mu cannot be combined");
  expect_part(refusal("youngs_modulus = { array = \"E\" }"), "material.poissons_ratio is missing");
}

TEST_F(MaterialArrays, EventsCanSetThem) {
  const std::string material = "youngs_modulus = 2e5\npoissons_ratio = 0.25";
  const Scene read =
      scene(material,
            "[[event]]\nat = 0.005\nset = { \"material.youngs_modulus\" = { array = \"E\" } "
            "}\n[[event]]\nat = 0.006\nset = { \"material.youngs_modulus\" = 3e5 }\n");
  ASSERT_EQ(read.event.size(), 2U);
  const auto& first = std::get<SetMaterial>(read.event[0].edits.at(0)).material;
  EXPECT_EQ(first.arrays.at("youngs_modulus"), "E");
  EXPECT_FALSE(first.youngs_modulus.has_value());
  const auto& second = std::get<SetMaterial>(read.event[1].edits.at(0)).material;
  EXPECT_TRUE(second.arrays.empty());
  EXPECT_EQ(second.youngs_modulus, 3e5);
  write_text_file(path("again.toml"), scene_text(read, folder_.string()));
  const Scene again = read_scene(path("again.toml"));
  EXPECT_EQ(std::get<SetMaterial>(again.event[0].edits.at(0)).material.arrays, first.arrays);
}

TEST_F(MaterialArrays, OfEventsAreCheckedBeforeTheRun) {
  const std::string material = "youngs_modulus = 2e5\npoissons_ratio = 0.25";
  const auto event = [](const std::string& key, const std::string& value) {
    return "[[event]]\nat = 0.005\nset = { \"material." + key + "\" = " + value + " }\n";
  };
  for (const char* array : {"absent", "direction"}) {
    const Scene read =
        scene(material, event("youngs_modulus", "{ array = \"" + std::string(array) + "\" }"));
    expect_error([&] { check_events(read, *system(read)); }, {"event", array});
  }
  const Scene good = scene(material, event("youngs_modulus", "{ array = \"E\" }"));
  EXPECT_NO_THROW(check_events(good, *system(good)));
  EXPECT_THROW(scene(material, event("density", "{ array = \"rho\" }")), InputError);
  EXPECT_THROW(scene(material, event("density.array", "\"rho\"")), InputError);
}

// A viscosity that gives a damping ratio depends on the modulus.
TEST_F(MaterialArrays, ExcludeDampingRatios) {
  EXPECT_THROW(scene("youngs_modulus = { array = \"E\" }\npoissons_ratio = 0.25",
                     "[damping]\nratio = { at = [10, 20], value = [0.01, 0.01] }"),
               InputError);
}

TEST_F(MaterialArrays, GmshFilesKeepThem) {
  write_mesh(mesh_, path("mesh.msh"));
  const TetMesh read = read_mesh(path("mesh.msh"));
  EXPECT_EQ(read.cell_arrays.at("E"), mesh_.cell_arrays.at("E"));
  EXPECT_EQ(read.cell_arrays.at("direction"), mesh_.cell_arrays.at("direction"));
}

// Only some elements have data; the others get NaN, which a material does not take.
TEST_F(MaterialArrays, OfGmshFilesMayLackElements) {
  const std::string body =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 "
      "1\n$EndNodes\n$Elements\n2\n11 4 0 1 2 3 4\n12 4 0 2 3 4 5\n$EndElements\n";
  const std::string data = "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n1\n12 5e5\n$EndElementData\n";
  write_text_file(path("part.msh"), body + data);
  const TetMesh mesh = read_mesh(path("part.msh"));
  ASSERT_EQ(mesh.cell_arrays.at("E").cols(), 2);
  EXPECT_TRUE(std::isnan(mesh.cell_arrays.at("E")(0, 0)));
  EXPECT_EQ(mesh.cell_arrays.at("E")(0, 1), 5e5);
  for (const char* broken :
       {"$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n9\n12 5e5\n$EndElementData\n",
        "$ElementData\n1\nE\n1\n0.0\n3\n0\n1\n1\n12 5e5\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n2\n1\n12 5e5\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n2\n0\n1\n12 5e5\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n1000000000000\n12 5e5\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n-1\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n1\n12 five\n$EndElementData\n",
        "$ElementData\n1\n\"E\"\n1\n0.0\n3\n0\n1\n1\n12 5e5\n"}) {
    write_text_file(path("broken.msh"), body + broken);
    EXPECT_THROW(read_mesh(path("broken.msh")), FileError) << broken;
  }
}

}  // namespace
}  // namespace tetraction
