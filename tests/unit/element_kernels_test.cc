#include "fem/kernels/element_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fem/element_blocks.h"
#include "support/bodies.h"
#include "support/instruction_sets.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::size_t> single_materials() {
  return {0, 1, 2};
}

// The first `count` tetrahedra of a box; vertices that none of them uses stay.
TetMesh some_elements(Index count, const std::array<int, 3>& cells) {
  TetMesh mesh = generate_box({1.2, 1.0, 0.9}, cells);
  EXPECT_GE(mesh.tetrahedron_count(), count);
  mesh.tetrahedra.own().resize(static_cast<std::size_t>(count));
  return mesh;
}

// Stretches x ∈ [0, 2] by 0.25 + x and y by 0.6 + 0.5x: J from 0.15 to 3.6.
Vector strong_state(const Vector& rest, double jiggle) {
  Vector q = rest;
  for (Index v = 0; v < q.size() / 3; ++v) {
    const Vector3 x = rest.segment<3>(3 * v);
    q.segment<3>(3 * v) = Vector3(0.25 * x.x() + 0.5 * x.x() * x.x(),
                                  (0.6 + 0.5 * x.x()) * x.y() + 0.3 * x.z(), x.z() + 0.2 * x.x());
  }
  return jiggled(q, jiggle);
}

// The same sums element by element, in extended precision.
struct Reference {
  double energy = 0.0;
  double energy_scale = 0.0;  // Σ |energy|
  Vector gradient;
  double gradient_scale = 0.0;  // root sum of squares of the elements' gradients
};

Reference reference(const ElasticPotential& potential, const Vector& q) {
  Reference r;
  Eigen::Matrix<long double, Eigen::Dynamic, 1> gradient =
      Eigen::Matrix<long double, Eigen::Dynamic, 1>::Zero(q.size());
  long double energy = 0.0L;
  for (Index e = 0; e < potential.rest().element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    EXPECT_TRUE(potential.element_terms(e, q, false, terms));
    energy += terms.energy;
    r.energy_scale += std::abs(terms.energy);
    r.gradient_scale += terms.gradient.squaredNorm();
    for (int a = 0; a < 4; ++a) {
      gradient.segment<3>(3 * potential.rest().nodes(e)[static_cast<std::size_t>(a)]) +=
          terms.gradient.col(a).cast<long double>();
    }
  }
  r.energy = static_cast<double>(energy);
  r.gradient = gradient.cast<double>();
  r.gradient_scale = std::sqrt(r.gradient_scale);
  return r;
}

void expect_like_reference(const ElasticPotential& potential, const Vector& q, double tolerance) {
  const Reference r = reference(potential, q);
  double alone = 0.0;
  double energy = 0.0;
  Vector gradient;
  ASSERT_TRUE(potential.value(q, alone).ok());
  ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());
  EXPECT_LT(std::abs(energy - r.energy), tolerance * r.energy_scale);
  EXPECT_LT(std::abs(alone - r.energy), tolerance * r.energy_scale);
  EXPECT_LT((gradient - r.gradient).norm(), tolerance * r.gradient_scale);
}

class ElementKernels : public testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  const std::int64_t set_ = std::get<0>(GetParam());
  const UseInstructionSet use_{set_};
  const MaterialModel material_ = all_materials()[std::get<1>(GetParam())];
};

TEST_P(ElementKernels, RunOnTheSetThatWasChosen) {
  EXPECT_EQ(instruction_set(), instruction_set_name(set_));
}

TEST_P(ElementKernels, AgreeWithTheScalarElementAtModerateStrains) {
  const TetMesh mesh = small_block({9, 5, 5});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  for (const double strain : {0.05, 0.1, 0.2}) {
    expect_like_reference(potential, strained_state(potential, mesh.rest_positions(), strain),
                          1e-13);
  }
}

TEST_P(ElementKernels, AgreeWithTheScalarElementAtStrongStrains) {
  const TetMesh mesh = small_block({11, 4, 4});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  const Vector q = strong_state(mesh.rest_positions(), 0.005);
  double least = kInfinity;
  double most = 0.0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const double j = jacobian(deformation_gradient(rest.point(e), 0, rest.gather(q, e)));
    least = std::min(least, j);
    most = std::max(most, j);
  }
  ASSERT_GT(least, 0.0);
  ASSERT_LT(least, 0.25);
  ASSERT_GT(most, 3.0);
  expect_like_reference(potential, q, 1e-13);
  // Everything shrunk or blown up: no lane is near J = 1.
  expect_like_reference(potential, 0.3 * q, 1e-13);
  expect_like_reference(potential, 4.0 * q, 1e-13);
}

TEST_P(ElementKernels, LogarithmJoinsSmoothlyWhereItsSeriesEnds) {
  // Uniform volumes about the ends of the series, |J − 1|/(J + 1) = 1/6: J = 5/7 and 7/5.
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  for (const double j : {5.0 / 7.0, 7.0 / 5.0}) {
    for (const double off : {-1e-3, -1e-9, 0.0, 1e-9, 1e-3}) {
      expect_like_reference(potential, std::cbrt(j * (1.0 + off)) * mesh.rest_positions(), 1e-13);
    }
  }
}

TEST_P(ElementKernels, KeepTheDigitsOfTinyEnergies) {
  // Edges of this mesh, with displacements that are multiples of 2⁻⁴⁰, are exact in double
  // precision: what is left is the rounding of C − 1 in the kernels, a few ε beside the strain.
  const TetMesh mesh = generate_box({2, 1, 1}, {4, 2, 2});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  for (const double strain : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8}) {
    Vector q = mesh.rest_positions();
    const Vector moved = jiggled(Vector::Zero(q.size()), 0.5 * strain);
    for (Index i = 0; i < q.size(); ++i)
      q[i] += std::ldexp(std::round(std::ldexp(moved[i], 40)), -40);
    const Reference r = reference(potential, q);
    const auto [energy, gradient] = value_and_gradient_of(potential, q);
    ASSERT_GT(r.energy, 0.0);
    EXPECT_LT(std::abs(energy - r.energy), 16.0 * kEpsilon / strain * r.energy) << strain;
    EXPECT_LT((gradient - r.gradient).norm(), 32.0 * kEpsilon / strain * r.gradient_scale)
        << strain;
  }
}

TEST_P(ElementKernels, AnyNumberOfElementsAndThreads) {
  for (const Index count : {1, 5, 15, 16, 17, 1023, 1024, 1025, 2050, 3000}) {
    const TetMesh mesh = some_elements(count, {10, 8, 7});
    const RestState rest(mesh);
    const ElasticPotential potential(rest, material_);
    const Vector q = jiggled(mesh.rest_positions(), 0.008);
    expect_like_reference(potential, q, 1e-13);
    double first = 0.0;
    Vector first_gradient;
    for (const int threads : {1, 2, 3, 4}) {
      set_thread_count(threads);
      double alone = 0.0;
      double energy = 0.0;
      Vector gradient;
      ASSERT_TRUE(potential.value(q, alone).ok());
      ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());
      EXPECT_EQ(alone, energy) << count;
      if (threads == 1) {
        first = energy;
        first_gradient = gradient;
      }
      EXPECT_EQ(energy, first) << count << " elements, " << threads << " threads";
      EXPECT_EQ(gradient, first_gradient) << count << " elements, " << threads << " threads";
    }
    set_thread_count(0);
  }
}

TEST_P(ElementKernels, NumbersThatAreNotFiniteAreRefused) {
  const TetMesh mesh = small_block({3, 2, 2});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, material_);
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (Index i = 0; i < 3 * mesh.vertex_count(); ++i) {
      Vector q = mesh.rest_positions();
      q[i] = bad;
      double energy = 0.0;
      Vector gradient;
      Index least = 0;
      while (!std::ranges::count(rest.nodes(least), i / 3)) ++least;
      EXPECT_EQ(potential.value(q, energy).failed_element, least) << i;
      EXPECT_EQ(potential.value_and_gradient(q, energy, gradient).failed_element, least) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ElementKernels,
                         testing::Combine(testing::ValuesIn(instruction_sets()),
                                          testing::ValuesIn(single_materials())),
                         [](const auto& test) {
                           std::string name =
                               instruction_set_name(std::get<0>(test.param)) + "_" +
                               material_name(all_materials()[std::get<1>(test.param)]);
                           std::erase(name, '-');
                           return name;
                         });

class ElementKernelsOfASet : public testing::TestWithParam<std::int64_t> {
 protected:
  const UseInstructionSet use_{GetParam()};
};

// Odd numbers of elements of three materials, one of them with a single element.
std::vector<int> mixed_regions(Index elements) {
  std::vector<int> region(static_cast<std::size_t>(elements));
  for (Index e = 0; e < elements; ++e) region[static_cast<std::size_t>(e)] = e % 7 < 3 ? 0 : 2;
  region[static_cast<std::size_t>(elements / 2)] = 1;
  return region;
}

TEST_P(ElementKernelsOfASet, MixedMaterials) {
  for (const Index count : {3, 17, 101, 2477}) {
    const TetMesh mesh = some_elements(count, {9, 8, 6});
    const RestState rest(mesh);
    const ElasticPotential potential(rest, all_materials(), mixed_regions(count));
    const Vector q = jiggled(mesh.rest_positions(), 0.008);
    expect_like_reference(potential, q, 1e-13);
    const Vector energies = potential.energies_by_material(q);
    Vector expected = Vector::Zero(3);
    for (Index e = 0; e < count; ++e) {
      ElasticPotential::ElementTerms terms;
      ASSERT_TRUE(potential.element_terms(e, q, false, terms));
      expected[potential.material_index(e)] += terms.energy;
    }
    EXPECT_LT((energies - expected).cwiseAbs().maxCoeff(), 1e-13 * expected.maxCoeff());
  }
}

TEST_P(ElementKernelsOfASet, NameTheLeastInvertedElement) {
  const TetMesh mesh = small_block({10, 6, 6});  // several blocks
  const RestState rest(mesh);
  const std::vector<int> regions = mixed_regions(rest.element_count());
  const ElasticPotential potential(rest, all_materials(), regions);
  std::mt19937 random(5);
  int found = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Vector q = jiggled(mesh.rest_positions(), 0.01);
    for (int i = 0; i < 3; ++i) {
      const Index v = static_cast<Index>(random()) % mesh.vertex_count();
      q.segment<3>(3 * v) += Vector3(0.6, -0.5, 0.4);
    }
    Index least = -1;
    for (Index e = 0; e < rest.element_count() && least < 0; ++e) {
      const double j = jacobian(deformation_gradient(rest.point(e), 0, rest.gather(q, e)));
      if (regions[static_cast<std::size_t>(e)] != 0 && !(j > 0.0)) least = e;
    }
    found += least > 0 ? 1 : 0;
    double energy = 0.0;
    Vector gradient;
    EXPECT_EQ(potential.value(q, energy).failed_element, least);
    EXPECT_EQ(potential.value_and_gradient(q, energy, gradient).failed_element, least);
  }
  EXPECT_GT(found, 30);
}

TEST_P(ElementKernelsOfASet, ElementsWithoutVolumeAreInverted) {
  const TetMesh mesh = generate_tetrahedron();
  const RestState rest(mesh);
  Vector q = mesh.rest_positions();
  q.tail<3>() = Vector3(0.25, 0.25, 0.0);
  for (const std::size_t material : {1U, 2U}) {
    const ElasticPotential potential(rest, all_materials()[material]);
    double energy = 0.0;
    Vector gradient;
    EXPECT_EQ(potential.value(q, energy).failed_element, 0);
    EXPECT_EQ(potential.value_and_gradient(q, energy, gradient).failed_element, 0);
  }
  // St Venant and Kirchhoff's is defined there, and inside out.
  const ElasticPotential potential(rest, all_materials()[0]);
  expect_like_reference(potential, q, 1e-13);
  q[11] = -1.0;
  expect_like_reference(potential, q, 1e-13);
}

TEST_P(ElementKernelsOfASet, TheNumberingDoesNotMatter) {
  const TetMesh mesh = small_block({8, 5, 5});
  const RestState rest(mesh);
  const std::vector<int> regions = mixed_regions(rest.element_count());
  const Vector q = jiggled(mesh.rest_positions(), 0.015);
  double energy = 0.0;
  Vector gradient;
  const ElasticPotential potential(rest, all_materials(), regions);
  ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());

  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::vector<Index> vertex(static_cast<std::size_t>(mesh.vertex_count()));  // old → new
    std::iota(vertex.begin(), vertex.end(), 0);
    std::shuffle(vertex.begin(), vertex.end(), random);
    std::vector<Index> element(static_cast<std::size_t>(mesh.tetrahedron_count()));  // new → old
    std::iota(element.begin(), element.end(), 0);
    std::shuffle(element.begin(), element.end(), random);
    TetMesh shuffled = mesh;
    Vector moved(q.size());
    for (std::size_t v = 0; v < vertex.size(); ++v) {
      shuffled.vertices.own()[static_cast<std::size_t>(vertex[v])] = mesh.vertices[v];
      moved.segment<3>(3 * vertex[v]) = q.segment<3>(3 * static_cast<Index>(v));
    }
    std::vector<int> shuffled_regions(regions.size());
    for (std::size_t e = 0; e < element.size(); ++e) {
      const auto old = static_cast<std::size_t>(element[e]);
      std::array<Index, 4> nodes = mesh.tetrahedra[old];
      for (Index& v : nodes) v = vertex[static_cast<std::size_t>(v)];
      // An even permutation of its nodes.
      std::rotate(nodes.begin() + 1, nodes.begin() + 1 + static_cast<int>(random() % 3),
                  nodes.end());
      shuffled.tetrahedra.own()[e] = nodes;
      shuffled_regions[e] = regions[old];
    }
    const RestState other_rest(shuffled);
    const ElasticPotential other(other_rest, all_materials(), shuffled_regions);
    const auto [other_energy, other_gradient] = value_and_gradient_of(other, moved);
    EXPECT_NEAR(other_energy, energy, 1e-13 * energy);
    Vector back(q.size());
    for (std::size_t v = 0; v < vertex.size(); ++v) {
      back.segment<3>(3 * static_cast<Index>(v)) = other_gradient.segment<3>(3 * vertex[v]);
    }
    EXPECT_LT((back - gradient).norm(), 1e-13 * reference(potential, q).gradient_scale);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ElementKernelsOfASet, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return instruction_set_name(test.param); });

// AVX2 and AVX-512 round alike, and lanes are added up in the same order.
TEST(InstructionSets, EnergiesOfAvx2AndAvx512AreBitwiseTheSame) {
#if HWY_ARCH_X86
  const std::vector<std::int64_t> sets = instruction_sets();
  if (!std::ranges::count(sets, HWY_AVX3) || !std::ranges::count(sets, HWY_AVX2)) {
    GTEST_SKIP() << "this processor does not have both";
  }
  const TetMesh mesh = small_block({11, 7, 6});
  const RestState rest(mesh);
  for (const MaterialModel& material : all_materials()) {
    const ElasticPotential potential(rest, material);
    for (const Vector& q : {strained_state(potential, mesh.rest_positions(), 0.1),
                            strong_state(mesh.rest_positions(), 0.003)}) {
      double energies[2];
      Vector gradients[2];
      for (int i = 0; i < 2; ++i) {
        const UseInstructionSet use(i == 0 ? HWY_AVX3 : HWY_AVX2);
        ASSERT_TRUE(potential.value_and_gradient(q, energies[i], gradients[i]).ok());
      }
      EXPECT_EQ(energies[0], energies[1]);
      // Elements of one batch that share a vertex may be added in another order.
      EXPECT_LT((gradients[0] - gradients[1]).cwiseAbs().maxCoeff(),
                1e-14 * reference(potential, q).gradient_scale);
      RecordProperty("gradients_bitwise_equal", gradients[0] == gradients[1] ? 1 : 0);
    }
  }
#else
  GTEST_SKIP() << "not an x86 processor";
#endif
}

TEST(ElementBlocks, EveryElementHasOneLaneAndEveryVertexItsRows) {
  for (const Index count : {1, 17, 2477}) {
    const TetMesh mesh = some_elements(count, {9, 8, 6});
    const RestState rest(mesh);
    const std::vector<int> regions = mixed_regions(count);
    const ElementBlocks blocks(rest, regions, 3);
    std::vector<int> seen(static_cast<std::size_t>(count), 0);
    for (Index b = 0; b < blocks.block_count(); ++b) {
      const ElementBlocks::Block& block = blocks.block(b);
      for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count;
           ++batch) {
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          const Index e = blocks.point(batch, lane);
          for (int a = 0; a < 4; ++a) {
            const Index slot = blocks.slot(batch, a, lane);
            ASSERT_LT(slot, ElementBlocks::kRecordSize * block.record_count);
            if (e < 0) continue;
            // The row of the node belongs to its vertex.
            const Index row = block.first_record + slot / ElementBlocks::kRecordSize;
            const Index v = rest.nodes(e)[static_cast<std::size_t>(a)];
            EXPECT_TRUE(std::find(blocks.records_begin(v), blocks.records_end(v),
                                  static_cast<std::int32_t>(row)) != blocks.records_end(v));
          }
          if (e < 0) continue;
          ++seen[static_cast<std::size_t>(e)];
          EXPECT_EQ(block.material, regions[static_cast<std::size_t>(e)]);
        }
      }
    }
    EXPECT_TRUE(std::ranges::all_of(seen, [](int n) { return n == 1; }));
    for (Index v = 0; v < rest.vertex_count(); ++v) {
      EXPECT_TRUE(std::is_sorted(blocks.records_begin(v), blocks.records_end(v)));
    }
  }
}

}  // namespace
}  // namespace tetraction
