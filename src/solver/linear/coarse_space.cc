#include "coarse_space.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "fem/block_stiffness.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

using Block66 = CoarseMatrix::Block;

// This part of the coarse matrix's diagonal is added to it. It is needed because the six motions of
// a group are not independent if its free vertices lie on a line or if there are only one or two.
constexpr double kShift = 1e-7;

// The number of element blocks whose sums are in memory at the same time. It exceeds the number of
// threads and bounds the memory.
constexpr Index kTogether = 32;

// A node of an element: its group among those of the block, its vertex's place and arm.
struct Node {
  std::size_t group = 0;
  Index place = 0;
  Vector3 arm = Vector3::Zero();
};

// sum += QₐᵀK Q_b with Q = [1, −[a]ₓ] of two nodes; K row by row with a stride of kBatchLanes.
void add_product(const double* k, const Vector3& arm_a, const Vector3& arm_b, Block66& sum) {
  Eigen::Matrix<double, 3, 6> y;  // K Q_b
  for (int i = 0; i < 3; ++i) {
    const double x0 = k[(3 * i) * kBatchLanes];
    const double x1 = k[(3 * i + 1) * kBatchLanes];
    const double x2 = k[(3 * i + 2) * kBatchLanes];
    y(i, 0) = x0;
    y(i, 1) = x1;
    y(i, 2) = x2;
    y(i, 3) = x2 * arm_b[1] - x1 * arm_b[2];
    y(i, 4) = x0 * arm_b[2] - x2 * arm_b[0];
    y(i, 5) = x1 * arm_b[0] - x0 * arm_b[1];
  }
  for (int j = 0; j < 6; ++j) {
    sum.col(j).head<3>() += y.col(j);
    sum(3, j) += arm_a[1] * y(2, j) - arm_a[2] * y(1, j);
    sum(4, j) += arm_a[2] * y(0, j) - arm_a[0] * y(2, j);
    sum(5, j) += arm_a[0] * y(1, j) - arm_a[1] * y(0, j);
  }
}

}  // namespace

template <class T>
CoarseSpace<T>::CoarseSpace(const MechanicalSystem& system, const VertexGroups& groups)
    : system_(system),
      blocks_(BlockAccess::blocks(system.elastic())),
      groups_(groups),
      arms_(static_cast<std::size_t>(4 * system.vertex_count())),
      groups_of_block_(static_cast<std::size_t>(blocks_.block_count())),
      group_of_record_(static_cast<std::size_t>(blocks_.record_count())),
      place_of_record_(static_cast<std::size_t>(blocks_.record_count()), -1) {
  const std::vector<std::int32_t> interface_numbers = number_groups();
  motions_.assign(interface_numbers.size(), Motion::Zero());
  matrix_ = std::make_unique<CoarseMatrix>(system.part(), groups_.count(), interface_numbers,
                                           find_neighbors());
}

// Sets the groups of places. Those of other parts, of which this part has copies of vertices, follow the own
// ones. Returns the numbers of the groups in the interface, −1 for inner ones (CoarseMatrix).
template <class T>
std::vector<std::int32_t> CoarseSpace<T>::number_groups() {
  std::vector<std::int32_t> interface_numbers(static_cast<std::size_t>(groups_.count()), -1);
  group_of_place_.resize(groups_.order().size());
  for (Index g = 0; g < groups_.count(); ++g) {
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      group_of_place_[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(g);
    }
  }
  const MeshPart* part = system_.part();
  if (part == nullptr) return interface_numbers;

  const auto is_shared = [&](std::int32_t v) {
    return std::binary_search(part->shared_vertices.begin(), part->shared_vertices.end(), v);
  };
  std::vector<Index> shared_groups;
  for (Index g = 0; g < groups_.count(); ++g) {
    const auto vertices = groups_.order().begin();
    if (std::any_of(vertices + groups_.begin(g), vertices + groups_.end(g), is_shared)) {
      shared_groups.push_back(g);
    }
  }
  // The interface has the groups of one part after those of another.
  const std::vector<Index> counts = part->counts_of_parts(static_cast<Index>(shared_groups.size()));
  auto next = static_cast<std::int32_t>(
      std::accumulate(counts.begin(), counts.begin() + part->rank(), Index{0}));
  Vector number = Vector::Zero(system_.vertex_count());
  for (const Index g : shared_groups) {
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) number[groups_.vertex(i)] = next;
    interface_numbers[static_cast<std::size_t>(g)] = next++;
  }
  copy_from_owners(part, number, 1);
  std::map<std::int32_t, std::int32_t> of_others;  // groups by their numbers in the interface
  for (Index i = system_.owned_vertex_count(); i < system_.vertex_count(); ++i) {
    const auto [found, is_new] =
        of_others.try_emplace(static_cast<std::int32_t>(number[groups_.vertex(i)]),
                              static_cast<std::int32_t>(interface_numbers.size()));
    if (is_new) interface_numbers.push_back(found->first);
    group_of_place_[static_cast<std::size_t>(i)] = found->second;
  }
  return interface_numbers;
}

// Groups are neighbours if an element has vertices of both. Returns the pairs of neighbours. The loops over elements
// get what they need to know of their groups.
template <class T>
std::vector<CoarseMatrix::GroupPair> CoarseSpace<T>::find_neighbors() {
  std::vector<std::int32_t> place_of_vertex(groups_.order().size());
  for (std::size_t i = 0; i < place_of_vertex.size(); ++i) {
    place_of_vertex[static_cast<std::size_t>(groups_.order()[i])] = static_cast<std::int32_t>(i);
  }
  std::vector<CoarseMatrix::GroupPair> pairs;
  std::vector<std::int32_t> groups;  // of the nodes of an element
  for (Index b = 0; b < blocks_.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    auto& own = groups_of_block_[static_cast<std::size_t>(b)];
    for (Index r = block.first_record; r < block.first_record + block.record_count; ++r) {
      if (const Index v = blocks_.record_vertex(r); v >= 0) {
        const std::int32_t place = place_of_vertex[static_cast<std::size_t>(v)];
        place_of_record_[static_cast<std::size_t>(r)] = place;
        own.push_back(group_of_place_[static_cast<std::size_t>(place)]);
      }
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    for (Index r = block.first_record; r < block.first_record + block.record_count; ++r) {
      const std::int32_t place = place_of_record_[static_cast<std::size_t>(r)];
      if (place < 0) continue;
      const std::int32_t group = group_of_place_[static_cast<std::size_t>(place)];
      const auto which = std::lower_bound(own.begin(), own.end(), group) - own.begin();
      group_of_record_[static_cast<std::size_t>(r)] = static_cast<std::uint16_t>(which);
    }
    for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
      for (int lane = 0; lane < kBatchLanes; lane += blocks_.points_per_element()) {
        if (blocks_.point(batch, lane) < 0) continue;
        groups.clear();
        for (int a = 0; a < blocks_.nodes_per_element(); ++a) {
          const Index row = blocks_.record_of_node(block, batch, lane, a);
          groups.push_back(own[group_of_record_[static_cast<std::size_t>(row)]]);
        }
        for (const std::int32_t i : groups) {
          for (const std::int32_t j : groups) {
            if (i < j) pairs.emplace_back(i, j);
          }
        }
      }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  }
  // The outer products of nodal volumes couple all vertices of the elements at a vertex.
  if (const NodalVolume* volume = system_.nodal_volume(); volume != nullptr) {
    std::vector<std::int32_t> own;
    for (Index p = 0; p < volume->patch_count(); ++p) {
      own.clear();
      for (const Index v : volume->patch_vertices(p)) {
        const std::int32_t place = place_of_vertex[static_cast<std::size_t>(v)];
        own.push_back(group_of_place_[static_cast<std::size_t>(place)]);
      }
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      for (std::size_t i = 0; i < own.size(); ++i) {
        for (std::size_t j = i + 1; j < own.size(); ++j) pairs.emplace_back(own[i], own[j]);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  }
  return pairs;
}

template <class T>
void CoarseSpace<T>::set_arms(const Vector& x) {
  const FreeCoordinates& coordinates = system_.coordinates();
  parallel_for(groups_.count(), 8, [&](Index begin, Index end) {
    for (Index g = begin; g < end; ++g) {
      Vector3 center = Vector3::Zero();
      for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
        center += vertex_block(x, groups_.vertex(i));
      }
      center /= static_cast<double>(groups_.end(g) - groups_.begin(g));
      double radius = 0.0;
      for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
        radius = std::max(radius, (vertex_block(x, groups_.vertex(i)) - center).norm());
      }
      const double scale = radius > 0.0 ? 1.0 / radius : 0.0;
      for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
        const Index v = groups_.vertex(i);
        const bool held = coordinates.is_fully_prescribed(v);
        const Vector3 arm = (held ? 0.0 : scale) * (vertex_block(x, v) - center);
        Eigen::Map<Record, Eigen::Aligned16>(arms_.data() + 4 * i) =
            Eigen::Vector4d(arm[0], arm[1], arm[2], held ? 0.0 : 1.0).cast<T>();
      }
    }
  });
  if (system_.part() == nullptr) return;
  Vector arms = Vector::Zero(4 * system_.vertex_count());
  const auto count = static_cast<Index>(group_of_place_.size());
  for (Index i = 0; i < system_.owned_vertex_count(); ++i) {
    arms.segment<4>(4 * groups_.vertex(i)) = arm(i).template cast<double>();
  }
  copy_from_owners(system_.part(), arms, 4);
  for (Index i = 0; i < count; ++i) {
    Eigen::Map<Record, Eigen::Aligned16>(arms_.data() + 4 * i) =
        arms.segment<4>(4 * groups_.vertex(i)).cast<T>();
  }
}

// u = basis (t, ω) of the vertex at a place.
template <class T>
Eigen::Matrix<double, 3, 6> CoarseSpace<T>::basis(Index place) const {
  const Record a = arm(place);
  Eigen::Matrix<double, 3, 6> q = Eigen::Matrix<double, 3, 6>::Zero();
  if (a[3] == T(0)) return q;
  q.leftCols<3>().setIdentity();
  for (int k = 0; k < 3; ++k) {
    q.col(3 + k) = Vector3::Unit(k).cross(Vector3(a.template head<3>().template cast<double>()));
  }
  const FreeCoordinates& coordinates = system_.coordinates();
  if (const Index v = groups_.vertex(place); !coordinates.is_free(v)) {
    const auto t = coordinates.map(v).columns;
    q = (t * (t.transpose() * q)).eval();
  }
  return q;
}

// The sum of PᵀK_eP over a block's elements. Every pair of the block's groups has a 6 × 6 block;
// only the lower triangle is stored.
template <class T>
void CoarseSpace<T>::add_block(const TangentOperator<T>& stiffness, Index b,
                               std::vector<double>& sums) const {
  const ElementBlocks::Block& block = blocks_.block(b);
  const std::size_t count = groups_of_block_[static_cast<std::size_t>(b)].size();
  sums.assign(36 * count * count, 0.0);
  const FreeCoordinates& coordinates = system_.coordinates();
  // Adds a 6 × 6 block to the lower triangle of the sums, and within one group to both triangles.
  const auto add = [&](const Node& a, const Node& c, bool same, const Block66& product) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return Eigen::Map<Block66>(sums.data() + 36 * (row * count + column));
    };
    if (a.group > c.group) {
      at(a.group, c.group) += product;
    } else {
      at(c.group, a.group) += product.transpose();
      if (!same && a.group == c.group) at(a.group, c.group) += product;
    }
  };
  // The matrix of two nodes, row by row with a stride.
  using Entries = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>, 0,
                             Eigen::Stride<3 * kBatchLanes, kBatchLanes>>;
  alignas(64) double matrices[kStiffnessNumbers * kBatchLanes];
  std::array<Node, QuadraticPoints::kNodes> nodes;
  for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
    stiffness.element_matrices(b, batch - block.first_batch, matrices);
    for (int lane = 0; lane < kBatchLanes; lane += blocks_.points_per_element()) {
      if (blocks_.point(batch, lane) < 0) continue;
      bool all_free = true;
      for (int a = 0; a < blocks_.nodes_per_element(); ++a) {
        const Index row = blocks_.record_of_node(block, batch, lane, a);
        Node& node = nodes[static_cast<std::size_t>(a)];
        node.group = group_of_record_[static_cast<std::size_t>(row)];
        node.place = place_of_record_[static_cast<std::size_t>(row)];
        node.arm = arm(node.place).template head<3>().template cast<double>();
        all_free = all_free && coordinates.is_free(blocks_.record_vertex(row));
      }
      if (blocks_.is_quadratic()) {
        const ElementMatrix matrix = quadratic_stiffness(matrices, lane);
        for (Index a = 0; a < QuadraticPoints::kNodes; ++a) {
          const Node& first = nodes[static_cast<std::size_t>(a)];
          const Eigen::Matrix<double, 6, 3> left = basis(first.place).transpose();
          for (Index c = a; c < QuadraticPoints::kNodes; ++c) {
            const Node& second = nodes[static_cast<std::size_t>(c)];
            add(first, second, a == c,
                left * matrix.template block<3, 3>(3 * a, 3 * c) * basis(second.place));
          }
        }
        continue;
      }
      const double* k = matrices + lane;
      int pair = 0;
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t c = a; c < 4; ++c) {
          double own[9 * kBatchLanes];  // one block
          const double* entries = own;
          if (a == c) {
            constexpr int kPlace[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
            for (int i = 0; i < 9; ++i) {
              own[i * kBatchLanes] = k[(6 * static_cast<int>(a) + kPlace[i]) * kBatchLanes];
            }
          } else {
            entries = k + (24 + 9 * pair++) * kBatchLanes;
          }
          Block66 product = Block66::Zero();
          if (all_free) {
            add_product(entries, nodes[a].arm, nodes[c].arm, product);
          } else {
            product = basis(nodes[a].place).transpose() * Entries(entries) * basis(nodes[c].place);
          }
          add(nodes[a], nodes[c], a == c, product);
        }
      }
    }
  }
}

template <class T>
void CoarseSpace<T>::flush(Index b, const std::vector<double>& sums) {
  const auto& groups = groups_of_block_[static_cast<std::size_t>(b)];
  const std::size_t count = groups.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const Eigen::Map<const Block66> block(sums.data() + 36 * (i * count + j));
      if (i == j || !block.isZero(0.0)) matrix_->add(groups[i], groups[j], block);
    }
  }
}

// Pᵀv vᵀP σ of all outer products σ v vᵀ.
template <class T>
void CoarseSpace<T>::add_outers(const OuterProducts<T>& outers) {
  std::vector<std::pair<Index, Motion>> own;  // Pᵀv of each group
  for (Index number = 0; number < outers.count(); ++number) {
    own.clear();
    outers.for_each(number, [&](Index place, const auto& vector) {
      const Index group = group_of_place_[static_cast<std::size_t>(place)];
      auto found = std::find_if(own.begin(), own.end(),
                                [&](const auto& entry) { return entry.first == group; });
      if (found == own.end()) found = own.insert(own.end(), {group, Motion::Zero()});
      found->second += basis(place).transpose() * vector.template head<3>().template cast<double>();
    });
    for (const auto& [g, motion] : own) {
      for (const auto& [h, other] : own) {
        if (g >= h && matrix_->has(g, h)) {
          matrix_->add(g, h, outers.sign(number) * motion * other.transpose());
        }
      }
    }
  }
}

template <class T>
bool CoarseSpace<T>::update(const TangentOperator<T>& stiffness, const VertexTerm& vertex_term,
                            const Vector& x, const OuterProducts<T>* outers) {
  set_arms(x);
  matrix_->set_zero();
  std::vector<std::vector<double>> sums(
      static_cast<std::size_t>(std::min(kTogether, blocks_.block_count())));
  for (Index first = 0; first < blocks_.block_count(); first += kTogether) {
    const Index count = std::min(kTogether, blocks_.block_count() - first);
    parallel_for(count, 1, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        add_block(stiffness, first + i, sums[static_cast<std::size_t>(i)]);
      }
    });
    for (Index i = 0; i < count; ++i) flush(first + i, sums[static_cast<std::size_t>(i)]);
  }
  if (outers != nullptr) add_outers(*outers);
  for (Index g = 0; g < groups_.count(); ++g) {
    Block66 own = Block66::Zero();
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      const Eigen::Matrix<double, 3, 6> q = basis(i);
      own += q.transpose() * vertex_term(i) * q;
    }
    matrix_->add(g, g, own);
  }
  return matrix_->factorize(kShift);
}

template class CoarseSpace<float>;
template class CoarseSpace<double>;

}  // namespace tetraction
