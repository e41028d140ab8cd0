// Kernels of the tangent stiffness K(q) of isotropic materials, applied without a matrix.
//
// The notation is that of element_kernels.h, and de are the edges of the displacement. With w = e⁻ᵀ,
// dc = deᵀe + eᵀde, z = e G and b = I₁ e G − e G c G, the stiffness of every isotropic material is
//
//     d(∂W/∂e) = de S + e [a₁ G dc G + a₂ (dc:G) G] + k w deᵀ w + Σ s_ij (v_j:de) v_i
//
// where the sum is over all pairs of the matrices v = w, z, b, and
//
//     S = 2V [(Ψ₁ + Ψ₂ I₁) G − Ψ₂ GcG]
//     a₁ = −2V Ψ₂,   a₂ = 2V (Ψ₂ + Ψ₁₁)          without Ψ₂: a₁ = a₂ = 0 and s_zz = 4V Ψ₁₁
//     k = −V Ψ_L,    s_ww = l = V Ψ_LL
//     s_zw = 2V Ψ₁L, s_bb = 4V Ψ₂₂, s_zb = 4V Ψ₁₂, s_wb = 2V Ψ₂L
//
// A tension t of the element (BatchView) adds −t v to k and t v to l, with the present volume v.
//
// The indices 1, 2, L of Ψ denote derivatives with respect to I₁, I₂ and ln J. S is the part of the
// second Piola–Kirchhoff stress without Ψ_L, pulled back to the rest edges and multiplied by V.
// Viscosity has S and the metric term with a₁ only.
//
// A law in principal stretches (principal-inl.h) has S = V Σ sᵢ bᵢ bᵢᵀ instead, and the term e [V Σ S'ᵢⱼ bᵢ bⱼᵀ] with
// S'ᵢᵢ = Σⱼ hᵢⱼ bⱼᵀ dc bⱼ and S'ᵢⱼ = θᵢⱼ bᵢᵀ dc bⱼ.
//
// One formula therefore serves all materials. A kernel computes the terms only that the law has. S
// and all quantities after it are the *state* of an element, which is computed once for many
// products.
#pragma once

#include <algorithm>

#include "element_kernels.h"

namespace tetraction {

/// The set of terms that a stiffness has besides S.
enum class TangentForm {
  kSpatial = 1,    ///< w, k, l: laws that depend on J
  kMetric = 2,     ///< e, G, a₁, a₂: laws that depend on I₂, and viscosity
  kCoupled = 4,    ///< z, s_zz, s_zw
  kCoupledI2 = 8,  ///< b, s_bb, s_zb, s_wb; beside kCoupled
  kPrincipal = 16  ///< yᵢ, bᵢ, θᵢⱼ, hᵢⱼ: laws in principal stretches
};
constexpr TangentForm operator|(TangentForm a, TangentForm b) {
  return static_cast<TangentForm>(static_cast<int>(a) | static_cast<int>(b));
}
constexpr bool has(TangentForm form, TangentForm part) {
  return (static_cast<int>(form) & static_cast<int>(part)) != 0;
}

/// The form of the stiffness of a material, with or without viscosity.
TangentForm tangent_form(const IsotropicModel& material, bool viscous);

// The state of an element holds S (6 numbers), then the terms that the form has, in the order
// spatial: w (9), k, l; metric: e (9), G (6), a₁, a₂; coupled: z (9), s_zz, s_zw;
// coupled with I₂: b (9), s_bb, s_zb, s_wb; principal: yᵢ (9), bᵢ (9), V θ₁₂, V θ₂₀, V θ₀₁, V hᵢⱼ (00 01 02 11 12 22).
// The functions below tell where the terms begin.
constexpr int tangent_metric_offset(TangentForm form) {
  return has(form, TangentForm::kSpatial) ? 17 : 6;
}
constexpr int tangent_coupled_offset(TangentForm form) {
  return tangent_metric_offset(form) + (has(form, TangentForm::kMetric) ? 17 : 0);
}
/// The number of numbers in the state of an element.
constexpr int tangent_numbers(TangentForm form) {
  return tangent_coupled_offset(form) + (has(form, TangentForm::kCoupled) ? 11 : 0) +
         (has(form, TangentForm::kCoupledI2) ? 12 : 0) +
         (has(form, TangentForm::kPrincipal) ? 27 : 0);
}
constexpr int tangent_principal_offset(TangentForm form) {
  return tangent_numbers(form) - 27;
}
// No law is coupled and in principal stretches.
constexpr int kMostTangentNumbers = std::max(
    tangent_numbers(TangentForm::kSpatial | TangentForm::kMetric | TangentForm::kCoupled |
                    TangentForm::kCoupledI2),
    tangent_numbers(TangentForm::kSpatial | TangentForm::kMetric | TangentForm::kPrincipal));

/// Computes the state of all elements at `positions`: tangent_numbers(form) × kBatchLanes numbers per
/// batch.
void prepare_tangent(const BatchView& batches, const IsotropicModel& material, TangentForm form,
                     const double* positions, float* state);
void prepare_tangent(const BatchView& batches, const IsotropicModel& material, TangentForm form,
                     const double* positions, double* state);
/// Prepares a state without a material: metric terms with S = 0 and a₁ = a₂ = 0, to which viscosity
/// is added.
void prepare_empty_tangent(const BatchView& batches, const double* positions, double* state);

/// Adds K x to `result`. The records of both are as in element_kernels.h.
void apply_tangent(const BatchView& batches, TangentForm form, const float* state, const float* x,
                   float* result);
void apply_tangent(const BatchView& batches, TangentForm form, const double* state, const double* x,
                   double* result);

/// Adds the diagonal blocks of the nodes to records (xx yy zz 0) and (xy xz yz 0).
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const float* state,
                          float* diagonal, float* off_diagonal);
void add_tangent_diagonal(const BatchView& batches, TangentForm form, const double* state,
                          double* diagonal, double* off_diagonal);

/// The number of numbers of an element matrix. First come 6 numbers of each node's diagonal block
/// (xx xy xz yy yz zz), then 9 of the block of each pair of nodes (01 02 03 12 13 23), row by row,
/// with the rows of the pair's first node.
constexpr int kStiffnessNumbers = 4 * 6 + 6 * 9;
/// Computes the element matrices of one batch, kStiffnessNumbers × kBatchLanes numbers.
void tangent_stiffness(TangentForm form, const double* state, double* matrices);

/// Whether a bound on J(t)/J = det(1 + t wᵀde) shows that no element is inverted anywhere on the
/// way from q to q + x. The state must have the spatial terms.
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const float* state,
                          const float* x);
bool tangent_step_is_safe(const BatchView& batches, TangentForm form, const double* state,
                          const double* x);

}  // namespace tetraction
