#include "tetraction/dynamics/nodal_volume.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <tuple>
#include <utility>
#include <variant>

#include "fem/element_blocks.h"
#include "fem/kernels/volume_kernels.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/volume_rule.h"

namespace tetraction {
namespace {

using NodeMatrix = RestState::Shape::NodeMatrix;
constexpr int kNodes = RestState::Shape::kNodes;
constexpr Index kGrain = 512;

// The volumetric part of a material: its modulus, and whether it is that of the logarithm.
struct VolumetricLaw {
  double modulus = 0.0;  // λ or κ, Pa
  VolumetricPart part = VolumetricPart::kQuadratic;
};

template <class M>
VolumetricLaw volumetric_law(const M& material) {
  if constexpr (std::same_as<M, NeoHookean> || std::same_as<M, MooneyRivlin>) {
    return {material.lambda(), material.volumetric()};
  } else if constexpr (std::same_as<M, Yeoh>) {
    return {material.kappa(), VolumetricPart::kQuadratic};
  } else {
    throw InputError(
        "mesh.volume = \"nodal\" needs a material whose energy has a volumetric part U(J): "
        "neo-hookean, mooney-rivlin or yeoh. That of Saint Venant–Kirchhoff (stvk) and of a "
        "program's own material has none. Take one of the three, or mesh.volume = \"element\".");
  }
}

template <class M>
IsotropicModel without_volume(const M& m) {
  if constexpr (std::same_as<M, NeoHookean>) {
    return NeoHookean(m.mu(), 0.0, m.volumetric());
  } else if constexpr (std::same_as<M, MooneyRivlin>) {
    return MooneyRivlin(m.mu1(), m.mu2(), 0.0, m.volumetric());
  } else if constexpr (std::same_as<M, Yeoh>) {
    return Yeoh(m.c10(), m.c20(), m.c30(), 0.0);
  } else {
    volumetric_law(m);  // throws
    throw InputError("");
  }
}

// U of a vertex, with x = J − 1.
struct NodalLaw {
  double modulus = 0.0;
  bool logarithmic = false;

  double energy(double x) const {
    const double y = logarithmic ? std::log1p(x) : x;
    return 0.5 * modulus * y * y;
  }
  double first(double x) const {
    return logarithmic ? modulus * std::log1p(x) / (1.0 + x) : modulus * x;
  }
  // Both of them with one logarithm.
  double energy_and_first(double x, double& derivative) const {
    const double y = logarithmic ? std::log1p(x) : x;
    derivative = modulus * (logarithmic ? y / (1.0 + x) : y);
    return 0.5 * modulus * y * y;
  }
  double second(double x) const {
    const double j = 1.0 + x;
    return logarithmic ? modulus * (1.0 - std::log1p(x)) / (j * j) : modulus;
  }
  // (U(J + d) − U(J))/d for J = 1 + x, without cancellation.
  double secant(double x, double d) const {
    if (!logarithmic) return modulus * (x + 0.5 * d);
    const double j = 1.0 + x;
    const double r = d / j;
    const double change = std::log1p(r);  // of ln J
    return modulus * (std::log1p(x) + 0.5 * change) * (r == 0.0 ? 1.0 : change / r) / j;
  }
  // Nearly the derivative of the secant with respect to d, for Newton's method.
  double secant_derivative(double x, double d) const { return 0.5 * second(x + 2.0 / 3.0 * d); }
};

Matrix3 cofactors(const Matrix3& a) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) {
    c.col(k) = Vector3(a.col((k + 1) % 3)).cross(Vector3(a.col((k + 2) % 3)));
  }
  return c;
}

// The derivative of the cofactors of a in the direction b.
Matrix3 cofactor_derivative(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    c.col(k) =
        Vector3(a.col(i)).cross(Vector3(b.col(j))) + Vector3(b.col(i)).cross(Vector3(a.col(j)));
  }
  return c;
}

// One element in a step from F − D to F + D. The change of J is G:ΔC exactly, with
//
//     G = [cof C̄ + cof(ΔC)/12]/(J_k + J_{k+1}),   C̄ = (C_k + C_{k+1})/2,   ΔC = C_{k+1} − C_k,
//
// because det C = J² is cubic in C and its cofactors are quadratic.
struct VolumeStep {
  Matrix3 middle;         // F
  Matrix3 end;            // F + D
  Matrix3 mean_metric;    // C̄
  Matrix3 metric_change;  // ΔC
  Matrix3 g;              // G
  double start_ratio;     // J_k
  double sum;             // J_k + J_{k+1}

  VolumeStep(const Matrix3& f, const Matrix3& d) : middle(f), end(f + d) {
    const Matrix3 start = f - d;
    start_ratio = start.determinant();
    sum = start_ratio + end.determinant();
    const Matrix3 product = f.transpose() * d;
    metric_change = 2.0 * (product + product.transpose());
    mean_metric = f.transpose() * f + d.transpose() * d;
    g = (cofactors(mean_metric) + cofactors(metric_change) / 12.0) / sum;
  }
  // J_{k+1} − J_k.
  double change() const { return g.cwiseProduct(metric_change).sum(); }
  // The first Piola–Kirchhoff stress of a unit tension.
  Matrix3 stress() const { return 2.0 * middle * g; }
  // The change of J_{k+1} where F changes by h and the start stays.
  double end_change(const Matrix3& h) const { return 2.0 * cofactors(end).cwiseProduct(h).sum(); }
  // The change of stress() then.
  Matrix3 stress_change(const Matrix3& h) const {
    const Matrix3 product = end.transpose() * h;
    const Matrix3 mean = product + product.transpose();  // of C̄; twice that of ΔC/2
    const Matrix3 change =
        (cofactor_derivative(mean_metric, mean) +
         cofactor_derivative(metric_change, 2.0 * mean) / 12.0 - end_change(h) * g) /
        sum;
    return 2.0 * (h * g + middle * change);
  }
};

// ∂(6v)/∂x of the nodes at these positions.
NodeMatrix six_volume_gradient(const NodeMatrix& x) {
  const Vector3 a = x.col(1) - x.col(0);
  const Vector3 b = x.col(2) - x.col(0);
  const Vector3 c = x.col(3) - x.col(0);
  NodeMatrix gradient;
  gradient.col(1) = b.cross(c);
  gradient.col(2) = c.cross(a);
  gradient.col(3) = a.cross(b);
  gradient.col(0) = -(gradient.col(1) + gradient.col(2) + gradient.col(3));
  return gradient;
}

// The position of vertex k minus that of vertex l.
Vector3 difference(const Positions& x, Index k, Index l) {
  const auto of = [&](const Vector& field) -> Vector3 {
    return field.segment<3>(3 * k) - field.segment<3>(3 * l);
  };
  if (x.displacement() == nullptr) return of(x.origin());
  return of(x.origin()) + of(*x.displacement());
}

double six_volume(const NodeMatrix& x) {
  return Vector3(x.col(1) - x.col(0))
      .dot(Vector3(x.col(2) - x.col(0)).cross(Vector3(x.col(3) - x.col(0))));
}

Matrix3 cross_matrix(const Vector3& a) {
  Matrix3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

// The pairs of nodes i, j of a tetrahedron, and the nodes k, l with ∂²(6v)/∂x_i∂x_j = [x_k − x_l]×.
struct NodePair {
  int i, j, k, l;
};
constexpr std::array<NodePair, 6> kNodePairs{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

}  // namespace

const char* to_string(VolumeRule rule) {
  return rule == VolumeRule::kNodal ? "nodal" : "element";
}

// A patch is the tetrahedra of one material at one vertex. Elements have the numbers of their lanes
// in the blocks (fem/element_blocks.h).
struct NodalVolume::Impl {
  const ElasticPotential& elastic;
  const RestState& rest;
  const ElementBlocks& blocks;
  std::vector<MaterialField> materials;

  std::vector<Index> lane_element;  // −1 for padding
  std::vector<std::int32_t> element_lane;
  std::vector<std::array<std::int32_t, 4>> lane_patches;  // of the nodes; −1 for padding
  std::vector<Index> patch_vertex;
  std::vector<int> patch_material;
  std::vector<std::size_t> patch_begin;
  std::vector<std::int32_t> patch_lanes;
  AlignedVector<double> rest_volumes;  // 6V of every lane
  Vector patch_rest;                   // Σ 6V
  std::vector<NodalLaw> law;           // of every patch
  ElasticPotential::StiffnessSums stiffness;

  // What the Hessian needs; made when it is first asked for.
  std::vector<std::size_t> row_begin;  // of every patch
  std::vector<Index> row_vertices;
  std::vector<std::array<std::uint16_t, 4>> row_places;  // of the nodes, for each of patch_lanes
  struct EdgePart {
    std::int32_t lane;
    std::int32_t k, l;  // vertices
  };
  std::vector<std::pair<Index, Index>> edges;
  std::vector<std::size_t> edge_begin;
  std::vector<EdgePart> edge_parts;

  // Work space.
  AlignedVector<double> volumes;  // 6v of every lane, and later a factor of every lane
  AlignedVector<double> records;
  Vector ratio_change;  // J_a − 1 of every patch
  Vector tension;       // of every patch
  Vector energies;      // of every patch
  std::vector<Vector3> row_vectors;
  std::vector<NodeMatrix> volume_gradients;  // ∂(6v)/∂x of every lane

  Impl(const ElasticPotential& in_elements, const std::vector<MaterialField>& whole)
      : elastic(in_elements),
        rest(in_elements.rest()),
        blocks(BlockAccess::blocks(in_elements)),
        materials(whole) {
    list_patches();
    const Vector positions = rest_positions();
    rest_volumes.resize(lane_element.size());
    find_volumes(positions, rest_volumes);
    patch_rest.resize(patch_count());
    for_patches([&](Index p) {
      double sum = 0.0;
      for_lanes(p, [&](std::int32_t lane) { sum += rest_volumes[std::size_t(lane)]; });
      patch_rest[p] = sum;
    });
    ratio_change.resize(patch_count());
    tension.resize(patch_count());
    energies.resize(patch_count());
    law.resize(patch_vertex.size());
    for (std::size_t m = 0; m < materials.size(); ++m) take_material(m);
    sum_stiffness();
  }

  Index patch_count() const { return static_cast<Index>(patch_vertex.size()); }

  Vector rest_positions() const {
    Vector positions(3 * rest.vertex_count());
    for (Index v = 0; v < rest.vertex_count(); ++v) vertex_block(positions, v) = rest.position(v);
    return positions;
  }

  void list_patches() {
    lane_element.assign(static_cast<std::size_t>(blocks.batch_count() * kBatchLanes), -1);
    element_lane.resize(static_cast<std::size_t>(rest.element_count()));
    for (Index b = 0; b < blocks.block_count(); ++b) {
      blocks.for_each_point(blocks.block(b), [&](Index e, Index batch, int lane) {
        const Index number = batch * kBatchLanes + lane;
        lane_element[static_cast<std::size_t>(number)] = e;
        element_lane[static_cast<std::size_t>(e)] = static_cast<std::int32_t>(number);
      });
    }
    // (vertex, material, element) of all nodes in ascending order.
    struct Node {
      Index vertex;
      int material;
      Index element;
      int node;
      auto operator<=>(const Node&) const = default;
    };
    std::vector<Node> nodes;
    nodes.reserve(static_cast<std::size_t>(kNodes * rest.element_count()));
    for (Index e = 0; e < rest.element_count(); ++e) {
      const auto own = rest.nodes(e);
      for (int a = 0; a < kNodes; ++a) {
        nodes.push_back({own[static_cast<std::size_t>(a)], elastic.material_index(e), e, a});
      }
    }
    std::sort(nodes.begin(), nodes.end());
    lane_patches.assign(lane_element.size(), {-1, -1, -1, -1});
    for (const Node& node : nodes) {
      if (patch_vertex.empty() || patch_vertex.back() != node.vertex ||
          patch_material.back() != node.material) {
        patch_vertex.push_back(node.vertex);
        patch_material.push_back(node.material);
        patch_begin.push_back(patch_lanes.size());
      }
      const std::int32_t lane = element_lane[static_cast<std::size_t>(node.element)];
      patch_lanes.push_back(lane);
      lane_patches[static_cast<std::size_t>(lane)][static_cast<std::size_t>(node.node)] =
          static_cast<std::int32_t>(patch_vertex.size()) - 1;
    }
    patch_begin.push_back(patch_lanes.size());
  }

  // body(p) for all patches.
  template <class Body>
  void for_patches(const Body& body) const {
    parallel_for(patch_count(), kGrain, [&](Index begin, Index end) {
      for (Index p = begin; p < end; ++p) body(p);
    });
  }
  // body(lane) for the elements of a patch.
  template <class Body>
  void for_lanes(Index p, const Body& body) const {
    const auto i = static_cast<std::size_t>(p);
    for (std::size_t k = patch_begin[i]; k < patch_begin[i + 1]; ++k) body(patch_lanes[k]);
  }
  // body(e, lane) for all elements.
  template <class Body>
  void for_elements(const Body& body) const {
    parallel_for(rest.element_count(), kGrain, [&](Index begin, Index end) {
      for (Index e = begin; e < end; ++e) {
        body(e, static_cast<std::size_t>(element_lane[static_cast<std::size_t>(e)]));
      }
    });
  }

  // The modulus of element e.
  double modulus(Index e) const {
    const MaterialField& material = materials[static_cast<std::size_t>(elastic.material_index(e))];
    return std::visit(
        [&](const auto& m) {
          return material.with_element(m, e,
                                       [](const auto& own) { return volumetric_law(own).modulus; });
        },
        material.model());
  }

  void take_material(std::size_t m) {
    const MaterialField& material = materials[m];
    const VolumetricLaw own =
        std::visit([](const auto& model) { return volumetric_law(model); }, material.model());
    for_patches([&](Index p) {
      const auto i = static_cast<std::size_t>(p);
      if (patch_material[i] != static_cast<int>(m)) return;
      law[i] = {own.modulus, own.part == VolumetricPart::kLogarithmic};
      if (!material.varies()) return;
      double sum = 0.0;
      for_lanes(p, [&](std::int32_t lane) {
        const auto k = static_cast<std::size_t>(lane);
        sum += rest_volumes[k] * modulus(lane_element[k]);
      });
      law[i].modulus = sum / patch_rest[p];
    });
  }

  void sum_stiffness() {
    stiffness = {};
    for (Index e = 0; e < rest.element_count(); ++e) {
      const auto element = rest.point(e);
      const auto nodes = rest.nodes(e);
      double longest = 0.0;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (std::size_t c = 0; c < a; ++c) {
          longest =
              std::max(longest, (rest.position(nodes[a]) - rest.position(nodes[c])).squaredNorm());
        }
      }
      const double k = modulus(e) * element.weights[0] * element.gradients[0].squaredNorm();
      stiffness.squared += k * k;
      stiffness.with_edges += k * k * longest;
    }
  }

  // body(b, positions, displacements) for all blocks with the records of x; displacements may be null.
  template <class Body>
  void for_blocks(const Positions& x, const Body& body) const {
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      thread_local AlignedVector<double> positions;
      thread_local AlignedVector<double> displacements;
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        const auto size = static_cast<std::size_t>(ElementBlocks::kRecordSize * block.record_count);
        positions.resize(size);
        blocks.load_records(block, x.origin().data(), positions.data());
        const double* second = nullptr;
        if (x.displacement() != nullptr) {
          displacements.resize(size);
          blocks.load_displacements(block, x.displacement()->data(), displacements.data());
          second = displacements.data();
        }
        body(block, positions.data(), second);
      }
    });
  }

  void find_volumes(const Positions& x, AlignedVector<double>& result) const {
    result.resize(lane_element.size());
    for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                      const double* displacements) {
      element_volumes(blocks.batches(block), positions, displacements,
                      result.data() + block.first_batch * kBatchLanes);
    });
  }

  void find_volume_gradients(const Positions& x) {
    volume_gradients.resize(lane_element.size());
    for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                      const double* displacements) {
      blocks.for_each_point(block, [&](Index, Index batch, int lane) {
        NodeMatrix nodes;
        for (int a = 0; a < kNodes; ++a) {
          const Index slot = blocks.slot(batch, a, lane);
          nodes.col(a) = Eigen::Map<const Vector3>(positions + slot);
          if (a > 0) nodes.col(a) -= nodes.col(0);
        }
        nodes.col(0).setZero();
        if (displacements != nullptr) {
          const Eigen::Map<const Vector3> origin(displacements + blocks.slot(batch, 0, lane));
          for (int a = 1; a < kNodes; ++a) {
            nodes.col(a) +=
                Eigen::Map<const Vector3>(displacements + blocks.slot(batch, a, lane)) - origin;
          }
        }
        volume_gradients[static_cast<std::size_t>(batch * kBatchLanes + lane)] =
            six_volume_gradient(nodes);
      });
    });
  }

  // Sets ratio_change at x and calls body(p, J_p − 1) for all patches.
  template <class Body>
  void evaluate(const Positions& x, const Body& body) {
    find_volumes(x, volumes);
    for_patches([&](Index p) {
      // The sum is that of patch_rest, so that the change is exactly zero at rest.
      double sum = 0.0;
      for_lanes(p, [&](std::int32_t lane) { sum += volumes[static_cast<std::size_t>(lane)]; });
      ratio_change[p] = (sum - patch_rest[p]) / patch_rest[p];
      body(p, ratio_change[p]);
    });
  }

  // Sets the energies of all patches at x, and `volumes` to the mean of U' over the nodes of every lane.
  void find_tensions(const Positions& x) {
    evaluate(x, [&](Index p, double change) {
      energies[p] = weight(p) * law_of(p).energy_and_first(change, tension[p]);
    });
    set_lane_means();
  }

  // volumes ← the mean of `tension` over the nodes of every lane.
  void set_lane_means() {
    parallel_for(static_cast<Index>(volumes.size()), kBatchLanes * kGrain,
                 [&](Index begin, Index end) {
                   for (Index lane = begin; lane < end; ++lane) {
                     const auto k = static_cast<std::size_t>(lane);
                     volumes[k] = mean(tension, k);
                   }
                 });
  }

  // W of a patch is its share of the rest volume times U.
  double weight(Index p) const { return patch_rest[p] / 24.0; }
  const NodalLaw& law_of(Index p) const { return law[static_cast<std::size_t>(p)]; }
  double sum_energies() const {
    double sum = 0.0;
    for (Index p = 0; p < patch_count(); ++p) sum += energies[p];
    return sum;
  }

  // The mean of a field of patches over the nodes of a lane.
  double mean(const Vector& field, std::size_t lane) const {
    const auto& p = lane_patches[lane];
    return p[0] < 0 ? 0.0 : 0.25 * (field[p[0]] + field[p[1]] + field[p[2]] + field[p[3]]);
  }

  // Adds force(e, lane), the forces of the nodes of every element, to a field.
  template <class Force>
  void add_forces(Vector& field, const Force& force) {
    records.assign(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks.record_count()),
                   0.0);
    parallel_for(blocks.block_count(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b) {
        const ElementBlocks::Block& block = blocks.block(b);
        double* own = records.data() + ElementBlocks::kRecordSize * block.first_record;
        blocks.for_each_point(block, [&](Index e, Index batch, int lane) {
          const NodeMatrix f = force(e, static_cast<std::size_t>(batch * kBatchLanes + lane));
          for (int a = 0; a < kNodes; ++a) {
            Eigen::Map<Vector3>(own + blocks.slot(batch, a, lane)) += f.col(a);
          }
        });
      }
    });
    blocks.add_record_sums(records, field);
  }

  VolumeStep step_of(const RestElement<RestState::Shape>& element, Index e, const Positions& x,
                     const Vector& way) const {
    return {deformation_gradient(element, 0, rest.gather_relative(x, e)),
            deformation_gradient(element, 0, rest.gather_relative(way, e))};
  }

  // Sets the secant of U in every patch to `tension`, and for a direction its change to `energies`.
  void find_secants(const Positions& x, const Vector& way, const Vector* direction) {
    const std::size_t lanes = lane_element.size();
    volumes.resize(3 * lanes);  // V times J_k, its change, and the change of J_{k+1}
    for_elements([&](Index e, std::size_t lane) {
      const auto element = rest.point(e);
      const VolumeStep step = step_of(element, e, x, way);
      const double v = element.weights[0];
      volumes[lane] = v * (step.start_ratio - 1.0);
      volumes[lanes + lane] = v * step.change();
      if (direction == nullptr) return;
      const Matrix3 h = deformation_gradient(element, 0, rest.gather_relative(*direction, e));
      volumes[2 * lanes + lane] = v * step.end_change(h);
    });
    for_patches([&](Index p) {
      double start = 0.0;
      double change = 0.0;
      double turned = 0.0;
      for_lanes(p, [&](std::int32_t lane) {
        const auto k = static_cast<std::size_t>(lane);
        start += volumes[k];
        change += volumes[lanes + k];
        if (direction != nullptr) turned += volumes[2 * lanes + k];
      });
      const double scale = 6.0 / patch_rest[p];
      const NodalLaw& u = law_of(p);
      tension[p] = u.secant(scale * start, scale * change);
      energies[p] = u.secant_derivative(scale * start, scale * change) * scale * turned;
    });
  }

  void make_rows() {
    if (!row_begin.empty()) return;
    row_begin.push_back(0);
    row_places.resize(patch_lanes.size());
    std::vector<Index> own;
    for (Index p = 0; p < patch_count(); ++p) {
      own.clear();
      for_lanes(p, [&](std::int32_t lane) {
        for (const Index v : rest.nodes(lane_element[static_cast<std::size_t>(lane)])) {
          own.push_back(v);
        }
      });
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      const auto i = static_cast<std::size_t>(p);
      for (std::size_t k = patch_begin[i]; k < patch_begin[i + 1]; ++k) {
        const auto nodes = rest.nodes(lane_element[static_cast<std::size_t>(patch_lanes[k])]);
        for (std::size_t a = 0; a < 4; ++a) {
          row_places[k][a] = static_cast<std::uint16_t>(
              std::lower_bound(own.begin(), own.end(), nodes[a]) - own.begin());
        }
      }
      row_vertices.insert(row_vertices.end(), own.begin(), own.end());
      row_begin.push_back(row_vertices.size());
    }
    row_vectors.resize(row_vertices.size());
  }

  void make_edges() {
    if (!edge_begin.empty()) return;
    struct Part {
      Index i, j;
      EdgePart part;
    };
    std::vector<Part> parts;
    parts.reserve(6 * static_cast<std::size_t>(rest.element_count()));
    for (Index e = 0; e < rest.element_count(); ++e) {
      const auto nodes = rest.nodes(e);
      for (const NodePair& pair : kNodePairs) {
        Index i = nodes[static_cast<std::size_t>(pair.i)];
        Index j = nodes[static_cast<std::size_t>(pair.j)];
        auto k = static_cast<std::int32_t>(nodes[static_cast<std::size_t>(pair.k)]);
        auto l = static_cast<std::int32_t>(nodes[static_cast<std::size_t>(pair.l)]);
        if (i > j) {  // the block of (j, i) is the transpose, which has the other sign
          std::swap(i, j);
          std::swap(k, l);
        }
        parts.push_back({i, j, {element_lane[static_cast<std::size_t>(e)], k, l}});
      }
    }
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
      return std::tie(a.i, a.j, a.part.lane) < std::tie(b.i, b.j, b.part.lane);
    });
    for (const Part& part : parts) {
      if (edges.empty() || edges.back() != std::pair{part.i, part.j}) {
        edges.emplace_back(part.i, part.j);
        edge_begin.push_back(edge_parts.size());
      }
      edge_parts.push_back(part.part);
    }
    edge_begin.push_back(edge_parts.size());
  }
};

NodalVolume::NodalVolume(const ElasticPotential& elastic,
                         const std::vector<MaterialField>& materials)
    : impl_(std::make_unique<Impl>(elastic, materials)) {}
NodalVolume::~NodalVolume() = default;

MaterialField NodalVolume::without_volumetric_part(const MaterialField& material) {
  return std::visit(
      [&](const auto& model) -> MaterialField {
        const IsotropicModel reduced = without_volume(model);
        if (!material.varies()) {
          return std::visit([](const auto& m) { return MaterialField(m); }, reduced);
        }
        std::vector<IsotropicModel> elements;
        elements.reserve(static_cast<std::size_t>(material.parameters().cols()));
        for (Index e = 0; e < material.parameters().cols(); ++e) {
          material.with_element(model, e,
                                [&](const auto& own) { elements.push_back(without_volume(own)); });
        }
        return MaterialField(elements);
      },
      material.model());
}

void NodalVolume::set_material(std::size_t index, const MaterialField& material) {
  without_volumetric_part(material);  // throws before anything has changed
  impl_->materials.at(index) = material;
  impl_->take_material(index);
  impl_->sum_stiffness();
}

double NodalVolume::energy(const Positions& x) const {
  Impl& s = *impl_;
  s.evaluate(
      x, [&](Index p, double change) { s.energies[p] = s.weight(p) * s.law_of(p).energy(change); });
  return s.sum_energies();
}

double NodalVolume::add_gradient(const Positions& x, Vector& gradient) const {
  Impl& s = *impl_;
  s.find_tensions(x);
  s.records.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * s.blocks.record_count()));
  s.for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                      const double* displacements) {
    double* own = s.records.data() + ElementBlocks::kRecordSize * block.first_record;
    std::fill_n(own, ElementBlocks::kRecordSize * block.record_count, 0.0);
    BatchView view = s.blocks.batches(block);
    view.tensions = s.volumes.data() + block.first_batch * kBatchLanes;
    add_volume_gradient(view, positions, displacements, own);
  });
  s.blocks.add_record_sums(s.records, gradient);
  return s.sum_energies();
}

EvaluationStatus NodalVolume::elastic_energy_and_gradient(const Positions& x, double& energy,
                                                          Vector& gradient) const {
  Impl& s = *impl_;
  s.find_tensions(x);
  const EvaluationStatus status =
      BlockAccess::value_and_gradient(s.elastic, x, s.volumes, energy, gradient);
  if (status.ok()) energy += s.sum_energies();
  return status;
}

// With R = Σ V_e of a patch and b = Σ ∂v_e/∂x, ∂J/∂x = b/R and the gradient is Σ U' b/4. Its
// derivative is Σ U'' b bᵀ/(4R) + Σ_e (mean of U' over the nodes of e) ∂²v_e/∂x².
void NodalVolume::add_hessian(const Positions& x, HessianForm form, HessianBlocks& hessian) const {
  Impl& s = *impl_;
  s.make_rows();
  s.evaluate(x, [&](Index p, double change) { s.tension[p] = s.law_of(p).first(change); });
  s.find_volume_gradients(x);
  s.for_patches([&](Index p) {
    const auto i = static_cast<std::size_t>(p);
    const auto first = s.row_vectors.begin() + static_cast<std::ptrdiff_t>(s.row_begin[i]);
    std::fill(first, s.row_vectors.begin() + static_cast<std::ptrdiff_t>(s.row_begin[i + 1]),
              Vector3::Zero());
    for (std::size_t k = s.patch_begin[i]; k < s.patch_begin[i + 1]; ++k) {
      const NodeMatrix& gradient = s.volume_gradients[static_cast<std::size_t>(s.patch_lanes[k])];
      for (int a = 0; a < kNodes; ++a) {
        first[s.row_places[k][static_cast<std::size_t>(a)]] += gradient.col(a);
      }
    }
  });
  for (Index p = 0; p < s.patch_count(); ++p) {
    const auto i = static_cast<std::size_t>(p);
    double curvature = s.law_of(p).second(s.ratio_change[p]);
    if (form == HessianForm::kConvex) curvature = std::max(0.0, curvature);
    const std::size_t size = s.row_begin[i + 1] - s.row_begin[i];
    // The vectors are those of 6v, and patch_rest is 6R.
    hessian.add_outer(curvature / (24.0 * s.patch_rest[p]),
                      std::span(s.row_vertices).subspan(s.row_begin[i], size),
                      std::span<const Vector3>(s.row_vectors).subspan(s.row_begin[i], size));
  }
  if (form == HessianForm::kConvex) return;
  s.make_edges();
  s.set_lane_means();
  std::vector<Vector3> arms(s.edges.size());
  parallel_for(static_cast<Index>(s.edges.size()), kGrain, [&](Index begin, Index end) {
    for (Index edge = begin; edge < end; ++edge) {
      const auto i = static_cast<std::size_t>(edge);
      Vector3 arm = Vector3::Zero();
      for (std::size_t k = s.edge_begin[i]; k < s.edge_begin[i + 1]; ++k) {
        const Impl::EdgePart& part = s.edge_parts[k];
        arm += s.volumes[static_cast<std::size_t>(part.lane)] * difference(x, part.k, part.l);
      }
      arms[i] = arm / 6.0;
    }
  });
  for (std::size_t i = 0; i < arms.size(); ++i) {
    hessian.add_pair(s.edges[i].first, s.edges[i].second, cross_matrix(arms[i]));
  }
}

void NodalVolume::add_discrete_gradient(const Positions& x, const Vector& way,
                                        Vector& gradient) const {
  Impl& s = *impl_;
  s.find_secants(x, way, nullptr);
  s.add_forces(gradient, [&](Index e, std::size_t lane) -> NodeMatrix {
    const auto element = s.rest.point(e);
    const VolumeStep step = s.step_of(element, e, x, way);
    return element.weights[0] * s.mean(s.tension, lane) * step.stress() * element.gradients[0];
  });
}

void NodalVolume::add_discrete_gradient_product(const Positions& x, const Vector& way,
                                                const Vector& d, Vector& product) const {
  Impl& s = *impl_;
  s.find_secants(x, way, &d);
  s.add_forces(product, [&](Index e, std::size_t lane) -> NodeMatrix {
    const auto element = s.rest.point(e);
    const VolumeStep step = s.step_of(element, e, x, way);
    const Matrix3 h = deformation_gradient(element, 0, s.rest.gather_relative(d, e));
    const Matrix3 change =
        s.mean(s.energies, lane) * step.stress() + s.mean(s.tension, lane) * step.stress_change(h);
    return element.weights[0] * change * element.gradients[0];
  });
}

Vector NodalVolume::energies_by_material(const Vector& q) const {
  const Impl& s = *impl_;
  energy(q);
  Vector sums = Vector::Zero(static_cast<Index>(s.materials.size()));
  for (Index p = 0; p < s.patch_count(); ++p) {
    sums[s.patch_material[static_cast<std::size_t>(p)]] += s.energies[p];
  }
  return sums;
}

void NodalVolume::add_energy_densities(const Vector& q, Vector& densities) const {
  Impl& s = *impl_;
  s.evaluate(q, [&](Index p, double change) { s.energies[p] = s.law_of(p).energy(change); });
  s.for_elements([&](Index e, std::size_t lane) { densities[e] += s.mean(s.energies, lane); });
}

double NodalVolume::mean_tension(Index e, const Vector& q) const {
  const Impl& s = *impl_;
  double sum = 0.0;
  const auto lane = static_cast<std::size_t>(s.element_lane[static_cast<std::size_t>(e)]);
  for (const std::int32_t p : s.lane_patches[lane]) {
    double change = 0.0;
    s.for_lanes(p, [&](std::int32_t other) {
      const auto k = static_cast<std::size_t>(other);
      change += six_volume(s.rest.gather(q, s.lane_element[k])) - s.rest_volumes[k];
    });
    sum += s.law_of(p).first(change / s.patch_rest[p]);
  }
  return 0.25 * sum;
}

Vector NodalVolume::ratios(const Vector& q) const {
  Impl& s = *impl_;
  s.evaluate(q, [](Index, double) {});
  Vector change = Vector::Zero(s.rest.vertex_count());
  Vector volume = Vector::Zero(s.rest.vertex_count());
  for (Index p = 0; p < s.patch_count(); ++p) {
    const Index v = s.patch_vertex[static_cast<std::size_t>(p)];
    change[v] += s.patch_rest[p] * s.ratio_change[p];
    volume[v] += s.patch_rest[p];
  }
  return Vector::Ones(change.size()) + change.cwiseQuotient(volume);
}

Vector NodalVolume::pressures(const Vector& q) const {
  Impl& s = *impl_;
  s.evaluate(q, [&](Index p, double change) { s.tension[p] = s.law_of(p).first(change); });
  Vector sum = Vector::Zero(s.rest.vertex_count());
  Vector volume = Vector::Zero(s.rest.vertex_count());
  for (Index p = 0; p < s.patch_count(); ++p) {
    const Index v = s.patch_vertex[static_cast<std::size_t>(p)];
    sum[v] -= s.patch_rest[p] * s.tension[p];
    volume[v] += s.patch_rest[p];
  }
  return sum.cwiseQuotient(volume);
}

ElasticPotential::StiffnessSums NodalVolume::stiffness_sums() const {
  return impl_->stiffness;
}

Index NodalVolume::patch_count() const {
  return impl_->patch_count();
}

std::span<const Index> NodalVolume::patch_vertices(Index patch) const {
  impl_->make_rows();
  const auto i = static_cast<std::size_t>(patch);
  return std::span(impl_->row_vertices)
      .subspan(impl_->row_begin[i], impl_->row_begin[i + 1] - impl_->row_begin[i]);
}

}  // namespace tetraction
