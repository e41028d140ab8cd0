// The interface of everything that acts on a body besides its own elasticity and viscosity.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tetraction/core/types.h"
#include "tetraction/dynamics/terms/amplitude.h"

namespace tetraction {

/// Where a force term is evaluated. It refers to its fields and is meant for one call.
struct ForcePoint {
  const Vector& mass;      ///< lumped mass of each vertex, kg
  const Vector& position;  ///< x, 3 per vertex, m
  double time = 0.0;       ///< s
  /// The step in which the force acts. Factors that change in time then have their mean over it, so
  /// that their impulse is exact. Absent: a force at the instant `time`.
  std::optional<TimeSpan> step = std::nullopt;
  /// Of an equilibrium under a part of the loads: the factor of the loads. It moves obstacles.
  double load_factor = 1.0;
};

/// Which entry of the energy balance the potential energy of a term belongs to.
enum class EnergyAccount {
  kStored,          ///< it is part of the body's energy and has a column of history.csv
  kConstraintWork,  ///< it stands for a constraint: its changes count as constraint work
  kExternalWork,    ///< it is a load of the user's: its changes count as external work
  kNone             ///< the term has no potential energy (loads, damping)
};

/// Whether a Hessian is wanted as it is or as a matrix without negative eigenvalues near it, which
/// preconditioners and descent directions need.
enum class HessianForm { kExact, kConvex };

/// A symmetric matrix over all vertices as a sum of 3 × 3 blocks and of matrices of rank one: the
/// Hessian of a force term.
class HessianBlocks {
 public:
  /// The block in the rows of vertex `row` and the columns of vertex `column`, and its transpose at
  /// the mirrored place.
  struct Pair {
    Index row = 0;
    Index column = 0;
    Matrix3 block = Matrix3::Zero();
  };

  /// The matrix c b bᵀ of rank one. b has three numbers for each of some vertices: entries `begin`
  /// to `end` of outer_vertices() and outer_vectors().
  struct Outer {
    double factor = 0.0;  ///< c
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  /// Sets all blocks to zero.
  void reset(Index vertex_count);
  /// Adds ∂²U/∂x_v², which is symmetric. Different vertices may be added to from several threads.
  void add(Index v, const Matrix3& block) { diagonal_.block<3, 3>(0, 3 * v) += block; }
  /// Adds ∂²U/∂x_i∂x_j and, at the mirrored place, its transpose. The two vertices must differ.
  /// Must be called from one thread only.
  void add_pair(Index i, Index j, const Matrix3& block);
  /// Adds c b bᵀ, where b has vectors[i] for vertex vertices[i]. All vertices must differ. The Hessian of a function of one number, such as a volume, has such a part; many
  /// vertices cost far less in this form than as pairs. Must be called from one thread only.
  void add_outer(double factor, std::span<const Index> vertices, std::span<const Vector3> vectors);
  /// Adds another matrix of the same size, multiplied by a number.
  void add(const HessianBlocks& other, double factor);

  Index vertex_count() const { return diagonal_.cols() / 3; }
  /// The blocks on the diagonal side by side, without those of outer products: 3 × 3n.
  const Matrix& diagonal() const { return diagonal_; }
  auto diagonal(Index v) const { return diagonal_.block<3, 3>(0, 3 * v); }
  /// The other blocks, in the order in which they were added.
  const std::vector<Pair>& pairs() const { return pairs_; }
  /// The matrices of rank one, in the order in which they were added.
  const std::vector<Outer>& outers() const { return outers_; }
  const std::vector<Index>& outer_vertices() const { return outer_vertices_; }
  const std::vector<Vector3>& outer_vectors() const { return outer_vectors_; }
  /// The blocks on the diagonal of the whole matrix side by side: 3 × 3n.
  Matrix whole_diagonal() const;
  /// Calls visit(i, j, block) for all blocks beside the diagonal: those of pairs() and those of
  /// outer products. A block stands for its transpose at (j, i), too. Blocks of the same two
  /// vertices may come more than once.
  template <class Visit>
  void for_each_pair(const Visit& visit) const {
    for (const Pair& pair : pairs_) visit(pair.row, pair.column, pair.block);
    for (const Outer& outer : outers_) {
      for (std::size_t a = outer.begin; a < outer.end; ++a) {
        for (std::size_t b = outer.begin; b < a; ++b) {
          visit(outer_vertices_[a], outer_vertices_[b],
                Matrix3(outer.factor * outer_vectors_[a] * outer_vectors_[b].transpose()));
        }
      }
    }
  }
  /// Multiplies all blocks by a number.
  void scale(double factor);
  /// product += H u (3 per vertex).
  void add_product(const Vector& u, Vector& product) const;

 private:
  Matrix diagonal_;
  std::vector<Pair> pairs_;
  std::vector<Outer> outers_;
  std::vector<Index> outer_vertices_;
  std::vector<Vector3> outer_vectors_;
};

/// The stiffness K = −∂f/∂x of a load f that depends on positions, as a sum of 3 × 3 blocks, N/m. It need
/// not be symmetric.
class LoadStiffness {
 public:
  /// The derivatives of minus the force on vertex `row` with respect to the position of vertex `column`.
  struct Block {
    Index row = 0;
    Index column = 0;
    Matrix3 block = Matrix3::Zero();
  };

  /// All blocks that are added will be multiplied by `weight`.
  explicit LoadStiffness(double weight = 1.0) : weight_(weight) {}
  void add(Index row, Index column, const Matrix3& block) {
    blocks_.push_back({row, column, weight_ * block});
  }
  /// Blocks of the same two vertices may come more than once.
  const std::vector<Block>& blocks() const { return blocks_; }
  /// product += K u and product += Kᵀ u (3 per vertex).
  void add_product(const Vector& u, Vector& product) const;
  void add_transposed_product(const Vector& u, Vector& product) const;
  /// hessian += ½ (K + Kᵀ).
  void add_symmetric_part(HessianBlocks& hessian) const;

 private:
  double weight_;
  std::vector<Block> blocks_;
};

/// A force that acts on the vertices of a body. It is the sum of one or more of these parts:
///
/// - a potential part −∂U/∂x of a potential energy U(x, t);
/// - a dissipative part −∂D/∂v of a dissipation potential D(v; x), convex in v with its least value
///   D = 0 at v = 0;
/// - a load f(t, x̃), which may depend on positions and need not have a potential.
///
/// A mechanical system keeps a list of its terms (MechanicalSystem::force_terms()). The steppers,
/// the incremental potential of implicit steps, the linear solvers, the stability limit and the
/// energy balance know terms by this interface alone, so that a new term needs no change in any of
/// them. Elasticity and viscosity have loops over the elements of their own
/// (fem/elastic_potential.h, fem/viscous_potential.h) and are not in the list.
///
/// Each function is called once for all vertices, and adds to what it is given. Derivatives must be
/// those of the energies exactly, because energy balances and implicit steps rely on it.
/// VertexPotential (vertex_potential.h) makes a term of three functions of one vertex.
///
/// A term must not change while it belongs to a system, unless its owner resets the steppers.
class ForceTerm {
 public:
  virtual ~ForceTerm() = default;

  /// A name of lower-case letters, digits and underscores; the energy of the term is in column
  /// <name>_energy of history.csv.
  virtual std::string name() const = 0;
  virtual EnergyAccount account() const { return EnergyAccount::kStored; }

  /// Which parts the term has. Parts that it lacks are not evaluated.
  virtual bool has_potential() const { return false; }
  virtual bool has_dissipation() const { return false; }
  virtual bool has_load() const { return false; }
  /// Whether the load depends on the positions x̃.
  virtual bool load_depends_on_position() const { return false; }
  /// Whether ∂²U/∂x² and ∂²D/∂v² are constant and diagonal, and ∂D/∂v is zero at v = 0. Implicit
  /// steps then evaluate the term once a step. The first derivatives may depend on the time.
  virtual bool is_quadratic() const { return false; }
  /// Whether the Hessian of U or D has blocks of two different vertices.
  virtual bool couples_vertices() const { return false; }
  /// Whether the two vertices of each such block belong to a common tetrahedron. Ceres refuses terms
  /// that couple other vertices.
  virtual bool couples_only_neighbors() const { return !couples_vertices(); }
  /// The acceleration a, m/s², if the term is a force m a on every vertex and nothing else.
  /// Explicit steps then need no separate pass over the vertices for it.
  virtual std::optional<Vector3> uniform_acceleration() const { return std::nullopt; }

  /// The first vertex at which U is not defined at `at`, or −1. A step never ends at such a point.
  virtual Index undefined_vertex(const ForcePoint& at) const;
  /// The largest t such that U is known to be defined and bounded on the whole way from `from` to
  /// from + t d, with d = `displacement`. Implicit steps do not go further in one iteration.
  virtual double longest_step(const ForcePoint& from, const Vector& displacement) const;

  /// U, J.
  virtual double energy(const ForcePoint& at) const;
  /// U(to) − U(from), J. Override it if the difference of two sums would lose digits.
  virtual double energy_change(const ForcePoint& from, const ForcePoint& to) const;
  /// gradient += ∂U/∂x, 3 per vertex, N: minus the force.
  virtual void add_gradient(const ForcePoint& at, Vector& gradient) const;
  /// hessian += ∂²U/∂x², N/m.
  virtual void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const;
  /// The energy that the dependence of U on time alone puts into the body between two states,
  /// ∫ ∂U/∂t dt along the motion, J. 0 for potentials that do not depend on the time.
  virtual double driven_work(const ForcePoint& from, const ForcePoint& to) const;
  /// gradient += a discrete gradient of U from q_k = `from.position` at t_k to q_{k+1} =
  /// `to.position` at t_{k+1}, 3 per vertex, N: a mean f̄ of ∂U/∂x in the step with
  ///
  ///     f̄·(q_{k+1} − q_k) = U(q_{k+1}, t_{k+1}) − U(q_k, t_k) − driven_work(from, to).
  ///
  /// The energy-momentum step (Integrator::kEnergyMomentum) takes −f̄ as the force. This version is the
  /// mean of the gradients at both ends for a quadratic term, and otherwise that of Gonzalez (1996):
  /// the gradient g at the midpoint plus N d/|d|², where N is what f̄·Δq lacks with g alone, and d = Δq
  /// at the vertices where U has a gradient. If the forces −g have no resultant and no moment,
  /// as those of springs between vertices, the part of d that is a rigid motion is left out, so that
  /// f̄ has none either. Factors that change in time have their mean over the step, as in all forces
  /// of a step. Override it if U has a discrete gradient of its own, or a symmetry that f̄ should
  /// have: for instance f̄ of this version has a moment about the centre of a central field.
  virtual void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                     Vector& gradient) const;

  /// D at velocities v (3 per vertex, m/s), W. In implicit steps `at` does not change
  /// while the step is solved for (StepProblem::dissipation_point()).
  virtual double dissipation(const ForcePoint& at, const Vector& v) const;
  /// gradient += ∂D/∂v, N: minus the force.
  virtual void add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                        Vector& gradient) const;
  /// hessian += ∂²D/∂v², kg/s.
  virtual void add_dissipation_hessian(const ForcePoint& at, const Vector& v, HessianForm form,
                                       HessianBlocks& hessian) const;

  /// force += the mean of f over the step `at.step`, so that its length times the mean is the
  /// impulse ∫ f dt; 3 per vertex, N. `at.position` are the positions x̃ where the rule evaluates
  /// forces: q_k (`explicit`), q_k + ½h M⁻¹p_k (`verlet`), x (implicit rules).
  virtual void add_load(const ForcePoint& at, Vector& force) const;
  /// stiffness += −∂f/∂x of a load that depends on positions, N/m. Implicit steps, equilibria and normal
  /// modes need it. Where it is not overridden, it is found by differences of add_load(), which calls
  /// that function six times for each vertex.
  virtual void add_load_stiffness(const ForcePoint& at, LoadStiffness& stiffness) const;

 protected:
  ForceTerm() = default;
  ForceTerm(const ForceTerm&) = default;
  ForceTerm& operator=(const ForceTerm&) = default;
};

}  // namespace tetraction
