// All constraints of the body: prescribed vertices, planes and lines, distances, rigid handles.
//
// Linear constraints are eliminated (fem/free_coordinates.h). Distances and the rigidity of free
// handles are not linear. They are equations g(w) = 0 in a few configuration vectors w = Bᵀq, which
// are satisfied by means of multipliers (dynamics/constraints/multipliers.h):
//
//     distance of a and b:  w = q_a − q_b,                    g = ½(|w|²/L² − 1)
//     free rigid handle:    w_j = Σ_a (m_a/m) ξ_ja q_a,       g_ij = ½(w_i·w_j/(ρ_iρ_j) − δ_ij)
//
// A free handle is an affine set (fem/free_coordinates.h) along the principal axes of its masses.
// ρ_j are its radii of gyration. The equations keep its vectors w_j orthogonal and of constant
// length.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/dynamics/constraints/prescribed_motion.h"
#include "tetraction/dynamics/terms/penalty_springs.h"
#include "tetraction/fem/free_coordinates.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Vertices that may only move in a plane (two directions) or along a line (one direction). Each
/// vertex has a plane or line through a point of its own.
struct GuidedVertices {
  std::vector<Index> vertices;
  Matrix directions;  ///< 3 × 1 or 3 × 2, orthonormal
  Matrix points;      ///< 3 × vertices, m
  std::string name;
};

/// The constraint |q_a − q_b| = length.
struct FixedDistance {
  Index a = 0;
  Index b = 0;
  double length = 0.0;  ///< m, above 0
  std::string name;
};

/// Vertices that move together as one free rigid body.
struct RigidHandle {
  std::vector<Index> vertices;
  Matrix shape;  ///< 3 × vertices: positions that give the shape, m
  std::string name;
};

/// All constraints, as data.
struct ConstraintList {
  std::vector<PrescribedVertices> held;  ///< prescribed vertices; driven handles are among them
  std::vector<GuidedVertices> guided;
  std::vector<FixedDistance> distances;
  std::vector<RigidHandle> handles;
};

/// A consistent set of constraints of one body.
class Constraints {
 public:
  /// No constraints.
  explicit Constraints(Index vertex_count);
  /// `mass`: one per vertex, kg. All vertices may be prescribed; then nothing is left to solve for.
  /// Throws InputError, which names the constraints, for: a component of a vertex that is
  /// prescribed twice in different ways, guiding planes and lines that do not meet, a vertex of a
  /// handle that has another constraint, a distance of zero.
  Constraints(ConstraintList list, const TetMesh& mesh, const Vector& mass);

  const ConstraintList& list() const { return list_; }
  /// Changes the length of list().distances[i], m, to a number above 0.
  void set_distance_length(std::size_t i, double length);
  const FreeCoordinates& coordinates() const { return coordinates_; }
  /// Whether nothing is constrained.
  bool empty() const { return prescribed_.empty() && equations_.empty() && springs_.empty(); }
  /// Whether some prescribed vertex moves.
  bool moving() const { return moving_; }
  /// Whether a constraint restricts the motion of the vertex or couples it with other vertices.
  bool is_constrained(Index vertex) const;
  /// All vertices for which is_constrained() is true, ascending.
  std::vector<Index> constrained_vertices() const;

  /// Sets the prescribed components of q exactly to their targets at `time`. Puts guided vertices
  /// onto their planes and lines, and the vertices of handles back onto their affine form.
  void prescribe(double time, Vector& q) const;
  /// Calls visit(vertex, displacement) for every prescribed vertex. The displacement leads its
  /// prescribed components from `from` to their targets at `time`. Without moving targets it does
  /// nothing.
  void for_each_prescribed_displacement(
      const Vector& from, double time,
      const std::function<void(Index, const Vector3&)>& visit) const;
  /// Sets the prescribed components of momenta to M times their rates at `time`.
  void prescribe_momentum(double time, Vector& momentum) const;

  // Multipliers.
  bool has_equations() const { return !equations_.empty(); }
  Index configuration_size() const { return configuration_size_; }
  Index equation_count() const { return equation_count_; }
  /// w = Bᵀq.
  Vector configuration(const Vector& q) const;
  /// B u: the forces (or impulses) on vertices that generalised forces (or impulses) u on w amount
  /// to.
  Vector vertex_forces(const Vector& u) const;
  /// forces += B u.
  void add_vertex_forces(const Vector& u, Vector& forces) const;
  /// Most columns and rows of g and w have few entries, because a constraint concerns few vertices.
  using SparseMatrix = Eigen::SparseMatrix<double>;
  /// TᵀB, one column per entry of w.
  Matrix selector() const { return selector_; }
  const SparseMatrix& sparse_selector() const { return selector_; }
  /// The diagonal of TᵀMT, kg.
  const Vector& reduced_mass() const { return reduced_mass_; }
  /// S = BᵀT (TᵀMT)⁻¹ TᵀB, 1/kg: the change of the rates of w under unit impulses.
  Matrix inverse_mass() const { return inverse_mass_; }
  const SparseMatrix& sparse_inverse_mass() const { return inverse_mass_; }
  /// g(w).
  Vector values(const Vector& w) const;
  /// ∂g/∂w as columns: configuration_size() × equation_count().
  Matrix gradients(const Vector& w) const;
  SparseMatrix sparse_gradients(const Vector& w) const;
  /// Σ λ_i ∂²g_i/∂w², which does not depend on w.
  Matrix curvature(const Vector& multipliers) const;
  /// hessian += ∂²/∂q² of Σ_i (½ k_i g_i² − λ_i g_i) at w, J/m², on vertices whose positions determine w
  /// where the linear constraints hold: its part Tᵀ…T over the free coordinates is right. `stiffness` is k and
  /// `multipliers` are λ, both J. The convex form has no negative eigenvalues.
  void add_equation_hessian(const Vector& w, const Vector& stiffness, const Vector& multipliers,
                            HessianForm form, HessianBlocks& hessian) const;
  /// The configuration with g = 0 that is nearest to w, found for each constraint separately.
  Vector retract(Vector w) const;
  /// The length of every entry of w, m: L of a distance, ρ_j of a handle.
  Vector configuration_lengths() const;
  /// Units in which the numbers of large and small, heavy and light constraints are comparable.
  /// They depend on the response S, the displacement of w under unit forces. In these units S and
  /// ∂g/∂w are of the order of one.
  struct Units {
    Vector displacement;  ///< of the entries of w: √S_ii; the length where nothing moves it
    Vector multiplier;    ///< of the λ: the inverse of the larger √S_ii/s_i of the equation
  };
  Units units(const Matrix& response) const { return units_of(response.diagonal()); }
  /// The same, from the diagonal of S.
  Units units_of(const Vector& response) const;
  /// The force that pulls the ends of list().distances[i] together, N, for generalised forces u at
  /// w.
  double tension(std::size_t i, const Vector& u, const Vector& w) const;
  /// The name of the constraint that an equation belongs to.
  const std::string& name_of_equation(Index equation) const;

  /// The springs of the vertices that are prescribed by a penalty.
  const PenaltySprings& springs() const { return springs_; }

  /// The largest deviation, m: of a prescribed component from its target, of a guided vertex from
  /// its plane or line, or of a length from its given value. Penalty springs do not count.
  double error(const Vector& q, double time) const;
  /// The largest |g(w)|; g is relative to the lengths of the constraints.
  double relative_error(const Vector& q) const;

 private:
  // A vertex with prescribed components or guides, and the directions in which it may still move.
  struct Prescribed {
    Index vertex = 0;
    VertexFreedom freedom;
    std::array<Index, 3> held{-1, -1, -1};  // which of list().held prescribes the component
    std::array<Index, 3> place{};           // and where in its list
    Vector3 point = Vector3::Zero();        // on the plane or line, if guided
    bool guided = false;
  };
  // One distance or handle.
  struct Equation {
    Index first_entry = 0;                           // of w
    Index first_equation = 0;                        // of g
    int rank = 0;                                    // 0: a distance
    Vector3 scale = Vector3::Ones();                 // L, or ρ_1, ρ_2, ρ_3
    std::vector<std::pair<Index, Vector3>> weights;  // vertex → factor in each w_j
    // The same for few vertices, which give the same w where the vertices of a handle are in its affine form.
    std::vector<std::pair<Index, Vector3>> carriers;
    std::string name;
    Index entries() const { return rank == 0 ? 3 : 3 * rank; }
    Index count() const { return rank == 0 ? 1 : rank * (rank + 1) / 2; }
  };

  // Calls visit(number of the equation, first entry of w_i, first entry of w_j, s_ij) for every
  // equation. Distances have i = j.
  template <class Visit>
  void for_each_equation(const Visit& visit) const;
  template <class Visit>
  static void visit_equations(const Equation& equation, const Visit& visit);
  void add_held(std::map<Index, Prescribed>& vertices, const TetMesh& mesh);
  void add_guided(std::map<Index, Prescribed>& vertices, const TetMesh& mesh) const;
  std::vector<AffineSet> add_handles(const std::map<Index, Prescribed>& vertices,
                                     const TetMesh& mesh);
  void add_distances(const TetMesh& mesh);
  void make_selector();
  const PrescribedVertices& held(Index i) const { return list_.held[static_cast<std::size_t>(i)]; }
  Vector3 axis_target(const Prescribed& vertex, double time, const Vector3& q) const;
  Vector3 axis_rate(const Prescribed& vertex, double time) const;

  ConstraintList list_;
  FreeCoordinates coordinates_;
  Vector mass_;
  std::vector<Prescribed> prescribed_;
  std::vector<Equation> equations_;
  PenaltySprings springs_;
  Index configuration_size_ = 0;
  Index equation_count_ = 0;
  SparseMatrix selector_;
  Vector reduced_mass_;
  SparseMatrix inverse_mass_;
  bool moving_ = false;
};

}  // namespace tetraction
