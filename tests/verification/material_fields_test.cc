// Bodies whose moduli or densities are cell arrays of the mesh: closed forms, and the same runs with a
// region for every value.
#include <cmath>
#include <map>

#include "support/corner_scenes.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

// The centroid of a tetrahedron at rest.
Vector3 center(const TetMesh& mesh, Index e) {
  Vector3 sum = Vector3::Zero();
  for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
    sum += mesh.vertices[static_cast<std::size_t>(v)];
  }
  return 0.25 * sum;
}

// Sets the array `name` to value(centroid) in every tetrahedron.
template <class Value>
void set_array(TetMesh& mesh, const std::string& name, const Value& value) {
  Matrix values(1, mesh.tetrahedron_count());
  for (Index e = 0; e < values.cols(); ++e) values(0, e) = value(center(mesh, e));
  mesh.cell_arrays[name] = values;
}

// A neo-Hookean bar of slabs with different moduli, without lateral contraction (ν = 0). Each slab
// has the stretch at which μ (l − 1/l) is the traction at the end, so linear tetrahedra are exact.
TEST(MaterialFields, AGradedBarHasTheStretchOfEachSlab) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {2, 1, 1}, {8, 2, 2}};
  scene.material.poissons_ratio = 0.0;
  scene.material.arrays["youngs_modulus"] = "E";
  FixSettings wall;
  for (int axis = 0; axis < 3; ++axis) {
    wall.select = SelectPlane{axis, 0.0, {}};
    wall.components = {axis == 0, axis == 1, axis == 2};
    scene.fix.push_back(wall);
  }
  ForceSettings pull;
  pull.kind = LoadKind::kTraction;
  pull.select = SelectPlane{0, 2.0, {}};
  const double traction = 6e4;
  pull.vector = {traction, 0, 0};
  scene.traction = {pull};
  const auto modulus = [](double x) { return 1e5 * (1.0 + std::floor(4.0 * x)); };
  TetMesh mesh = generate_mesh(*scene.mesh.generate);
  set_array(mesh, "E", [&](const Vector3& x) { return modulus(x.x()); });
  FinishedRun session(scene, mesh, Analysis::kEquilibrium);
  double end = 0.0;
  std::map<double, double> exact{{0.0, 0.0}};
  for (int slab = 0; slab < 8; ++slab) {
    const double ratio = 0.5 * traction / (0.5 * modulus(0.25 * slab + 0.1));  // P/(2 μ)
    end += 0.25 * (ratio + std::sqrt(1.0 + ratio * ratio));
    exact[0.25 * (slab + 1)] = end;
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3& x = mesh.vertices[static_cast<std::size_t>(v)];
    const double place = 0.25 * std::round(4.0 * x.x());
    EXPECT_NEAR(session.state().position[3 * v], exact.at(place), 1e-11) << v;
    EXPECT_NEAR(session.state().position[3 * v + 1], x.y(), 1e-11) << v;
  }
}

// Four moduli and three densities, once as arrays and once as regions.
class FieldsAndRegions : public testing::TestWithParam<std::tuple<const char*, RuleWithSolver>> {
 protected:
  static double modulus(const Vector3& x) { return x.x() < 0.5 ? 4e4 : x.y() < 0.25 ? 2e5 : 1e5; }
  static double density(const Vector3& x) { return x.x() < 0.5 ? 700.0 : 1300.0; }

  static Scene scene() {
    Scene scene;
    scene.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {2, 0.5, 0.5}, {8, 2, 2}};
    const auto& [model, way] = GetParam();
    scene.material.model = model;
    scene.material.poissons_ratio = 0.3;
    if (scene.material.model == "mooney-rivlin") scene.material.numbers["ratio"] = 0.3;
    if (scene.material.model == "yeoh") {
      scene.material.numbers["c20"] = -500.0;
      scene.material.numbers["c30"] = 300.0;
    }
    scene.initial.stretch = {1.15, 0.95, 1.0};
    scene.initial.angular_velocity = {0.5, 1.0, 2.0};
    scene.damping.viscosity = 20.0;
    const bool implicit = is_implicit(way.integrator);
    scene.time = {way.integrator, implicit ? 0.01 : 1e-3, false, implicit ? 0.1 : 0.05};
    scene.solver = way.solver;
    scene.solver.tolerance = 1e-10;
    return scene;
  }
};

TEST_P(FieldsAndRegions, MoveAlike) {
  Scene fields = scene();
  fields.material.arrays = {{"youngs_modulus", "E"}, {"density", "rho"}};
  TetMesh mesh = generate_mesh(*fields.mesh.generate);
  set_array(mesh, "E", modulus);
  set_array(mesh, "rho", density);
  Scene regions = scene();
  std::map<std::pair<double, double>, std::vector<std::int64_t>> parts;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const Vector3 x = center(mesh, e);
    parts[{modulus(x), density(x)}].push_back(e);
  }
  std::vector<BodyRegion> bodies;
  std::vector<int> region_of_element(mesh.tetrahedra.size());
  for (const auto& [values, elements] : parts) {
    MaterialSettings material = regions.material;
    material.youngs_modulus = values.first;
    bodies.push_back({make_material(material), values.second});
    for (const std::int64_t e : elements) {
      region_of_element[static_cast<std::size_t>(e)] = static_cast<int>(bodies.size()) - 1;
    }
  }
  ASSERT_EQ(bodies.size(), 3U);

  Session session(fields, mesh);
  const MechanicalSystem& system = session.system();
  MechanicalSystem other(mesh, bodies, region_of_element);
  EXPECT_LT((system.mass() - other.mass()).norm(), 1e-15 * other.mass().norm());
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();

  // The same run with regions: sets of tetrahedra are selected by groups of the mesh.
  TetMesh grouped = mesh;
  regions.material.youngs_modulus = 1.0;
  int number = 0;
  for (const auto& [values, elements] : parts) {
    Group group;
    group.name = "part" + std::to_string(number++);
    group.tetrahedra.assign(elements.begin(), elements.end());
    grouped.groups.push_back(group);
    MaterialRegionSettings region{SelectGroup{group.name}, regions.material, {}};
    region.material.youngs_modulus = values.first;
    region.material.density = values.second;
    regions.material_region.push_back(region);
  }
  FinishedRun reference(regions, grouped);
  const double moved = (reference.state().position - mesh.rest_positions()).cwiseAbs().maxCoeff();
  EXPECT_GT(moved, 0.03);
  EXPECT_LT((session.state().position - reference.state().position).cwiseAbs().maxCoeff(),
            1e-7 * moved);
  EXPECT_NEAR(session.balance().dissipated_energy(), reference.balance().dissipated_energy(),
              1e-7 * reference.balance().dissipated_energy());
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-9);
  EXPECT_NEAR(session.balance().angular_momentum_drift(),
              reference.balance().angular_momentum_drift(), 1e-7);
  // Backward Euler does not conserve the angular momentum.
  if (std::get<1>(GetParam()).integrator != Integrator::kBackwardEuler) {
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(All, FieldsAndRegions,
                         testing::Combine(testing::Values("neo-hookean", "mooney-rivlin", "stvk",
                                                          "yeoh"),
                                          testing::ValuesIn(rules_with_solvers())),
                         [](const auto& test) {
                           std::string name = std::string(std::get<0>(test.param)) + "_" +
                                              std::get<1>(test.param).name;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

// The stability limit is that of the stiffest and lightest element.
TEST(MaterialFields, OneStiffElementLimitsExplicitSteps) {
  Scene scene = scene_of({GeneratorKind::kBeam, {2, 0.5, 0.5}, {8, 2, 2}}, elastic(1e5, 0.3));
  scene.time = {Integrator::kVerlet, 1e-3, true, 0.1};
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  const Session soft(scene, mesh);
  scene.material.youngs_modulus.reset();
  scene.material.arrays["youngs_modulus"] = "E";
  TetMesh with_array = mesh;
  set_array(with_array, "E", [](const Vector3&) { return 1e5; });
  with_array.cell_arrays["E"](0, 40) = 4e7;
  Session stiff(scene, with_array);
  // The wave speed in the element is 20 times that in the others. Its vertices also have masses of
  // other elements, so that the limit falls by less.
  EXPECT_LT(stiff.time_step(), 0.2 * soft.time_step());
  EXPECT_GT(stiff.time_step(), 0.05 * soft.time_step());
  ASSERT_EQ(stiff.run(), RunStatus::kFinished) << stiff.message();
}

TEST(MaterialFields, CanChangeDuringARun) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {2, 0.5, 0.5}, {8, 2, 2}};
  scene.material.arrays["youngs_modulus"] = "E";
  scene.material.poissons_ratio = 0.3;
  scene.initial.stretch = {1.1, 1, 1};
  TetMesh mesh = generate_mesh(*scene.mesh.generate);
  set_array(mesh, "E", [](const Vector3& x) { return 1e5 * (1.0 + x.x()); });
  set_array(mesh, "stiffer", [](const Vector3& x) { return 3e5 * (1.0 + x.x()); });
  Session session(scene, mesh);
  const double before = session.balance().energies().elastic();
  MaterialSettings stiffer = scene.material;
  stiffer.arrays["youngs_modulus"] = "stiffer";
  session.apply(SetMaterial{0, stiffer});
  EXPECT_NEAR(session.balance().energies().elastic(), 3.0 * before, 1e-12 * before);
  const Checkpoint checkpoint = session.checkpoint();

  MaterialSettings wrong = stiffer;
  wrong.arrays["youngs_modulus"] = "absent";
  EXPECT_THROW(session.apply(SetMaterial{0, wrong}), InputError);
  wrong = stiffer;
  wrong.arrays["density"] = "E";
  EXPECT_THROW(session.apply(SetMaterial{0, wrong}), InputError);
  EXPECT_NEAR(session.balance().energies().elastic(), 3.0 * before, 1e-12 * before);

  MaterialSettings uniform = stiffer;
  uniform.arrays.clear();
  uniform.youngs_modulus = 1e5;
  session.apply(SetMaterial{0, uniform});
  EXPECT_LT(session.balance().energies().elastic(), before);
  session.restore(checkpoint);
  EXPECT_NEAR(session.balance().energies().elastic(), 3.0 * before, 1e-12 * before);

  // Another array in the same mesh is another body.
  TetMesh changed = mesh;
  changed.cell_arrays["stiffer"](0, 3) *= 2.0;
  Session another(scene, changed);
  EXPECT_THROW(another.restore(checkpoint), InputError);
}

}  // namespace
}  // namespace tetraction
