// Kernels of the tangent stiffness K(q) of isotropic materials, applied without a matrix.
//
// In the notation of element_kernels.h, with edges e, de = edges of the displacement, w = e⁻ᵀ by
// columns and dc = deᵀe + eᵀde, every isotropic material's stiffness is
//
//     d(∂W/∂e) = de T + e [a₁ G dc G + a₂ (dc:G) G] + k w deᵀ w + l (w:de) w
//
//     neo-Hookean          T = μVG, k = V(μ − λ ln J), l = λV
//     Mooney–Rivlin        T = V[(μ₁ + μ₂I₁) G − μ₂ GcG], a₁ = −μ₂V, a₂ = μ₂V,
//                          k = V(μ₁ + 2μ₂ − λ ln J), l = λV
//     St Venant–Kirchhoff  T = V[μ GaG + λ/2 (a:G) G], a₁ = μV, a₂ = λ/2 V
//     viscosity            as St Venant–Kirchhoff
//
// so that one product serves all: the state is worked out once for many products.
#pragma once

#include "element_kernels.h"

namespace tetraction {

/// Which terms there are.
enum class TangentForm {
  kSpatial,  ///< T, w, k, l (neo-Hookean)
  kMetric,   ///< T, e, G, a₁, a₂ (St Venant–Kirchhoff)
  kBoth
};

/// The terms of a material, with viscosity beside it or not.
constexpr TangentForm tangent_form(MaterialKind kind, bool viscous) {
  if (kind == MaterialKind::kStVenantKirchhoff) return TangentForm::kMetric;
  return viscous || kind == MaterialKind::kMooneyRivlin ? TangentForm::kBoth
                                                        : TangentForm::kSpatial;
}

/// Numbers that the state of an element has.
constexpr int tangent_numbers(TangentForm form) {
  return form == TangentForm::kSpatial ? 17 : (form == TangentForm::kMetric ? 23 : 34);
}
constexpr int kMostTangentNumbers = tangent_numbers(TangentForm::kBoth);
/// Where in the state they begin: T (6) first; then w (9), k, l; then e (9), G (6), a₁, a₂.
constexpr int tangent_metric_offset(TangentForm form) {
  return form == TangentForm::kMetric ? 6 : 17;
}

/// `state`: tangent_numbers(form) × kBatchLanes a batch.
void prepare_tangent(const BatchView& batches, const IsotropicModuli& moduli, TangentForm form,
                     const double* positions, float* state);
void prepare_tangent(const BatchView& batches, const IsotropicModuli& moduli, TangentForm form,
                     const double* positions, double* state);

/// Adds K x to `result`; rows as in element_kernels.h.
void apply_tangent(const BatchView& batches, TangentForm form, const float* state, const float* x,
                   float* result);
void apply_tangent(const BatchView& batches, TangentForm form, const double* state, const double* x,
                   double* result);

/// Adds the nodes' diagonal blocks to rows (xx yy zz 0) and (xy xz yz 0).
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const float* state,
                          float* diagonal, float* off_diagonal);
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const double* state,
                          double* diagonal, double* off_diagonal);

/// Numbers of an element's matrix: 6 of each node's diagonal block (xx xy xz yy yz zz), then 9 of each
/// pair's block, row by row, rows of the first node: 01 02 03 12 13 23.
constexpr int kStiffnessNumbers = 4 * 6 + 6 * 9;
/// The elements' matrices of one batch: kStiffnessNumbers × kBatchLanes.
void tangent_stiffness(TangentForm form, const double* state, double* matrices);

/// Whether no element can be inverted anywhere on the way from q to q + x, by a bound on
/// J(t)/J = det(1 + t wᵀde). Needs the spatial terms.
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const float* state,
                          const float* x);
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const double* state,
                          const double* x);

}  // namespace tetraction
