// Equilibria of bodies so slender that the round-off of stresses is of the size of the loads.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

constexpr double kYoungsModulusOfBars = 1e9;

// A wire of quadratic elements, 1 m long, that is clamped at x = 0. A force at its end bends it.
struct Wire {
  TetMesh mesh;
  MechanicalSystem system;

  // `deflection`: of the end in the theory of small bending, m.
  Wire(double thickness, double deflection)
      : mesh(with_edge_vertices(generate_box({1.0, thickness, thickness}, {40, 1, 1}))),
        system(mesh,
               NeoHookean(lame_from_young(kYoungsModulusOfBars, 0.0).mu,
                          lame_from_young(kYoungsModulusOfBars, 0.0).lambda),
               1000.0) {
    const PrescribedVertices clamp =
        prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}}), "clamp");
    system.set_constraints(Constraints({{clamp}, {}, {}, {}}, mesh, system.mass()));
    ExternalForce pull;
    pull.vertices = select_vertices(mesh, SelectPlane{0, 1.0, {}});
    const double stiffness = 3.0 * kYoungsModulusOfBars * std::pow(thickness, 4) / 12.0;
    pull.vector = {0.0, 0.0, -deflection * stiffness / static_cast<double>(pull.vertices.size())};
    system.add_force(pull);
  }
  double deflection_of(const Equilibrium& equilibrium) const {
    return (mesh.rest_positions() - equilibrium.position).maxCoeff();
  }
};

TEST(SlenderStatics, AWireBendsByTheRightAmount) {
  for (const double thickness : {1e-2, 1e-3, 3e-4, 1e-4}) {
    const Wire wire(thickness, 0.01);
    const Equilibrium equilibrium = find_equilibrium(wire.system, {});
    ASSERT_TRUE(equilibrium.found) << thickness << ": " << equilibrium.message;
    EXPECT_TRUE(equilibrium.path.limit_points.empty()) << equilibrium.message;
    EXPECT_NEAR(wire.deflection_of(equilibrium), 0.01, 1e-4) << thickness;
  }
}

// A bending by a tenth of the length, at which straight elements of such a wire begin to be too stiff.
TEST(SlenderStatics, ThereIsNoLimitPointWhereAWireBendsFar) {
  const Wire wire(1e-4, 0.1);
  const Equilibrium equilibrium = find_equilibrium(wire.system, {});
  ASSERT_TRUE(equilibrium.found) << equilibrium.message;
  EXPECT_TRUE(equilibrium.path.limit_points.empty()) << equilibrium.message;
  EXPECT_NEAR(wire.deflection_of(equilibrium), 0.0954, 0.0005);
}

// The loads are far below the round-off of the stresses, and the displacements are right all the same.
TEST(SlenderStatics, TinyLoadsMoveAWire) {
  for (const double thickness : {1e-3, 3e-4, 1e-4}) {
    const Wire wire(thickness, 1e-5);
    const Equilibrium equilibrium = find_equilibrium(wire.system, {});
    ASSERT_TRUE(equilibrium.found) << thickness << ": " << equilibrium.message;
    EXPECT_NEAR(wire.deflection_of(equilibrium), 1e-5, 0.01 * 1e-5) << thickness;
  }
}

// Where the answer is beyond double precision, none is given.
TEST(SlenderStatics, WhatRoundOffHidesIsRefused) {
  const Wire wire(1e-6, 1e-5);
  const Equilibrium equilibrium = find_equilibrium(wire.system, {});
  if (equilibrium.found) {
    EXPECT_NEAR(wire.deflection_of(equilibrium), 1e-5, 0.05 * 1e-5);
    return;
  }
  EXPECT_NE(equilibrium.message.find("round-off"), std::string::npos) << equilibrium.message;
  EXPECT_EQ(equilibrium.message.find("limit point"), std::string::npos) << equilibrium.message;
}

}  // namespace
}  // namespace tetraction
