#include "matrix_free_cg.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/pseudo_random.h"
#include "fem/allowed_directions.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

// What comes from the last solve, as a part of the residual asked for, …
constexpr double kSeed = 0.25;
constexpr double kSeedIfGiven = 0.1;  // … and with a preconditioner that the caller has given

// The part of x along the directions in which the vertex may move. Residuals are projected in order
// to remove reactions, which may be so large that the rest would be mere round-off.
Vector3 project(const FreeCoordinates& coordinates, Index v, const Vector3& x) {
  const FreeCoordinates::VertexMap map = coordinates.map(v);
  Vector3 projected = Vector3::Zero();
  for (int i = 0; i < map.count; ++i) {
    projected += map.columns.col(i).dot(x) * map.columns.col(i);
  }
  return projected;
}

// t (tᵀ B t)⁻¹ tᵀ with the directions t in which a vertex may move. It is the inverse of P B P +
// c (1 − P), P = t tᵀ, less (1 − P)/c. If tᵀ B t is not positive definite, it is P/`substitute`.
Matrix3 inverse_along(const FreeCoordinates::VertexMap& map, const Matrix3& block,
                      double substitute) {
  const Matrix3 allowed = allowed_directions(map);
  const Matrix3 across = Matrix3::Identity() - allowed;
  const Matrix3 own = allowed * block * allowed;
  // There are one or two directions, so trace and determinant of tᵀ B t decide.
  const double scale = own.trace() / map.count;
  const Matrix3 filled = own + scale * across;
  if (!(scale > 0.0) || !(filled.determinant() > 0.0)) return allowed / substitute;
  return filled.inverse() - across / scale;
}

template <class T>
Eigen::Matrix<T, 4, 1> project(const FreeCoordinates& coordinates, Index v,
                               const Eigen::Matrix<T, 4, 1>& x) {
  const Vector3 projected =
      project(coordinates, v, Vector3(x.template head<3>().template cast<double>()));
  return Eigen::Vector4d(projected[0], projected[1], projected[2], 0.0).template cast<T>();
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
      outers_(groups_, system.nodal_volume()) {
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
  for (AlignedVector<T>* field : {&diagonal_, &x_, &r_, &p_, &z_, &ap_}) field->resize(size);
  inverse_.resize(3 * size);
  list_shared_places();
  Vector seed = pseudo_random(system.dof_count());
  copy_from_owners(system.part(), seed, 3);
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    Vector3 own = vertex_block(seed, v);
    if (!system.coordinates().is_free(v)) own = project(system.coordinates(), v, own);
    record(r_, i) = Eigen::Vector4d(own[0], own[1], own[2], 0.0).template cast<T>();
  });
  last_ = sum_over_parts(system.part(), seed.head(3 * system.owned_vertex_count()).squaredNorm());
}

template <class T>
void MatrixFreeCg<T>::list_shared_places() {
  const MeshPart* part = system_.part();
  if (part == nullptr) return;
  has_shared_.assign(static_cast<std::size_t>(groups_.count_with_copies()), false);
  shared_sums_.setZero(system_.dof_count());
  for (Index g = 0; g < groups_.count_with_copies(); ++g) {
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      const Index v = groups_.vertex(i);
      if (!std::binary_search(part->shared_vertices.begin(), part->shared_vertices.end(), v)) {
        continue;
      }
      shared_places_.push_back(i);
      has_shared_[static_cast<std::size_t>(g)] = true;
    }
  }
  is_shared_.assign(groups_.order().size(), 0);
  for (const Index i : shared_places_) is_shared_[static_cast<std::size_t>(i)] = 1;
}

// shared_sums_ ← the sums over all parts of what `own` says of shared vertices.
template <class T>
template <class Own>
void MatrixFreeCg<T>::add_shared(const Own& own) {
  for (const Index i : shared_places_) {
    vertex_block(shared_sums_, groups_.vertex(i)) =
        own(i).template head<3>().template cast<double>();
  }
  tetraction::add_shared(system_.part(), shared_sums_, 3);
}

template <class T>
auto MatrixFreeCg<T>::shared_sum(Index place) const -> Record {
  const Index v = groups_.vertex(place);
  return Eigen::Vector4d(shared_sums_[3 * v], shared_sums_[3 * v + 1], shared_sums_[3 * v + 2], 0.0)
      .template cast<T>();
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
  has_terms_ = problem.has_general_terms();
  set_terms(HessianForm::kExact);
}

template <class T>
void MatrixFreeCg<T>::convexify() {
  has_blocks_ = false;
  const MinimizationProblem::HessianParts parts = problem_->hessian_parts(u_);
  // The curvature of volumes is indefinite. Without it the other part of nodal volumes is convex.
  if (parts.volume != nullptr) operator_.set(point_, parts.viscous, parts.step_displacement);
  operator_.convexify();
  if (has_terms_ || parts.volume != nullptr) set_terms(HessianForm::kConvex);
}

// Sets the part of the matrix that does not come from elements: the terms that are quadratic in
// single vertices, general terms, and the outer products of nodal volumes.
template <class T>
void MatrixFreeCg<T>::set_terms(HessianForm form) {
  if (has_terms_) {
    problem_->term_hessian(u_, form, terms_);
  } else {
    terms_.reset(0);
  }
  const MinimizationProblem::HessianParts parts = problem_->hessian_parts(u_);
  outers_.set(parts.positions, form, terms_);
  const Vector& diagonal = parts.diagonal;
  if (has_terms_) off_.resize(diagonal_.size());
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    Vector3 on = vertex_block(diagonal, v);
    if (has_terms_) {
      const Matrix3 h = terms_.diagonal(v);
      on += h.diagonal();
      record(off_, i) = Eigen::Vector4d(h(0, 1), h(0, 2), h(1, 2), 0.0).template cast<T>();
    }
    record(diagonal_, i) = Eigen::Vector4d(on[0], on[1], on[2], 0.0).template cast<T>();
  });
  neighbors_begin_.clear();
  neighbors_.clear();
  if (!has_terms_ || terms_.pairs().empty()) return;
  if (place_of_.empty()) {
    place_of_.resize(static_cast<std::size_t>(system_.vertex_count()));
    for (Index i = 0; i < system_.vertex_count(); ++i) {
      place_of_[static_cast<std::size_t>(groups_.vertex(i))] = static_cast<std::int32_t>(i);
    }
  }
  const auto place = [&](Index v) { return place_of_[static_cast<std::size_t>(v)]; };
  // Counted, then filled in the order of the pairs.
  neighbors_begin_.assign(static_cast<std::size_t>(system_.vertex_count()) + 1, 0);
  for (const HessianBlocks::Pair& pair : terms_.pairs()) {
    ++neighbors_begin_[static_cast<std::size_t>(place(pair.row)) + 1];
    ++neighbors_begin_[static_cast<std::size_t>(place(pair.column)) + 1];
  }
  std::partial_sum(neighbors_begin_.begin(), neighbors_begin_.end(), neighbors_begin_.begin());
  std::vector<Index> next(neighbors_begin_.begin(), neighbors_begin_.end() - 1);
  neighbors_.resize(2 * terms_.pairs().size());
  const auto enter = [&](Index v, Index other, const Matrix3& block) {
    Index& end = next[static_cast<std::size_t>(place(v))];
    neighbors_[static_cast<std::size_t>(end++)] = {place(other), block.template cast<T>()};
  };
  for (const HessianBlocks::Pair& pair : terms_.pairs()) {
    enter(pair.row, pair.column, pair.block);
    enter(pair.column, pair.row, pair.block.transpose());
  }
}

template <class T>
NegativeCurvature MatrixFreeCg<T>::negative_curvature() const {
  NegativeCurvature way;
  way.curvature = curvature_;
  copy(p_, way.direction);
  return way;
}

template <class T>
double MatrixFreeCg<T>::curvature(const Vector& d) {
  const double scale = largest_of_parts(system_.part(), d.lpNorm<Eigen::Infinity>());
  if (!(scale > 0.0)) return 0.0;
  for_places([&](Index i) {
    const Vector3 own = vertex_block(d, groups_.vertex(i)) / scale;
    record(p_, i) = Eigen::Vector4d(own[0], own[1], own[2], 0.0).template cast<T>();
  });
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
    if (!coordinates.is_free(v)) own = project(coordinates, v, own);
    vertex_block(vector, v) = own;
  });
}

template <class T>
void MatrixFreeCg<T>::make_blocks() {
  has_blocks_ = true;
  const Vector& diagonal = problem_->hessian_parts(u_).diagonal;
  operator_.diagonal(p_, z_);
  for (AlignedVector<T>* field : {&p_, &z_}) {
    add_shared([&](Index i) { return record(*field, i); });
    for (const Index i : shared_places_) record(*field, i) = shared_sum(i);
  }
  const FreeCoordinates& coordinates = system_.coordinates();
  for_places([&](Index i) {
    const Index v = groups_.vertex(i);
    Eigen::Matrix<double, 4, 3> inverse = Eigen::Matrix<double, 4, 3>::Zero();
    if (!coordinates.is_fully_prescribed(v)) {
      Eigen::Vector4d on = (record(p_, i) + record(diagonal_, i)).template cast<double>();
      Eigen::Vector4d off = record(z_, i).template cast<double>();
      if (has_terms_) off += record(off_, i).template cast<double>();
      Matrix3 block;
      block << on[0], off[0], off[1], off[0], on[1], off[2], off[1], off[2], on[2];
      if (!outers_.empty()) block += outers_.block(i);
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
  const auto vertex_term = [&](Index i) -> Matrix3 {
    const Record on = record(diagonal_, i);
    Matrix3 block = Vector3(on.template head<3>().template cast<double>()).asDiagonal();
    if (has_terms_) {
      const Record off = record(off_, i);
      block(0, 1) = block(1, 0) = off[0];
      block(0, 2) = block(2, 0) = off[1];
      block(1, 2) = block(2, 1) = off[2];
    }
    return block;
  };
  return coarse_->update(operator_, vertex_term, point_, &outers_);
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
  return coordinates.is_free(v) ? x : project(coordinates, v, x);
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
    Vector3 g = vertex_block(gradient, v) / -scale;
    if (!coordinates.is_free(v)) g = project(coordinates, v, g);
    record(x_, i).setZero();
    record(ap_, i).setZero();
    record(p_, i).setZero();
    const Record own = Eigen::Vector4d(g[0], g[1], g[2], 0.0).template cast<T>();
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
  if (system_.part() != nullptr) add_shared([&](Index i) { return operator_.record_sum(i); });
  const bool has_outers = !outers_.empty();
  if (has_outers) outers_.multiply(p_);
  const Products products = sum_over_groups([&](Index g) {
    const bool all_free = all_free_[static_cast<std::size_t>(g)];
    const bool all_own = has_shared_.empty() || !has_shared_[static_cast<std::size_t>(g)];
    Record sum = Record::Zero();
    for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
      const Record p = record(p_, i);
      const Record elastic = all_own || is_shared_[static_cast<std::size_t>(i)] == 0
                                 ? Record(operator_.record_sum(i))
                                 : shared_sum(i);
      Record ap = elastic + record(diagonal_, i).cwiseProduct(p);
      if (has_terms_) {
        const Record off = record(off_, i);
        ap += Record(off[0] * p[1] + off[1] * p[2], off[0] * p[0] + off[2] * p[2],
                     off[1] * p[0] + off[2] * p[1], T(0));
      }
      if (!neighbors_begin_.empty()) add_neighbors(i, ap);
      if (has_outers) ap += outers_.product(i);
      if (!all_free) ap = allowed(ap, i);
      record(ap_, i) = ap;
      sum += p.cwiseProduct(ap);
    }
    return Products{sum.template cast<double>().sum(), 0.0};
  });
  return products.rz;
}

// sum += the blocks of pairs that the vertex at a place takes part in, times p.
template <class T>
void MatrixFreeCg<T>::add_neighbors(Index place, Record& sum) const {
  const auto begin = static_cast<std::size_t>(neighbors_begin_[static_cast<std::size_t>(place)]);
  const auto end = static_cast<std::size_t>(neighbors_begin_[static_cast<std::size_t>(place) + 1]);
  for (std::size_t k = begin; k < end; ++k) {
    const Neighbor& other = neighbors_[k];
    sum.template head<3>() += other.block * record(p_, other.place).template head<3>();
  }
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
  return sum_over_groups([&](Index g) {
           Record sum = Record::Zero();
           for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
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
             const Record padded(z[0], z[1], z[2], T(0));
             record(z_, i) = padded;
             sum += record(r_, i).cwiseProduct(padded);
           }
           return Products{sum.template cast<double>().sum(), 0.0};
         })
      .rz;
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
  return sum_over_groups([&](Index g) {
           Record sum = Record::Zero();
           for (Index i = groups_.begin(g); i < groups_.end(g); ++i) {
             const Vector3 z = vertex_block(preconditioned_, groups_.vertex(i));
             const Record padded = Eigen::Vector4d(z[0], z[1], z[2], 0.0).template cast<T>();
             record(z_, i) = allowed(padded, i);
             sum += record(r_, i).cwiseProduct(record(z_, i));
           }
           return Products{sum.template cast<double>().sum(), 0.0};
         })
      .rz;
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
  start(gradient, scale, (given ? kSeedIfGiven : kSeed) * forcing);
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
