// The nonlinear problems of implicit steps, as solvers see them.
#pragma once

#include <unordered_map>
#include <vector>

#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/positions.h"
#include "tetraction/fem/sparsity_pattern.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

class NodalVolume;

/// Equations r(u) = 0 for the displacements u of all vertices (3 per vertex, m). r is a force (3 per
/// vertex, N). Only its part Tᵀr over the free coordinates has to vanish (fem/free_coordinates.h).
///
/// There are two kinds. In a MinimizationProblem r is the gradient of a function Φ, so the
/// derivative of r is symmetric. A RootProblem has no such function.
class NonlinearProblem {
 public:
  virtual ~NonlinearProblem() = default;

  virtual const FreeCoordinates& coordinates() const = 0;
  /// A length of the order of the body's size, m.
  virtual double length_scale() const = 0;

  /// Whether r is defined at u.
  virtual bool is_defined(const Vector& u) const = 0;
  /// Evaluates r at u.
  virtual EvaluationStatus residual(const Vector& u, Vector& residual) const = 0;
  /// The admissible step: the largest t ≤ 1 up to which the problem is expected to be defined from
  /// u to u + t d. `elements_are_safe` says that no element can be inverted on this way.
  virtual double longest_step(const Vector& u, const Vector& d, bool elements_are_safe) const = 0;

  /// The magnitude of the forces that are in balance at the solution, N. Tolerances are relative to
  /// it. It is 0 if there are none.
  virtual double force_scale() const = 0;
  /// An estimate of the round-off of |Tᵀr|₂ at u in double precision, N.
  virtual double round_off(const Vector& u) const = 0;
  /// Whether the force scale is above a thousandth of round_off(). If so, a first guess must not be
  /// accepted because its residual is below round_off(): the load itself may be smaller than that.
  bool is_loaded(const Vector& u) const { return force_scale() > 1e-3 * round_off(u); }
  /// a·b, max |uᵢ| and |Tᵀf|₂ over the whole body, of which a process may hold a part (mesh/mesh_part.h); 3
  /// numbers per vertex.
  virtual double dot(const Vector& a, const Vector& b) const { return a.dot(b); }
  virtual double largest(const Vector& u) const { return u.lpNorm<Eigen::Infinity>(); }
  virtual double free_norm(const Vector& full) const { return coordinates().restricted_norm(full); }
  /// Largest |Tᵀr|₂ that counts as converged, N: max(tolerance × force scale, round_off()).
  double residual_limit(const Vector& u, double tolerance) const;
};

/// The minimisation of a function Φ(u), J, with r = ∇Φ.
///
/// The Hessian is available in three forms: as the parts that operators without a matrix need, as a
/// matrix in a sparsity pattern, and as shares of single elements.
class MinimizationProblem : public NonlinearProblem {
 public:
  /// Evaluates Φ, up to a constant.
  virtual EvaluationStatus value(const Vector& u, double& phi) const = 0;
  /// Evaluates Φ and ∇Φ (3 per vertex, N).
  virtual EvaluationStatus value_and_full_gradient(const Vector& u, double& phi,
                                                   Vector& gradient) const = 0;
  /// Evaluates Φ and Tᵀ∇Φ over the free coordinates, N.
  EvaluationStatus value_and_gradient(const Vector& u, double& phi, Vector& gradient) const;
  EvaluationStatus residual(const Vector& u, Vector& residual) const override;

  /// ∇²Φ is the sum of five parts: the stiffness of the elastic potential at positions x, that of nodal
  /// volumes, the Hessian of a viscous potential, a diagonal matrix, and term_hessian(). This struct has
  /// the first four. Its references are valid until the next call of a member function.
  struct HessianParts {
    const ElasticPotential& elastic;
    const NodalVolume* volume;        ///< null without nodal volumes
    Positions positions;              ///< x
    const ViscousPotential& viscous;  ///< evaluated at the displacement of the step
    const Vector& step_displacement;  ///< 3 per vertex, m
    const Vector& diagonal;           ///< 3 per vertex, N/m; not negative
  };
  virtual HessianParts hessian_parts(const Vector& u) const = 0;
  /// Whether term_hessian() may be different from zero.
  virtual bool has_general_terms() const = 0;
  /// hessian = the contribution of general force terms to ∇²Φ at u, N/m.
  virtual void term_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const = 0;
  /// values = Tᵀ∇²Φ T in the pattern's order, N/m. `terms` comes from term_hessian(), to which
  /// NodalVolume::add_outer_products() has been added. The pattern must have the pairs of `terms`.
  EvaluationStatus hessian(const Vector& u, const HessianBlocks& terms,
                           const SparsityPattern& pattern, double* values) const;

  /// The contribution to Φ of the general force terms, for sums over elements.
  struct TermShares {
    double energy = 0.0;     ///< J
    double magnitude = 0.0;  ///< how far `energy` can get below zero is of this order, J
    Vector gradient;         ///< 3 per vertex, N
    HessianBlocks hessian;   ///< of evaluations with a Hessian
    /// The pairs of `hessian`, each at one element that has both of its vertices.
    std::unordered_map<Index, std::vector<HessianBlocks::Pair>> pairs_of_element;
  };
  /// Evaluates this contribution at u. Returns false if a term is not defined there.
  virtual bool term_shares(const Vector& u, bool with_hessian, TermShares& shares) const = 0;
  /// The share of element e in Φ. It consists of the energy of the element and of a part of the
  /// energies of its vertices. `terms` may be null if there are no general force terms. Of their
  /// Hessians the diagonal blocks and `pairs_of_element` enter. The shares of all elements add up to
  /// value() + square_value().
  virtual bool element_terms(Index e, const Vector& u, const TermShares* terms, bool with_hessian,
                             ElasticPotential::ElementTerms& result) const = 0;
  /// The constant, J, with which the vertices' part of Φ is a sum of squares.
  virtual double square_value() const = 0;

  /// Whether ∇²Φ has the mass of the body. Without it, ∇²Φ of a slender body is so ill-conditioned that
  /// the round-off of the matrix matters.
  virtual bool has_inertia() const { return true; }
  /// An estimate of how far ∇²Φ(u) is from a saddle. If it is at most 1, the compressive stresses
  /// are too small to make a part of the body buckle, and ∇²Φ is expected to be positive definite. If
  /// it is infinite, the solver always examines ∇²Φ at the end.
  virtual double buckling_ratio(const Vector& u) const = 0;
};

/// Equations whose derivative need not be symmetric.
class RootProblem : public NonlinearProblem {
 public:
  /// Linearises r at u for the following calls of multiply().
  virtual EvaluationStatus linearize(const Vector& u) = 0;
  /// product = (∂r/∂u) d (3 per vertex, N), with the derivative of the last linearize().
  virtual void multiply(const Vector& d, Vector& product) const = 0;
  /// A minimisation of the same unknowns with a Hessian that is close to ∂r/∂u. The solver makes its
  /// preconditioner from this Hessian.
  virtual const MinimizationProblem& approximation() const = 0;
};

}  // namespace tetraction
