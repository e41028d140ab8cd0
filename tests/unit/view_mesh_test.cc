
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "support/allocations.h"
#include "support/runs.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A user's arrays: those of a block, with indices of either width.
template <class Number>
class ViewMesh : public testing::Test {
 protected:
  ViewMesh() {
    for (const Vector3 x : block_.vertices) {
      positions_.insert(positions_.end(), x.begin(), x.end());
    }
    for (const auto nodes : block_.tetrahedra) {
      for (const Index v : nodes) tetrahedra_.push_back(static_cast<Number>(v));
    }
  }

  void expect_refused(const std::string& what) const {
    expect_error([&] { view_mesh(positions_, tetrahedra_); }, {what});
  }

  const TetMesh block_ = small_block({6, 3, 3});
  std::vector<double> positions_;
  std::vector<Number> tetrahedra_;
};

using Numbers = testing::Types<std::int32_t, std::int64_t>;
TYPED_TEST_SUITE(ViewMesh, Numbers);

TYPED_TEST(ViewMesh, TheBodyWorksOnTheArraysThemselves) {
  const MaterialModel material = all_materials()[1];
  const TetMesh mesh = view_mesh(this->positions_, this->tetrahedra_);
  MechanicalSystem body(mesh, material, 1000.0);
  Session session(spinning_block(Integrator::kVerlet, 1e-3, 1.0), mesh);
  for (const TetMesh* used : {&mesh, &body.mesh(), &session.system().mesh()}) {
    EXPECT_EQ(used->vertices.view().data(), this->positions_.data());
    EXPECT_EQ(used->tetrahedra.view().data(), this->tetrahedra_.data());
    EXPECT_TRUE(used->vertex_ids.empty() && used->tetrahedron_ids.empty() && used->regions.empty());
  }
  // The rest state reads them, too.
  const double before = body.rest().volume(0);
  for (double& x : this->positions_) x *= 2.0;
  EXPECT_NEAR(body.rest().volume(0), 8.0 * before, 1e-12 * before);
}

TYPED_TEST(ViewMesh, StepsAreThoseOfAnOwnedMesh) {
  const TetMesh mesh = view_mesh(this->positions_, this->tetrahedra_);
  EXPECT_EQ(mesh.vertices, this->block_.vertices);
  EXPECT_EQ(mesh.tetrahedra, this->block_.tetrahedra);
  const Scene scene = spinning_block(Integrator::kMidpoint, 1e-2, 0.1);
  Session viewed(scene, mesh);
  Session owned(scene, this->block_);
  EXPECT_EQ(viewed.run(), RunStatus::kFinished);
  EXPECT_EQ(owned.run(), RunStatus::kFinished);
  EXPECT_EQ(viewed.state().position, owned.state().position);
}

TYPED_TEST(ViewMesh, IdsCountFromZero) {
  const TetMesh mesh = view_mesh(this->positions_, this->tetrahedra_);
  EXPECT_EQ(mesh.vertex_id(7), 7);
  EXPECT_EQ(mesh.tetrahedron_id(11), 11);
  EXPECT_EQ(mesh.region(11), 0);
  EXPECT_EQ(select_vertices(mesh, SelectVertices{{3, 5}}), (std::vector<Index>{3, 5}));
  EXPECT_THROW(select_vertices(mesh, SelectVertices{{1000}}), InputError);
}

TYPED_TEST(ViewMesh, AChangeIsMadeInACopy) {
  const std::vector<double> before = this->positions_;
  TetMesh mesh = view_mesh(this->positions_, this->tetrahedra_);
  mesh.vertices.own()[1] += Vector3::UnitX();
  std::swap(mesh.tetrahedra.own()[0][2], mesh.tetrahedra.own()[0][3]);
  EXPECT_FALSE(mesh.vertices.is_view());
  EXPECT_EQ(this->positions_, before);
  EXPECT_EQ(mesh.vertices[1], this->block_.vertices[1] + Vector3::UnitX());
  EXPECT_EQ(mesh.vertices[2], this->block_.vertices[2]);
  EXPECT_LT(mesh.volume(0), 0.0);
  EXPECT_NE(mesh.tetrahedra, this->block_.tetrahedra);
}

TYPED_TEST(ViewMesh, NothingOfTheirSizeIsAllocated) {
  if (!can_count_allocations()) GTEST_SKIP() << "the address sanitizer has malloc";
  // A bit a vertex is what the check takes while it runs.
  const AllocationCounter counter(this->positions_.size() / 3);
  const TetMesh mesh = view_mesh(this->positions_, this->tetrahedra_);
  const TetMesh copy = mesh;
  EXPECT_EQ(counter.count(), 0) << copy.vertex_count();
}

TYPED_TEST(ViewMesh, WhatIsWrongIsRefused) {
  const auto positions = this->positions_;
  const auto tetrahedra = this->tetrahedra_;
  this->positions_.pop_back();
  this->expect_refused("three coordinates a vertex");
  this->positions_.clear();
  this->expect_refused("0 and");
  this->positions_ = positions;
  this->tetrahedra_.pop_back();
  this->expect_refused("four vertices a tetrahedron");
  this->tetrahedra_ = tetrahedra;
  std::swap(this->tetrahedra_[4 * 5 + 2], this->tetrahedra_[4 * 5 + 3]);
  this->expect_refused("Tetrahedron 5 has a volume of -");
  this->tetrahedra_[4 * 5 + 2] = this->tetrahedra_[4 * 5 + 3];
  this->expect_refused("Tetrahedron 5 has a volume of 0");
  this->tetrahedra_[4 * 5 + 2] = static_cast<TypeParam>(positions.size() / 3);
  this->expect_refused("Tetrahedron 5 refers to vertex");
  this->tetrahedra_[4 * 5 + 2] = -1;
  this->expect_refused("refers to vertex -1");
  this->tetrahedra_ = tetrahedra;
  this->positions_[3 * 9 + 1] = std::numeric_limits<double>::quiet_NaN();
  this->expect_refused("Vertex 9 has a coordinate that is not finite");
  this->positions_ = positions;
  this->positions_.insert(this->positions_.end(), {9.0, 9.0, 9.0});
  this->expect_refused("No tetrahedron uses vertex " + std::to_string(positions.size() / 3));
}

}  // namespace
}  // namespace tetraction
