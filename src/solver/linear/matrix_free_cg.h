// Conjugate gradients without an assembled matrix for Newton's linear systems.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "body_preconditioner.h"
#include "coarse_choice.h"
#include "coarse_space.h"
#include "core/conjugate_gradients.h"
#include "fem/tangent_operator.h"
#include "negative_curvature.h"
#include "single_precision_factor.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"
#include "vertex_groups.h"
#include "vertex_terms.h"

namespace tetraction {

/// The places of the vertices of a part of a body that other parts have, too. Without parts there are none.
class SharedPlaces {
 public:
  /// Keeps references to both.
  SharedPlaces(const MechanicalSystem& system, const VertexGroups& groups)
      : system_(system), groups_(groups) {
    const MeshPart* part = system.part();
    if (part == nullptr) return;
    is_in_group_.assign(static_cast<std::size_t>(groups.count_with_copies()), false);
    is_shared_.assign(groups.order().size(), 0);
    sums_.setZero(system.dof_count());
    for (Index g = 0; g < groups.count_with_copies(); ++g) {
      for (Index i = groups.begin(g); i < groups.end(g); ++i) {
        if (!std::binary_search(part->shared_vertices.begin(), part->shared_vertices.end(),
                                groups.vertex(i))) {
          continue;
        }
        places_.push_back(i);
        is_in_group_[static_cast<std::size_t>(g)] = true;
        is_shared_[static_cast<std::size_t>(i)] = 1;
      }
    }
  }

  const std::vector<Index>& places() const { return places_; }
  bool are_in_group(Index group) const {
    return !is_in_group_.empty() && is_in_group_[static_cast<std::size_t>(group)];
  }
  bool contains(Index place) const { return is_shared_[static_cast<std::size_t>(place)] != 0; }

  /// Adds the records (x y z 0) own(place) over all parts. Collective.
  template <class Own>
  void add(const Own& own) {
    for (const Index i : places_) {
      vertex_block(sums_, groups_.vertex(i)) = own(i).template head<3>().template cast<double>();
    }
    add_shared(system_.part(), sums_, 3);
  }
  /// The sum at a shared place.
  template <class T>
  Eigen::Matrix<T, 4, 1> sum(Index place) const {
    const Index v = groups_.vertex(place);
    return Eigen::Vector4d(sums_[3 * v], sums_[3 * v + 1], sums_[3 * v + 2], 0.0)
        .template cast<T>();
  }

 private:
  const MechanicalSystem& system_;
  const VertexGroups& groups_;
  std::vector<Index> places_;
  std::vector<std::uint8_t> is_shared_;  // of each place
  std::vector<bool> is_in_group_;
  Vector sums_;  // 3 per vertex
};

/// Conjugate gradients on ∇²Φ(x) in precision T. The tangent stiffness is applied element by
/// element. The preconditioner consists of the vertices' 3 × 3 blocks and, where that saves time
/// (coarse_choice.h), a coarse space (coarse_space.h). Alternatively the caller gives the factor of
/// a similar matrix or, of a body in parts, a BodyPreconditioner. The preconditioner removes the directions in which
/// constraints do not let a vertex move. Affine sets (rigid handles) are not supported.
///
/// A part of the last system's residual is added to the right-hand side of each system. Its size is
/// a quarter of the residual to which the system is solved. Along a direction of negative curvature
/// the residual of conjugate gradients can only grow. So within a few solves such a direction is
/// found even if the gradient has no component along it, as in a symmetric body. The additional
/// cost is small.
///
/// For a body in parts (mesh/mesh_part.h) every process works on its part: its own vertices, and copies of
/// vertices of others, which get the same bits everywhere. A product exchanges the elastic forces on shared
/// vertices, and sums are over own vertices. All processes must call the same functions.
///
/// Single precision is sufficient, because a direction needs a few digits only and the residuals of
/// Newton's method are computed elsewhere in double precision.
template <class T>
class MatrixFreeCg {
 public:
  static bool supports(const MechanicalSystem& system);
  explicit MatrixFreeCg(const MechanicalSystem& system);

  /// Linearises at u, where Φ must be defined.
  void set(const MinimizationProblem& problem, const Vector& u);
  /// Makes the stiffness (TangentOperator::convexify) and the parts of nodal volumes and of force terms
  /// (nearly) positive semidefinite until the next set().
  void convexify();
  /// step ≈ −(∇²Φ)⁻¹ gradient (3 per vertex) to a relative residual of `forcing`.
  CgReport solve(const Vector& gradient, double forcing, int max_iterations, Vector& step) {
    factor_ = nullptr;
    body_preconditioner_ = nullptr;
    return run(gradient, forcing, max_iterations, step);
  }
  /// As above, with the factor of a matrix over the free coordinates as the preconditioner.
  CgReport solve(const Vector& gradient, double forcing, int max_iterations,
                 SinglePrecisionFactor& factor, Vector& step) {
    factor_ = &factor;
    body_preconditioner_ = nullptr;
    return run(gradient, forcing, max_iterations, step);
  }
  /// As above, with the preconditioner of a body in parts.
  CgReport solve(const Vector& gradient, double forcing, int max_iterations,
                 BodyPreconditioner& preconditioner, Vector& step) {
    factor_ = nullptr;
    body_preconditioner_ = &preconditioner;
    return run(gradient, forcing, max_iterations, step);
  }
  /// The direction, after a solve that met negative curvature. Its length has no meaning.
  NegativeCurvature negative_curvature() const;
  /// dᵀ∇²Φ d (d: 3 per vertex), to be called between solves.
  double curvature(const Vector& d);
  /// Whether a bound shows that no element is inverted on the way along the last step.
  bool step_is_safe() const { return operator_.step_is_safe(x_.data()); }
  /// To be called before systems that differ strongly from the last ones (another step size).
  void forget() { choice_ = CoarseChoice(); }

 private:
  using Record = Eigen::Matrix<T, 4, 1>;
  using CoarseMotion = typename CoarseSpace<T>::Motion;
  // The velocities of the vertices of a group in a motion (t, ω).
  struct RigidMotion {
    Record t, x, y, z;  // and ω × the unit vectors
    explicit RigidMotion(const CoarseMotion& motion) {
      const Eigen::Matrix<T, 6, 1> m = motion.template cast<T>();
      t = Record(m[0], m[1], m[2], T(0));
      x = Record(T(0), m[5], -m[4], T(0));
      y = Record(-m[5], T(0), m[3], T(0));
      z = Record(m[4], -m[3], T(0), T(0));
    }
    Record of(const Record& arm) const { return arm[3] * t + arm[0] * x + arm[1] * y + arm[2] * z; }
  };
  struct Products {
    double rz = 0.0;
    double rr = 0.0;
  };

  CgReport run(const Vector& gradient, double forcing, int max_iterations, Vector& step);
  bool has_given_preconditioner() const {
    return factor_ != nullptr || body_preconditioner_ != nullptr;
  }
  void make_blocks();
  bool make_coarse_space();
  void start(const Vector& gradient, double scale, double share);
  template <class Value>
  double set_preconditioned(const Value& value);
  double precondition_with_factor();
  double precondition_body();
  // The functions that conjugate_gradients() calls. descend() also computes the vertices' part of
  // the preconditioned residual, in the same pass.
  template <class Vectors>
  friend CgReport conjugate_gradients(Vectors& vectors, double forcing, int max_iterations);
  double square() const { return products_.rr; }
  double precondition();
  void begin() { turn(0.0, 0.0); }
  bool renew(const CgReport& report);
  double multiply();
  void descend(double alpha);
  void turn(double alpha, double beta);
  void finish(double alpha);
  void take_direction() { x_ = p_; }
  void copy(const AlignedVector<T>& field, Vector& vector) const;
  Record allowed(const Record& x, Index place) const;
  template <class Body>
  Products sum_over_groups(const Body& body);
  template <class Body>
  void for_groups(const Body& body) const;
  template <class Body>
  void for_places(const Body& body) const;
  Eigen::Map<Record, Eigen::Aligned16> record(AlignedVector<T>& field, Index place) const {
    return Eigen::Map<Record, Eigen::Aligned16>(field.data() + 4 * place);
  }
  Eigen::Map<const Record, Eigen::Aligned16> record(const AlignedVector<T>& field,
                                                    Index place) const {
    return Eigen::Map<const Record, Eigen::Aligned16>(field.data() + 4 * place);
  }

  const MechanicalSystem& system_;
  VertexGroups groups_;  // the records below are in the order of its places
  TangentOperator<T> operator_;
  Index grain_ = 1;             // groups worth a task
  std::vector<bool> all_free_;  // of each group
  std::unique_ptr<CoarseSpace<T>> coarse_;
  CoarseChoice choice_;
  const MinimizationProblem* problem_ = nullptr;  // of set()
  Vector u_;
  Vector point_;  // positions at u_
  bool has_blocks_ = false;
  // The preconditioner of the solve in progress, if the caller has given one.
  SinglePrecisionFactor* factor_ = nullptr;
  BodyPreconditioner* body_preconditioner_ = nullptr;
  Vector residual_;
  Vector preconditioned_;
  Eigen::Matrix<T, Eigen::Dynamic, 1> free_;
  VertexTerms<T> terms_;
  AlignedVector<T> inverse_;  // of the vertices' blocks: three rows each
  AlignedVector<T> x_, r_, p_, z_, ap_;
  SharedPlaces shared_;
  Products products_;           // of the residual: the vertices' part of r·z, and r·r
  double known_digits_ = 0.0;   // of the solve in progress, that the choice knows of already
  int known_iterations_ = 0;    // the iterations that it knows of
  double last_ = 0.0;           // r·r at the end of the last solve
  double curvature_ = 0.0;      // of p_, if that is negative
  std::vector<Products> sums_;  // of groups
};

extern template class MatrixFreeCg<float>;
extern template class MatrixFreeCg<double>;

}  // namespace tetraction
