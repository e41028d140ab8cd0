#include "matrix_free_cg.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/pseudo_random.h"
#include "fem/allowed_directions.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

// The part of the last solve's residual in a system, relative to the residual asked for, …
constexpr double kSeedIfOwn = 0.25;
constexpr double kSeedIfGiven = 0.1;  // … and with a preconditioner that the caller has given

template <class T>
Eigen::Matrix<T, 4, 1> record_of(const Vector3& x) {
  return Eigen::Vector4d(x[0], x[1], x[2], 0.0).template cast<T>();
}

// The record of the part of x along the directions in which the vertex may move. Residuals are projected in order
// to remove reactions, which may be so large that the rest would be mere round-off.
template <class T>
Eigen::Matrix<T, 4, 1> allowed_record(const FreeCoordinates& coordinates, Index v,
                                      const Vector3& x) {
  return record_of<T>(coordinates.is_free(v) ? x : project(coordinates.map(v), x));
}

}  // namespace

template <class T>
bool MatrixFreeCg<T>::supports(const MechanicalSystem& system) {
  return system.coordinates().sets().empty() && TangentOperator<T>::supports(system.elastic());
}

template <class T>
MatrixFreeCg<T>::MatrixFreeCg(const MechanicalSystem& system)
    : system_(system),
      groups_(system.rest(), system.part()),
      operator_(system.elastic(), groups_.order()),
      terms_(system, groups_),
      shared_(system, groups_) {
  constexpr Index kVertices = 1024;  // worth a task
  const Index groups = groups_.count_with_copies();
  grain_ = std::max<Index>(1, kVertices * groups / system.vertex_count());
  sums_.resize(static_cast<std::size_t>(groups));
  for (Index g = 0; g < groups; ++g) {
    bool free = true;
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      free = free && system.coordinates().is_free(groups_.vertex(i));
    }
    all_free_.push_back(free);
  }
  const auto size = static_cast<std::size_t>(4 * system.vertex_count());
  for (AlignedVector<T>* field : {&x_, &r_, &p_, &z_, &ap_}) field->resize(size);
  inverse_.resize(3 * size);
  Vector seed = pseudo_random(system.dof_count());
  copy_from_owners(system.part(), seed, 3);
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    record(r_, i) = allowed_record<T>(system.coordinates(), v, vertex_block(seed, v));
  });
  last_ = sum_over_parts(system.part(), seed.head(3 * system.owned_vertex_count()).squaredNorm());
}

template <class T>
void MatrixFreeCg<T>::set(const MinimizationProblem& problem, const Vector& u) {
  problem_ = &problem;
  has_blocks_ = false;
  u_ = u;
  const MinimizationProblem::HessianParts parts = problem.hessian_parts(u);
  point_ = parts.positions.origin() + u;
  const double* tensions =
      parts.volume == nullptr ? nullptr : parts.volume->tensions(parts.positions).data();
  operator_.set(point_, parts.viscous, parts.step_displacement, tensions);
  terms_.set(problem, u, HessianForm::kExact);
}

template <class T>
void MatrixFreeCg<T>::convexify() {
  has_blocks_ = false;
  const MinimizationProblem::HessianParts parts = problem_->hessian_parts(u_);
  // The curvature of volumes is indefinite. Without it the other part of nodal volumes is convex.
  if (parts.volume != nullptr) operator_.set(point_, parts.viscous, parts.step_displacement);
  operator_.convexify();
  if (problem_->has_general_terms() || parts.volume != nullptr) {
    terms_.set(*problem_, u_, HessianForm::kConvex);
  }
}

template <class T>
NegativeCurvature MatrixFreeCg<T>::negative_curvature() const {
  NegativeCurvature found;
  found.curvature = curvature_;
  copy(p_, found.direction);
  return found;
}

template <class T>
double MatrixFreeCg<T>::curvature(const Vector& d) {
  const double scale = largest_of_parts(system_.part(), d.lpNorm<Eigen::Infinity>());
  if (!(scale > 0.0)) return 0.0;
  for_places(
      [&](Index i) { record(p_, i) = record_of<T>(vertex_block(d, groups_.vertex(i)) / scale); });
  return multiply() * scale * scale;
}

// vector ← field, 3 per vertex, along the directions in which the vertices may move.
template <class T>
void MatrixFreeCg<T>::copy(const AlignedVector<T>& field, Vector& vector) const {
  const FreeCoordinates& coordinates = system_.coordinates();
  vector.resize(3 * system_.vertex_count());
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    Vector3 own = record(field, i).template head<3>().template cast<double>();
    if (!coordinates.is_free(v)) own = project(coordinates.map(v), own);
    vertex_block(vector, v) = own;
  });
}

template <class T>
void MatrixFreeCg<T>::make_blocks() {
  has_blocks_ = true;
  const Vector& diagonal = problem_->hessian_parts(u_).diagonal;
  operator_.diagonal(p_, z_);
  for (AlignedVector<T>* field : {&p_, &z_}) {
    shared_.add([&](Index i) { return record(*field, i); });
    for (const Index i : shared_.places()) record(*field, i) = shared_.template sum<T>(i);
  }
  const FreeCoordinates& coordinates = system_.coordinates();
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    Eigen::Matrix<double, 4, 3> inverse = Eigen::Matrix<double, 4, 3>::Zero();
    if (!coordinates.is_fully_prescribed(v)) {
      Eigen::Vector4d on = (record(p_, i) + terms_.diagonal(i)).template cast<double>();
      Eigen::Vector4d off = record(z_, i).template cast<double>();
      if (terms_.has_off_diagonal()) off += terms_.off_diagonal(i).template cast<double>();
      Matrix3 block;
      block << on[0], off[0], off[1], off[0], on[1], off[2], off[1], off[2], on[2];
      if (!terms_.outers().empty()) block += terms_.outers().block(i);
      if (coordinates.is_free(v)) {
        Matrix3 inverted = block.inverse();
        // The blocks of an indefinite matrix need not be positive definite.
        const bool positive = block(0, 0) > 0.0 &&
                              block(0, 0) * block(1, 1) > block(0, 1) * block(0, 1) &&
                              block.determinant() > 0.0;
        if (!positive) {
          inverted = vertex_block(diagonal, v).cwiseInverse().asDiagonal();
        }
        inverse.topRows<3>() = inverted;
      } else {
        inverse.topRows<3>() = inverse_along(coordinates.map(v), block, diagonal[3 * v]);
      }
    }
    Eigen::Map<Eigen::Matrix<T, 4, 3>>(inverse_.data() + 12 * i) = inverse.template cast<T>();
  });
}

// Makes or renews the coarse space. Its matrix contains the vertices' own blocks, too.
template <class T>
bool MatrixFreeCg<T>::make_coarse_space() {
  if (!coarse_) coarse_ = std::make_unique<CoarseSpace<T>>(system_, groups_);
  return coarse_->update(
      operator_, [&](Index i) { return terms_.block(i); }, point_, &terms_.outers());
}

// body(g) for all groups.
template <class T>
template <class Body>
void MatrixFreeCg<T>::for_groups(const Body& body) const {
  parallel_for(groups_.count_with_copies(), grain_, [&](Index begin, Index end) {
    for (Index g = begin; g < end; ++g) body(g);
  });
}

// body(i) for the places of all vertices.
template <class T>
template <class Body>
void MatrixFreeCg<T>::for_places(const Body& body) const {
  for_groups([&](Index g) {
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) body(i);
  });
}

// Σ body(g) in the order of the groups: the same for any number of threads. Copies of vertices do not count.
template <class T>
template <class Body>
auto MatrixFreeCg<T>::sum_over_groups(const Body& body) -> Products {
  for_groups([&](Index g) { sums_[static_cast<std::size_t>(g)] = body(g); });
  Products total;
  for (Index g = 0; g < groups_.count(); ++g) {
    total.rz += sums_[static_cast<std::size_t>(g)].rz;
    total.rr += sums_[static_cast<std::size_t>(g)].rr;
  }
  if (system_.part() == nullptr) return total;
  std::array<double, 2> sums{total.rz, total.rr};
  system_.part()->sum(sums.data(), 2);
  return {sums[0], sums[1]};
}

// The part of a record along the directions in which the vertex may move.
template <class T>
auto MatrixFreeCg<T>::allowed(const Record& x, Index place) const -> Record {
  const FreeCoordinates& coordinates = system_.coordinates();
  const Index v = groups_.vertex(place);
  if (coordinates.is_free(v)) return x;
  return allowed_record<T>(coordinates, v, x.template head<3>().template cast<double>());
}

// Sets x = 0 and r = −gradient/scale plus a part of the last solve's residual, of the size `share`.
// The scale makes single precision sufficient in any units.
template <class T>
void MatrixFreeCg<T>::start(const Vector& gradient, double scale, double share) {
  const FreeCoordinates& coordinates = system_.coordinates();
  const T kept =
      last_ > 0.0 && std::isfinite(last_) ? static_cast<T>(share / std::sqrt(last_)) : T(0);
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    record(x_, i).setZero();
    record(ap_, i).setZero();
    record(p_, i).setZero();
    const Record own = allowed_record<T>(coordinates, v, vertex_block(gradient, v) / -scale);
    record(r_, i) = kept > T(0) ? Record(own + kept * record(r_, i)) : own;
  });
  descend(0.0);
}

// Makes or renews the coarse space if it now saves more time than it costs.
template <class T>
bool MatrixFreeCg<T>::renew(const CgReport& report) {
  if (has_given_preconditioner() || !choice_.should_make(report.iterations)) return false;
  known_digits_ = 0.5 * std::log10(report.first_square / report.last_square);
  known_iterations_ = report.iterations;
  choice_.made(make_coarse_space(), report.iterations, known_digits_);
  descend(0.0);
  return true;
}

// ap = A p; returns p·A p.
template <class T>
double MatrixFreeCg<T>::multiply() {
  operator_.multiply(p_.data());
  if (system_.part() != nullptr) shared_.add([&](Index i) { return operator_.record_sum(i); });
  terms_.multiply(p_);
  const Products products = sum_over_groups([&](Index g) {
    const bool all_free = all_free_[static_cast<std::size_t>(g)];
    const bool has_shared = shared_.are_in_group(g);
    Record sum = Record::Zero();
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      const Record p = record(p_, i);
      Record ap = has_shared && shared_.contains(i) ? shared_.template sum<T>(i)
                                                    : Record(operator_.record_sum(i));
      terms_.add_product(p_, i, ap);
      if (!all_free) ap = allowed(ap, i);
      record(ap_, i) = ap;
      sum += p.cwiseProduct(ap);
    }
    return Products{sum.template cast<double>().sum(), 0.0};
  });
  return products.rz;
}

// r −= alpha ap; z = the vertices' part of the preconditioned r. Also computes Pᵀr, from which the
// motions of the groups follow.
template <class T>
void MatrixFreeCg<T>::descend(double step) {
  const T alpha = static_cast<T>(step);
  const bool given = has_given_preconditioner();
  const bool coarse = !given && choice_.in_use();
  products_ = sum_over_groups([&](Index g) {
    const bool is_own = g < groups_.count();
    Record own = Record::Zero();
    Record square = Record::Zero();
    Record force = Record::Zero();
    std::array<Record, 3> moment{Record::Zero(), Record::Zero(), Record::Zero()};  // Σ a rᵀ
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      const Record r = record(r_, i) - alpha * record(ap_, i);
      record(r_, i) = r;
      square += r.cwiseProduct(r);
      if (given) continue;
      const T* m = inverse_.data() + 12 * i;
      const Record z = Eigen::Map<const Record, Eigen::Aligned16>(m) * r[0] +
                       Eigen::Map<const Record, Eigen::Aligned16>(m + 4) * r[1] +
                       Eigen::Map<const Record, Eigen::Aligned16>(m + 8) * r[2];
      record(z_, i) = z;
      own += r.cwiseProduct(z);
      if (coarse && is_own) {
        const Record arm = coarse_->arm(i);
        force += r;
        moment[0] += arm[0] * r;
        moment[1] += arm[1] * r;
        moment[2] += arm[2] * r;
      }
    }
    if (coarse && is_own) {
      coarse_->motion(g) =
          Eigen::Matrix<T, 6, 1>(force[0], force[1], force[2], moment[1][2] - moment[2][1],
                                 moment[2][0] - moment[0][2], moment[0][1] - moment[1][0])
              .template cast<double>();
    }
    return Products{own.template cast<double>().sum(), square.template cast<double>().sum()};
  });
}

// Computes the coarse part of the preconditioned r, as motions of the groups.
template <class T>
double MatrixFreeCg<T>::precondition() {
  if (factor_ != nullptr) return precondition_with_factor();
  if (body_preconditioner_ != nullptr) return precondition_body();
  return choice_.in_use() ? products_.rz + coarse_->solve() : products_.rz;
}

// z = value(i) at all places i; returns r·z.
template <class T>
template <class Value>
double MatrixFreeCg<T>::set_preconditioned(const Value& value) {
  return sum_over_groups([&](Index g) {
           Record sum = Record::Zero();
           for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
             const Record z = value(i);
             record(z_, i) = z;
             sum += record(r_, i).cwiseProduct(z);
           }
           return Products{sum.template cast<double>().sum(), 0.0};
         })
      .rz;
}

// z = (L Lᵀ)⁻¹ r over the free coordinates; returns r·z.
template <class T>
double MatrixFreeCg<T>::precondition_with_factor() {
  using Vector3T = Eigen::Matrix<T, 3, 1>;
  const FreeCoordinates& coordinates = system_.coordinates();
  free_.resize(coordinates.count());
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    const Record padded = record(r_, i);
    const Vector3T r(padded[0], padded[1], padded[2]);
    if (coordinates.is_free(v)) {
      free_.template segment<3>(coordinates.first(v)) = r;
    } else {
      const FreeCoordinates::VertexMap map = coordinates.map(v);
      for (int k = 0; k < map.count; ++k) {
        free_[map.first + k] = map.columns.col(k).template cast<T>().dot(r);
      }
    }
  });
  factor_->solve(free_, free_);
  return set_preconditioned([&](Index i) {
    const Index v = groups_.vertex(i);
    Vector3T z = Vector3T::Zero();
    if (coordinates.is_free(v)) {
      z = free_.template segment<3>(coordinates.first(v));
    } else {
      const FreeCoordinates::VertexMap map = coordinates.map(v);
      for (int k = 0; k < map.count; ++k) {
        z += free_[map.first + k] * map.columns.col(k).template cast<T>();
      }
    }
    return Record(z[0], z[1], z[2], T(0));
  });
}

// z = M⁻¹ r with the preconditioner of a body in parts; returns r·z.
template <class T>
double MatrixFreeCg<T>::precondition_body() {
  residual_.resize(system_.dof_count());
  for_places([&](Index i) {
    vertex_block(residual_, groups_.vertex(i)) =
        record(r_, i).template head<3>().template cast<double>();
  });
  body_preconditioner_->apply(residual_, preconditioned_);
  return set_preconditioned([&](Index i) {
    return allowed(record_of<T>(vertex_block(preconditioned_, groups_.vertex(i))), i);
  });
}

// x += alpha p; p = z + beta p, z with the motions of the groups.
template <class T>
void MatrixFreeCg<T>::turn(double step_length, double share) {
  const T alpha = static_cast<T>(step_length);
  const T beta = static_cast<T>(share);
  for_groups([&](Index g) {
    const auto step = [&](Index i, const Record& z) {
      const Record p = record(p_, i);
      record(x_, i) += alpha * p;
      record(p_, i) = z + beta * p;
    };
    if (has_given_preconditioner() || !choice_.in_use()) {
      for (Index i = groups_.begin(g); i < groups_.end(g); ++i) step(i, record(z_, i));
      return;
    }
    const bool is_own = g < groups_.count();
    const bool all_free = all_free_[static_cast<std::size_t>(g)];
    RigidMotion motion(is_own ? coarse_->motion(g) : CoarseMotion::Zero());
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      if (!is_own) motion = RigidMotion(coarse_->motion_of(i));
      Record u = motion.of(coarse_->arm(i));
      if (!all_free) u = allowed(u, i);
      step(i, record(z_, i) + u);
    }
  });
}

// x += alpha p.
template <class T>
void MatrixFreeCg<T>::finish(double alpha) {
  for_places([&](Index i) { record(x_, i) += static_cast<T>(alpha) * record(p_, i); });
}

template <class T>
CgReport MatrixFreeCg<T>::run(const Vector& gradient, double forcing, int max_iterations,
                              Vector& step) {
  const bool given = has_given_preconditioner();
  if (!given && !has_blocks_) make_blocks();
  const double scale = system_.restricted_norm(gradient);
  if (!(scale > 0.0)) {
    step.setZero(3 * system_.vertex_count());
    CgReport report;
    report.converged = true;
    return report;
  }
  known_iterations_ = 0;
  known_digits_ = 0.0;
  start(gradient, scale, (given ? kSeedIfGiven : kSeedIfOwn) * forcing);
  const CgReport report = conjugate_gradients(*this, forcing, max_iterations);
  if (report.negative_curvature) curvature_ = report.curvature;
  last_ = report.last_square;
  if (report.converged && !given) {
    choice_.solved(report.iterations - known_iterations_,
                   0.5 * std::log10(report.first_square / report.last_square) - known_digits_);
  }
  for_places([&](Index i) { record(x_, i) *= static_cast<T>(scale); });
  copy(x_, step);
  return report;
}

template class MatrixFreeCg<float>;
template class MatrixFreeCg<double>;

}  // namespace tetraction
