// The volumetric part of the elastic energy with averages at the vertices.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

class NodalPatches;

/// The volumetric energy of average nodal volumes (Bonet & Burton 1998):
///
///     W = Σ_a V_a U(J_a),   J_a = Σ_e V_e J_e / Σ_e V_e,   V_a = Σ_e V_e/4
///
/// over the tetrahedra e at vertex a. A body of linear tetrahedra has far fewer vertices than
/// tetrahedra, so that this energy does not lock where the material is nearly incompressible. The
/// rest of the material stays in the elements: λ or κ is zero there
/// (without_volumetric_part()). J_e of one tetrahedron may be far from 1 while J_a is near it.
///
/// At a vertex with tetrahedra of several materials, each material has an average of its own. Where
/// parameters vary, λ or κ at a vertex is the mean over the tetrahedra, weighted with V_e.
///
/// W is a function of positions alone. It is part of the elastic energy of a MechanicalSystem, not a
/// force term. All results are bitwise the same for any number of threads. W is defined where J_a > 0,
/// which is the case wherever all tetrahedra have J_e > 0. An object must not be used by two threads
/// at the same time, because its functions share work space.
class NodalVolume {
 public:
  /// `elastic`: the part of the energy that stays in the elements; must live longer. `materials`: the
  /// whole materials, in the same order. Throws InputError for a material that has no volumetric part of
  /// its own.
  NodalVolume(const ElasticPotential& elastic, const std::vector<MaterialField>& materials);
  ~NodalVolume();

  /// The material with λ (neo-Hookean, Mooney–Rivlin) or κ (Yeoh) equal to zero. Throws InputError for
  /// Saint Venant–Kirchhoff and custom materials, whose energy has no volumetric part U(J).
  static MaterialField without_volumetric_part(const MaterialField& material);

  /// Replaces one of the materials. Throws InputError as the constructor does.
  void set_material(std::size_t index, const MaterialField& material);

  /// W at x, J.
  double energy(const Positions& x) const;
  /// gradient += ∂W/∂x (3 per vertex, N). Returns W, J.
  double add_gradient(const Positions& x, Vector& gradient) const;
  /// energy = the whole elastic energy at x, W and that of the elements, J, and gradient = its gradient
  /// (3 per vertex, N), in one loop over the elements. Fails where it is not defined.
  EvaluationStatus elastic_energy_and_gradient(const Positions& x, double& energy,
                                               Vector& gradient) const;
  /// product += (∂²W/∂x²) d (3 per vertex, N). The derivative has two parts:
  ///
  ///     ∂²W/∂x² = Σ_a c_a b_a b_aᵀ + Σ_e t_e ∂²v_e/∂x²
  ///
  /// with the gradients b_a = ∂(Σ_e 6v_e)/∂x of the present volumes v_e at a vertex,
  /// c_a = U''(J_a)/(144 Σ_e V_e), and the tensions t_e of tensions(). The library adds the second part to the tangents
  /// of the elements, and keeps the first one as matrices of rank one.
  void add_product(const Positions& x, const Vector& d, Vector& product) const;
  /// t_e at x, the mean of U'(J_a) over the nodes of every tetrahedron, Pa: one number for each lane of
  /// the blocks of the elements. Valid until the next call of a function.
  std::span<const double> tensions(const Positions& x) const;
  /// c_a at x, N/m⁵. The convex form takes 0 where U'' is negative. Valid until the next call.
  const Vector& outer_factors(const Positions& x, HessianForm form) const;
  /// hessian += Σ_a c_a b_a b_aᵀ, N/m.
  void add_outer_products(const Positions& x, HessianForm form, HessianBlocks& hessian) const;

  /// gradient += a discrete gradient of W over the step from x − half_step to x + half_step (3 per vertex, N):
  /// f̄ with f̄·2 half_step = W(x + half_step) − W(x − half_step), without a resultant and a moment about `x`.
  /// J must be positive in all tetrahedra at both ends.
  void add_discrete_gradient(const Positions& x, const Vector& half_step, Vector& gradient) const;
  /// product += the derivative of f̄ in the direction d, while the start x − half_step stays.
  void add_discrete_gradient_product(const Positions& x, const Vector& half_step, const Vector& d,
                                     Vector& product) const;

  /// The share of every material in W at q, J.
  Vector energies_by_material(const Vector& q) const;
  /// densities += the mean of U(J_a) over the nodes of every tetrahedron, J/m³. Times V_e they add
  /// up to W.
  void add_energy_densities(const Vector& q, Vector& densities) const;
  /// The mean of U'(J_a) over the nodes of element e, Pa: the pressure that W adds to its Cauchy
  /// stress, positive in tension. May be called from several threads.
  double mean_tension(Index e, const Vector& q) const;
  /// The same of all elements, in one loop.
  Vector mean_tensions(const Vector& q) const;
  /// J_a of every vertex; of a vertex with several materials that of all its tetrahedra together.
  Vector ratios(const Vector& q) const;

  /// ElasticPotential::stiffness_sums() of the moduli |λ| or |κ| alone.
  ElasticPotential::StiffnessSums stiffness_sums() const;

  /// For every material at every vertex, the vertices of its tetrahedra there: those that an outer product of
  /// the Hessian couples.
  Index patch_count() const;
  std::span<const Index> patch_vertices(Index patch) const;
  /// The tetrahedra at the vertices, for the loops of the library.
  const NodalPatches& patches() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
