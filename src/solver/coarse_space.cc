#include "coarse_space.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "fem/block_stiffness.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume.h"

namespace tetraction {
namespace {

using Block66 = Eigen::Matrix<double, 6, 6>;

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

// The coarse matrix' lower triangle by 6 × 6 blocks, and its factor.
template <class T>
struct CoarseSpace<T>::Factor {
  std::vector<std::vector<std::int32_t>> neighbors;  // of each group: itself and later ones
  Eigen::SparseMatrix<double> matrix;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky;
  Vector right;
  Vector permuted;
  bool analyzed = false;

  void make_pattern() {
    const auto n = static_cast<Index>(neighbors.size());
    matrix.resize(6 * n, 6 * n);
    Eigen::VectorXi sizes(6 * n);
    for (Index g = 0; g < n; ++g) {
      sizes.segment<6>(6 * g).setConstant(
          static_cast<int>(6 * neighbors[static_cast<std::size_t>(g)].size()));
    }
    matrix.reserve(sizes);
    for (Index g = 0; g < n; ++g) {
      for (Index column = 6 * g; column < 6 * g + 6; ++column) {
        for (const std::int32_t h : neighbors[static_cast<std::size_t>(g)]) {
          for (Index row = 6 * h; row < 6 * h + 6; ++row) matrix.insert(row, column) = 0.0;
        }
      }
    }
    matrix.makeCompressed();
  }

  bool has(Index row, Index column) const {
    const auto& rows = neighbors[static_cast<std::size_t>(column)];
    return std::binary_search(rows.begin(), rows.end(), row);
  }

  void add(Index row, Index column, const Block66& block) {
    const auto& rows = neighbors[static_cast<std::size_t>(column)];
    const auto place = std::lower_bound(rows.begin(), rows.end(), row) - rows.begin();
    for (int j = 0; j < 6; ++j) {
      Eigen::Map<Motion>(matrix.valuePtr() + matrix.outerIndexPtr()[6 * column + j] + 6 * place) +=
          block.col(j);
    }
  }
};

template <class T>
CoarseSpace<T>::CoarseSpace(const MechanicalSystem& system, const VertexGroups& groups)
    : system_(system),
      blocks_(BlockAccess::blocks(system.elastic())),
      groups_(groups),
      arms_(static_cast<std::size_t>(4 * system.vertex_count())),
      groups_of_block_(static_cast<std::size_t>(blocks_.block_count())),
      group_of_record_(static_cast<std::size_t>(blocks_.record_count())),
      place_of_record_(static_cast<std::size_t>(blocks_.record_count()), -1),
      factor_(std::make_unique<Factor>()) {
  number_groups();
  find_neighbors();
  factor_->make_pattern();
}

template <class T>
CoarseSpace<T>::~CoarseSpace() = default;

// The groups of the parts follow one another.
template <class T>
void CoarseSpace<T>::number_groups() {
  const MeshPart* part = system_.part();
  Index count = groups_.count();
  if (part != nullptr) {
    numbers_of_parts_ = part->counts_of_parts(6 * count);
    const auto own = numbers_of_parts_.begin() + part->rank();
    first_group_ = std::accumulate(numbers_of_parts_.begin(), own, Index{0}) / 6;
    count = std::accumulate(own, numbers_of_parts_.end(), 6 * first_group_) / 6;
  }
  motions_.resize(static_cast<std::size_t>(count));
  Vector number = Vector::Zero(system_.vertex_count());
  for (Index g = 0; g < groups_.count(); ++g) {
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      number[groups_.vertex(i)] = static_cast<double>(first_group_ + g);
    }
  }
  copy_from_owners(part, number, 1);
  group_of_place_.reserve(groups_.order().size());
  for (const std::int32_t v : groups_.order()) {
    group_of_place_.push_back(static_cast<std::int32_t>(number[v]));
  }
}

// The pairs of all parts, each once and ascending.
template <class T>
std::vector<std::pair<std::int32_t, std::int32_t>> CoarseSpace<T>::all_pairs(
    std::vector<std::pair<std::int32_t, std::int32_t>> own) const {
  if (system_.part() == nullptr) return own;
  std::vector<double> numbers;
  numbers.reserve(2 * own.size());
  for (const auto& [i, j] : own) {
    numbers.push_back(i);
    numbers.push_back(j);
  }
  const std::vector<Index> counts =
      system_.part()->counts_of_parts(static_cast<Index>(numbers.size()));
  std::vector<double> all(
      static_cast<std::size_t>(std::accumulate(counts.begin(), counts.end(), Index{0})));
  system_.part()->gather(numbers.data(), counts, all.data());
  own.clear();
  for (std::size_t i = 0; i < all.size(); i += 2) {
    own.emplace_back(static_cast<std::int32_t>(all[i]), static_cast<std::int32_t>(all[i + 1]));
  }
  std::sort(own.begin(), own.end());
  own.erase(std::unique(own.begin(), own.end()), own.end());
  return own;
}

// Groups are neighbours if an element has vertices of both.
template <class T>
void CoarseSpace<T>::find_neighbors() {
  factor_->neighbors.resize(motions_.size());
  std::vector<std::int32_t> place_of_vertex(groups_.order().size());
  for (std::size_t i = 0; i < place_of_vertex.size(); ++i) {
    place_of_vertex[static_cast<std::size_t>(groups_.order()[i])] = static_cast<std::int32_t>(i);
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
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
  for (std::size_t g = 0; g < motions_.size(); ++g) {
    factor_->neighbors[g].push_back(static_cast<std::int32_t>(g));
  }
  for (const auto& [i, j] : all_pairs(std::move(pairs)))
    factor_->neighbors[static_cast<std::size_t>(i)].push_back(j);
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
      if (i == j || !block.isZero(0.0)) factor_->add(groups[i], groups[j], block);
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
        if (g >= h && factor_->has(g, h)) {
          factor_->add(g, h, outers.sign(number) * motion * other.transpose());
        }
      }
    }
  }
}

template <class T>
bool CoarseSpace<T>::update(const TangentOperator<T>& stiffness, const VertexTerm& vertex_term,
                            const Vector& x, const OuterProducts<T>* outers) {
  set_arms(x);
  Factor& factor = *factor_;
  std::fill_n(factor.matrix.valuePtr(), factor.matrix.nonZeros(), 0.0);
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
    factor.add(first_group_ + g, first_group_ + g, own);
  }
  sum_over_parts(system_.part(), factor.matrix.valuePtr(), factor.matrix.nonZeros());
  for (Index i = 0; i < factor.matrix.cols(); ++i) {
    double& diagonal = factor.matrix.coeffRef(i, i);
    diagonal = diagonal > 0.0 ? (1.0 + kShift) * diagonal : 1.0;
  }
  if (!factor.analyzed) {
    factor.cholesky.analyzePattern(factor.matrix);
    factor.analyzed = true;
  }
  factor.cholesky.factorize(factor.matrix);
  return factor.cholesky.info() == Eigen::Success;
}

template <class T>
double CoarseSpace<T>::solve() {
  Factor& factor = *factor_;
  Eigen::Map<Vector> motions(motions_.front().data(), 6 * group_count());
  if (system_.part() != nullptr) {
    system_.part()->gather(motions.data() + 6 * first_group_, numbers_of_parts_, motions.data());
  }
  factor.right = motions;
  // cholesky.solve() would allocate memory each time.
  factor.permuted.noalias() = factor.cholesky.permutationP() * factor.right;
  factor.cholesky.matrixL().solveInPlace(factor.permuted);
  factor.cholesky.matrixU().solveInPlace(factor.permuted);
  motions = factor.cholesky.permutationPinv() * factor.permuted;
  return factor.right.dot(motions);
}

template class CoarseSpace<float>;
template class CoarseSpace<double>;

}  // namespace tetraction
