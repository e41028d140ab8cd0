// The elastic energy W(q) of the whole body, with its derivatives.
#pragma once

#include <memory>
#include <vector>

#include "tetraction/fem/rest_state.h"
#include "tetraction/fem/sparsity_pattern.h"
#include "tetraction/material/material_field.h"

namespace tetraction {

/// The outcome of an evaluation. An evaluation fails where the energy of a material is not defined
/// (J ≤ 0, or a position that is not finite) or where the potential of a force term is not defined.
/// The status then contains the first such element or vertex, and −1 otherwise.
struct EvaluationStatus {
  Index failed_element = -1;
  Index failed_vertex = -1;
  bool ok() const { return failed_element < 0 && failed_vertex < 0; }
};

/// W(q) = Σ_points V Ψ(F(q)) over the quadrature points of all elements (RestState): value, gradient, Hessian, matrix-free product.
///
/// Positions may be one field of 3 numbers per vertex (m) or a sum of two such fields (Positions).
/// All results are bitwise the same for any number of threads. After a failed evaluation the
/// outputs are unspecified. An object must not be used by two threads at the same time, because its
/// functions share work space.
class ElasticPotential {
 public:
  using Shape = RestState::Shape;

  /// Energy, gradient and Hessian of one element, which has n = 4 or 10 nodes.
  struct ElementTerms {
    double energy = 0.0;                                                       ///< J
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 10> gradient;               ///< N, 3 × n
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 30, 30> hessian;  ///< N/m, 3n × 3n
  };

  /// The whole body has one material. Keeps a reference to `rest`, which must live longer.
  ElasticPotential(const RestState& rest, const MaterialField& material);
  /// Element e has the material materials[material_of_element[e]]. Throws InputError if a material
  /// that varies is for another number of elements.
  ElasticPotential(const RestState& rest, std::vector<MaterialField> materials,
                   std::vector<int> material_of_element);
  ElasticPotential(const RestState& rest, const std::vector<MaterialModel>& materials,
                   std::vector<int> material_of_element);
  ~ElasticPotential();
  ElasticPotential(ElasticPotential&&) noexcept;

  const RestState& rest() const;
  const std::vector<MaterialField>& materials() const;
  /// The material of element e.
  MaterialModel material(Index e) const;
  /// The index in materials() of the material of element e.
  int material_index(Index e) const;
  /// The small-strain parameters of element e, Pa.
  LameParameters lame(Index e) const;
  /// Replaces one of the materials. Throws InputError as the constructor does.
  void set_material(std::size_t index, const MaterialField& material);

  /// Whether W is defined at q.
  EvaluationStatus admissible(const Positions& q) const;
  /// energy = W(q), J.
  EvaluationStatus value(const Positions& q, double& energy) const;
  /// gradient = ∇W(q) (3 per vertex, N) and energy = W(q), in one pass over the mesh.
  EvaluationStatus value_and_gradient(const Positions& q, double& energy, Vector& gradient) const;
  /// values += entries of ∇²W(q) in the pattern's order, N/m.
  EvaluationStatus add_hessian(const Positions& q, const SparsityPattern& pattern,
                               double* values) const;
  /// result = ∇²W(q) x without a matrix (3 per vertex). W must be defined at q.
  void product(const Vector& q, const Vector& x, Vector& result) const;

  /// Sums over elements from which PotentialProblem::round_off() estimates the round-off of forces.
  /// C = |λ| + 2μ is the modulus of an element, and K = C V Σ_a |∇N_a|² the force that one metre
  /// of a node's displacement adds.
  struct StiffnessSums {
    double squared = 0.0;     ///< Σ K², N²/m²
    double with_edges = 0.0;  ///< Σ (K L)² with L the longest rest edge, N²
  };
  /// The sums with all moduli larger by `extra_modulus`, Pa.
  StiffnessSums stiffness_sums(double extra_modulus) const;

  /// Evaluates the terms of element e. Returns false if its energy is not defined at q. If
  /// `with_hessian` is false, the Hessian is left unchanged. May be called from several threads.
  bool element_terms(Index e, const Positions& q, bool with_hessian, ElementTerms& terms) const;
  /// The energy of each material's elements, J; W must be defined at q.
  Vector energies_by_material(const Vector& q) const;
  /// Ψ at every quadrature point (RestState), J/m³.
  void energy_densities(const Vector& q, Vector& densities) const;
  /// P at a quadrature point, Pa; W must be defined at q.
  Matrix3 first_piola(Index point, const Vector& q) const;

 private:
  friend struct BlockAccess;  // the fast loops of the library (src/fem/element_blocks.h)
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
