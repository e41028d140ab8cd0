#include "simulation/facts/free_motions.h"

#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/cubes.h"
#include "support/messages.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using testing_support::cubes;

std::unique_ptr<MechanicalSystem> body_of(TetMesh mesh) {
  const LameParameters lame = lame_from_young(1e6, 0.3);
  return std::make_unique<MechanicalSystem>(std::move(mesh),
                                            MaterialModel(NeoHookean(lame.mu, lame.lambda)), 1e3);
}

std::vector<Index> in_box(const TetMesh& mesh, const Vector3& low, const Vector3& high) {
  return select_vertices(mesh, SelectBox{low, high});
}

void hold_box(MechanicalSystem& system, const Vector3& low, const Vector3& high,
              double penalty = 0.0) {
  ConstraintList list = system.constraints().list();
  list.held.push_back(prescribe_at_rest(system.mesh(), in_box(system.mesh(), low, high), "held"));
  list.held.back().penalty = penalty;
  system.set_constraints(Constraints(list, system.mesh(), system.mass()));
}

// The motions of the pieces of a free body against each other.
Index motions_of(TetMesh mesh, std::size_t pieces) {
  const auto system = body_of(std::move(mesh));
  const FreeMotions motions = find_free_motions(*system);
  EXPECT_EQ(motions.parts, 1U);
  EXPECT_EQ(motions.pieces, pieces);
  EXPECT_EQ(motions.whole.size(), 6U);
  if (motions.mechanisms.empty()) return 0;
  EXPECT_EQ(motions.mechanisms.front().free_motions, motions.mechanisms.front().motions);
  return motions.mechanisms.front().motions;
}

// The degrees of freedom of linkages by counting (Grübler): a hinge leaves 1, a ball joint 3.
TEST(FreeMotions, MechanismsHaveTheMotionsOfTheirJoints) {
  for (const bool quadratic : {false, true}) {
    const auto made = [&](const std::vector<std::array<int, 3>>& places) {
      return quadratic ? with_edge_vertices(cubes(places)) : cubes(places);
    };
    EXPECT_EQ(motions_of(made({{0, 0, 0}, {1, 0, 0}}), 1), 0);  // a common face
    EXPECT_EQ(motions_of(made({{0, 0, 0}, {1, 1, 0}}), 2), 1);  // an edge: a hinge
    EXPECT_EQ(motions_of(made({{0, 0, 0}, {1, 1, 1}}), 2), 3);  // a corner: a ball joint
    EXPECT_EQ(motions_of(made({{0, 0, 0}, {1, 1, 0}, {2, 0, 0}}), 3), 2);
    // Four hinges in a ring, with parallel axes: 3 (4 − 1) − 2 · 4 in the plane.
    EXPECT_EQ(motions_of(made({{1, 0, 0}, {0, 1, 0}, {2, 1, 0}, {1, 2, 0}}), 4), 1);
    // Two hinges with parallel axes between the same pieces: none.
    EXPECT_EQ(
        motions_of(made({{0, 0, 0}, {0, -1, 0}, {1, -1, 0}, {2, -1, 0}, {2, 0, 0}, {1, 1, 0}}), 2),
        0);
    // Two pieces that touch in two corners far from each other turn about the line through them.
    EXPECT_EQ(motions_of(made({{1, 0, 0},
                               {1, 0, 1},
                               {1, 0, 2},
                               {2, 1, -1},
                               {3, 1, -1},
                               {3, 1, 0},
                               {3, 1, 1},
                               {3, 1, 2},
                               {3, 1, 3},
                               {2, 1, 3}}),
                         2),
              1);
  }
}

TEST(FreeMotions, SupportsMayHoldAMechanism) {
  const std::vector<std::array<int, 3>> hinged{{0, 0, 0}, {1, 1, 0}};
  const auto body = body_of(cubes(hinged));
  hold_box(*body, {0, 0, 0}, {0, 1, 1});
  FreeMotions motions = find_free_motions(*body);
  EXPECT_TRUE(motions.whole.empty());
  ASSERT_EQ(motions.mechanisms.size(), 1U);
  EXPECT_EQ(motions.mechanisms.front().free_motions, 1);
  EXPECT_EQ(motions.mechanisms.front().joints, in_box(body->mesh(), {1, 1, 0}, {1, 1, 1}));
  EXPECT_NE(mechanism_warning(motions).find("on the line through (1, 1, 0) along z"),
            std::string::npos)
      << mechanism_warning(motions);
  testing_support::expect_error([&] { find_equilibrium(*body); }, {"as a mechanism"});

  // One more vertex of the other cube.
  const auto held = body_of(cubes(hinged));
  hold_box(*held, {0, 0, 0}, {0, 1, 1});
  hold_box(*held, {2, 2, 1}, {2, 2, 1});
  motions = find_free_motions(*held);
  EXPECT_EQ(motions.mechanisms.front().motions, 1);
  EXPECT_EQ(motions.mechanisms.front().free_motions, 0);
  EXPECT_TRUE(mechanism_warning(motions).empty());
  EXPECT_TRUE(free_motions(*held).empty());
  EXPECT_TRUE(find_equilibrium(*held).found);

  const auto sprung = body_of(cubes(hinged));
  hold_box(*sprung, {0, 0, 0}, {0, 1, 1});
  hold_box(*sprung, {2, 2, 1}, {2, 2, 1}, 1e-3);
  EXPECT_TRUE(free_motions(*sprung).empty());

  // A free rigid handle with vertices of both cubes that are not on the hinge.
  const auto handled = body_of(cubes(hinged));
  const std::vector<Index> handle = in_box(handled->mesh(), {1, 0, 0}, {2, 1, 1});
  Matrix shape(3, static_cast<Index>(handle.size()));
  for (std::size_t i = 0; i < handle.size(); ++i) {
    shape.col(static_cast<Index>(i)) =
        handled->mesh().vertices[static_cast<std::size_t>(handle[i])];
  }
  handled->set_constraints(Constraints({{}, {}, {}, {RigidHandle{handle, shape, "handle"}}},
                                       handled->mesh(), handled->mass()));
  motions = find_free_motions(*handled);
  EXPECT_EQ(motions.whole.size(), 6U);
  EXPECT_TRUE(motions.mechanisms.empty());
}

// Guides hold what is perpendicular to them: a hinge along z and sliding in z.
TEST(FreeMotions, GuidedPieces) {
  const auto body = body_of(cubes({{0, 0, 0}, {1, 1, 0}}));
  ConstraintList list;
  GuidedVertices guided;  // vertices of the first cube, which may move along z
  guided.vertices = in_box(body->mesh(), {0, 0, 0}, {1, 0, 1});
  guided.directions = Vector3::UnitZ();
  guided.points.resize(3, static_cast<Index>(guided.vertices.size()));
  for (std::size_t i = 0; i < guided.vertices.size(); ++i) {
    guided.points.col(static_cast<Index>(i)) =
        body->mesh().vertices[static_cast<std::size_t>(guided.vertices[i])];
  }
  list.guided.push_back(guided);
  body->set_constraints(Constraints(list, body->mesh(), body->mass()));
  const FreeMotions motions = find_free_motions(*body);
  EXPECT_EQ(motions.whole, std::vector<std::string>{"move along z"});
  ASSERT_EQ(motions.mechanisms.size(), 1U);
  EXPECT_EQ(motions.mechanisms.front().free_motions, 1);
}

TEST(FreeMotions, ModesOfMechanisms) {
  for (const bool quadratic : {false, true}) {
    const auto made = [&](const std::vector<std::array<int, 3>>& places) {
      return body_of(quadratic ? with_edge_vertices(cubes(places)) : cubes(places));
    };
    const auto free = made({{0, 0, 0}, {1, 1, 0}});
    const Vector rest = free->mesh().rest_positions();
    NormalModes modes = normal_modes(*free, rest);
    for (std::size_t i = 0; i < 8; ++i) {
      const ModeKind kind = i < 6    ? ModeKind::kRigid
                            : i == 6 ? ModeKind::kMechanism
                                     : ModeKind::kElastic;
      EXPECT_EQ(modes.modes[i].kind, kind) << i;
    }
    EXPECT_EQ(modes.modes[6].omega_squared, 0.0);

    const auto clamped = made({{0, 0, 0}, {1, 1, 0}});
    hold_box(*clamped, {0, 0, 0}, {0, 1, 1});
    modes = normal_modes(*clamped, rest);
    EXPECT_EQ(modes.modes[0].kind, ModeKind::kMechanism);
    EXPECT_EQ(modes.modes[1].kind, ModeKind::kElastic);
    // The second cube turns about the hinge (1, 1, z), and the first one stays.
    const Vector& shape = modes.modes[0].shape;
    double rate = 0.0;
    for (const Index v : in_box(clamped->mesh(), {2, 2, 1}, {2, 2, 1})) rate = shape[3 * v + 1];
    ASSERT_NE(rate, 0.0);
    for (Index v = 0; v < clamped->vertex_count(); ++v) {
      const Vector3 x = vertex_block(rest, v);
      const bool second = x.x() > 1.0 || x.y() > 1.0;
      const Vector3 turned = second ? Vector3(rate * Vector3::UnitZ().cross(x - Vector3(1, 1, 0)))
                                    : Vector3(Vector3::Zero());
      EXPECT_LT((vertex_block(shape, v) - turned).norm(), 1e-10 * std::abs(rate)) << v;
    }
  }
}

}  // namespace
}  // namespace tetraction
