#include "tangent_operator.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "block_stiffness.h"
#include "core/decompositions.h"
#include "isotropic_model.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Index of an entry of a symmetric matrix that is stored as xx xy xz yy yz zz.
constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

// The smallest t ≥ 0 such that no eigenvalue of stress + t metric with respect to `metric` is below
// `floor`.
double required_multiple(const Matrix3& stress, const Matrix3& metric, double floor) {
  const Eigen::LLT<Matrix3> root(metric);
  if (root.info() != Eigen::Success) return 0.0;
  Matrix3 scaled = root.matrixL().solve(stress);
  scaled = root.matrixL().solve(scaled.transpose()).eval();
  return std::max(0.0, floor - symmetric_eigen(scaled).values[0]);
}

// The lowest eigenvalue of the quadratic form Σ s_ij (M_i:Z)(M_j:Z) of tensors Z, or 0 if it is
// positive.
double lowest_eigenvalue(const Matrix3& s, const std::array<Matrix3, 3>& m) {
  Eigen::Matrix<double, 9, 3> basis;
  for (int i = 0; i < 3; ++i) basis.col(i) = flatten(m[static_cast<std::size_t>(i)]);
  // With B = (M_i) and BᵀB = RᵀR, the eigenvalues of B s Bᵀ are those of R s Rᵀ and zeros.
  const SymmetricEigen3 gram = symmetric_eigen(Matrix3(basis.transpose() * basis));
  const Matrix3 root =
      gram.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * gram.vectors.transpose();
  return std::min(0.0, symmetric_eigen(Matrix3(root * s * root.transpose())).values[0]);
}

// A bound c of the principal terms and of l (tr Z)²: they are not less than −c |Z|². In the basis of the yᵢ they are
// Σ (2hᵢⱼ cᵢcⱼ + l) ZᵢᵢZⱼⱼ + Σ_{i<j} θᵢⱼ cᵢcⱼ (Zᵢⱼ + Zⱼᵢ)².
template <class Numbers>
double principal_floor(const Numbers& number, double l) {
  Vector3 c;
  for (int i = 0; i < 3; ++i) {
    c[i] = Vector3(number(3 * i), number(3 * i + 1), number(3 * i + 2)).squaredNorm();
  }
  double least = 0.0;
  Matrix3 diagonal;
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, 2.0 * number(18 + i) * c[(i + 1) % 3] * c[(i + 2) % 3]);
    for (int j = 0; j < 3; ++j) diagonal(i, j) = 2.0 * number(21 + kPacked[i][j]) * c[i] * c[j] + l;
  }
  return -std::min(least, symmetric_eigen(diagonal).values[0]);
}

}  // namespace

template <class T>
bool TangentOperator<T>::supports(const ElasticPotential& elastic) {
  return std::all_of(elastic.materials().begin(), elastic.materials().end(),
                     [](const MaterialField& m) { return isotropic_model(m.model()).has_value(); });
}

template <class T>
TangentOperator<T>::TangentOperator(const ElasticPotential& elastic,
                                    std::vector<std::int32_t> order)
    : elastic_(elastic),
      blocks_(BlockAccess::blocks(elastic)),
      order_(std::move(order)),
      begin_(static_cast<std::size_t>(blocks_.block_count()) + 1, 0),
      records_(static_cast<std::size_t>(ElementBlocks::kRecordSize * blocks_.record_count())) {
  if (order_.empty()) return;
  std::vector<std::int32_t> place(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    place[static_cast<std::size_t>(order_[i])] = static_cast<std::int32_t>(i);
  }
  record_place_.resize(static_cast<std::size_t>(blocks_.record_count()));
  for (Index r = 0; r < blocks_.record_count(); ++r) {
    const Index v = blocks_.record_vertex(r);
    record_place_[static_cast<std::size_t>(r)] = v < 0 ? -1 : place[static_cast<std::size_t>(v)];
  }
}

template <class T>
TangentForm TangentOperator<T>::form(const ElementBlocks::Block& block) const {
  const auto model =
      isotropic_model(elastic_.materials()[static_cast<std::size_t>(block.material)].model());
  return tangent_form(*model, viscous_);
}

template <class T>
void TangentOperator<T>::set(const Vector& q, const ViscousPotential* viscous,
                             const Vector& displacement, const double* tensions) {
  viscous_ = viscous != nullptr;
  for (Index b = 0; b < blocks_.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    const auto i = static_cast<std::size_t>(b);
    begin_[i + 1] = begin_[i] + static_cast<std::size_t>(block.batch_count * kBatchLanes *
                                                         tangent_numbers(form(block)));
  }
  state_.resize(begin_.back());
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    thread_local AlignedVector<double> positions;
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      positions.resize(ElementBlocks::local_size(block));
      blocks_.load_records(block, q.data(), positions.data());
      const auto model =
          isotropic_model(elastic_.materials()[static_cast<std::size_t>(block.material)].model());
      T* state = state_.data() + begin_[static_cast<std::size_t>(b)];
      BatchView view = BlockAccess::batches(elastic_, b);
      if (tensions != nullptr) view.tensions = tensions + block.first_batch * kBatchLanes;
      prepare_tangent(view, *model, form(block), positions.data(), state);
      if (viscous_) BlockAccess::add_tangent(*viscous, b, displacement, form(block), state);
    }
  });
}

// Conditions under which the quadratic form of the stiffness (tangent_kernels.h) is positive. With
// Z = w deᵀ the spatial terms are de:(de S) + k Z:Zᵀ + l (tr Z)². Since Z:Zᵀ = 2|sym Z|² − |Z|² and
// |Z|² = de:(de wᵀw), they are positive if S − |k| wᵀw is positive. The metric terms are positive if
// S is. The couplings are a quadratic form of Z with the tensors I, B = FFᵀ and I₁B − B². If its
// lowest eigenvalue is −c, it is not less than −c |Z|².
template <class T>
void TangentOperator<T>::convexify() {
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      const TangentForm kind = form(block);
      T* state = state_.data() + begin_[static_cast<std::size_t>(b)];
      for (Index batch = 0; batch < block.batch_count; ++batch) {
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          if (blocks_.point(block.first_batch + batch, lane) >= 0) convexify(kind, state + lane);
        }
        state += tangent_numbers(kind) * kBatchLanes;
      }
    }
  });
}

template <class T>
void TangentOperator<T>::convexify(TangentForm kind, T* state) {
  const auto number = [&](int i) -> T& { return state[i * kBatchLanes]; };
  const auto symmetric = [&](int first) {
    Matrix3 m;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) m(i, j) = static_cast<double>(number(first + kPacked[i][j]));
    }
    return m;
  };
  Matrix3 metric;
  double floor = 0.0;
  if (!has(kind, TangentForm::kSpatial)) {
    metric = symmetric(tangent_metric_offset(kind) + 9);
  } else {
    Matrix3 w;
    for (int i = 0; i < 9; ++i) w(i % 3, i / 3) = static_cast<double>(number(6 + i));
    metric = w.transpose() * w;
    floor = std::abs(static_cast<double>(number(15)));
    if (has(kind, TangentForm::kCoupled)) {
      const auto columns = [&](int first) {
        Matrix3 m;
        for (int i = 0; i < 9; ++i) m(i % 3, i / 3) = static_cast<double>(number(first + i));
        return m;
      };
      const int at = tangent_coupled_offset(kind);
      const Matrix3 e = w.inverse().transpose();
      std::array<Matrix3, 3> tensors{Matrix3::Identity(), columns(at) * e.transpose(),
                                     Matrix3::Zero()};
      Matrix3 s = Matrix3::Zero();
      s(0, 0) = static_cast<double>(number(16));
      s(1, 1) = static_cast<double>(number(at + 9));
      s(0, 1) = s(1, 0) = static_cast<double>(number(at + 10));
      if (has(kind, TangentForm::kCoupledI2)) {
        tensors[2] = columns(at + 11) * e.transpose();
        s(2, 2) = static_cast<double>(number(at + 20));
        s(1, 2) = s(2, 1) = static_cast<double>(number(at + 21));
        s(0, 2) = s(2, 0) = static_cast<double>(number(at + 22));
      }
      floor -= lowest_eigenvalue(s, tensors);
    }
    if (has(kind, TangentForm::kPrincipal)) {
      floor += principal_floor(
          [&](int i) { return static_cast<double>(number(tangent_principal_offset(kind) + i)); },
          static_cast<double>(number(16)));
    }
  }
  const double added = required_multiple(symmetric(0), metric, floor);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) number(kPacked[i][j]) += static_cast<T>(added * metric(i, j));
  }
}

template <class T>
void TangentOperator<T>::multiply(const T* x) {
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    thread_local AlignedVector<T> local;
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      local.resize(ElementBlocks::local_size(block));
      copy_records(block, x, local.data());
      T* records = records_.data() + ElementBlocks::kRecordSize * block.first_record;
      blocks_.sum_local(block, records, [&](T* result) {
        apply_tangent(blocks_.batches(block), form(block), state(b), local.data(), result);
      });
    }
  });
}

template <class T>
void TangentOperator<T>::element_matrices(Index b, Index batch, double* matrices) const {
  const TangentForm kind = form(blocks_.block(b));
  const auto numbers = static_cast<std::size_t>(tangent_numbers(kind)) * kBatchLanes;
  const T* batch_state = state(b) + static_cast<std::size_t>(batch) * numbers;
  alignas(64) double state_in_double[std::size_t{kMostTangentNumbers} * kBatchLanes];
  std::copy_n(batch_state, numbers, state_in_double);
  tangent_stiffness(kind, state_in_double, matrices);
}

template <class T>
void TangentOperator<T>::add_quadratic_diagonal(Index b, AlignedVector<T>& other) {
  const ElementBlocks::Block& block = blocks_.block(b);
  alignas(64) double matrices[std::size_t{kStiffnessNumbers} * kBatchLanes];
  alignas(64) double diagonal[kDiagonalNumbers * kBatchLanes / QuadraticPoints::kPoints];
  for (Index batch = block.first_batch; batch < block.first_batch + block.batch_count; ++batch) {
    element_matrices(b, batch - block.first_batch, matrices);
    quadratic_diagonal(matrices, diagonal);
    for (int lane = 0; lane < kBatchLanes; lane += QuadraticPoints::kPoints) {
      if (blocks_.point(batch, lane) < 0) continue;
      const double* from = diagonal + kDiagonalNumbers * (lane / QuadraticPoints::kPoints);
      for (int a = 0; a < QuadraticPoints::kNodes; ++a, from += 8) {
        const Index at = ElementBlocks::kRecordSize * blocks_.record_of_node(block, batch, lane, a);
        const auto add = [at](AlignedVector<T>& to, const double* numbers) {
          Eigen::Map<Record>(to.data() + at) +=
              Eigen::Map<const Eigen::Vector4d>(numbers).cast<T>();
        };
        add(records_, from);
        add(other, from + 4);
      }
    }
  }
}

template <class T>
void TangentOperator<T>::diagonal(AlignedVector<T>& on, AlignedVector<T>& off) {
  AlignedVector<T> other(records_.size());
  std::fill(records_.begin(), records_.end(), T(0));
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      if (blocks_.is_quadratic()) {
        add_quadratic_diagonal(b, other);
        continue;
      }
      const auto first = ElementBlocks::kRecordSize * block.first_record;
      add_tangent_diagonal(blocks_.batches(block), form(block), state(b), records_.data() + first,
                           other.data() + first);
    }
  });
  const Index n = elastic_.rest().vertex_count();
  on.resize(static_cast<std::size_t>(ElementBlocks::kRecordSize * n));
  off.resize(on.size());
  parallel_for(n, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Eigen::Map<Record>(on.data() + ElementBlocks::kRecordSize * i) = sum(records_, i);
      Eigen::Map<Record>(off.data() + ElementBlocks::kRecordSize * i) = sum(other, i);
    }
  });
}

template <class T>
bool TangentOperator<T>::step_is_safe(const T* x) const {
  std::atomic<bool> safe{true};
  parallel_for(blocks_.block_count(), 1, [&](Index begin, Index end) {
    thread_local AlignedVector<T> local;
    for (Index b = begin; b < end; ++b) {
      const ElementBlocks::Block& block = blocks_.block(b);
      if (!has(form(block), TangentForm::kSpatial)) continue;  // the law is defined for any J
      local.resize(ElementBlocks::local_size(block));
      copy_records(block, x, local.data());
      if (!tangent_step_is_safe(blocks_.batches(block), form(block), state(b), local.data())) {
        safe = false;
      }
    }
  });
  return safe;
}

template class TangentOperator<float>;
template class TangentOperator<double>;

}  // namespace tetraction
