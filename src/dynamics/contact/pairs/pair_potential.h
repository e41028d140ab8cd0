// The potential of one contact pair: value, derivatives, and the mean force of a step.
#pragma once

#include "dynamics/contact/pairs/pair_distance.h"
#include "tetraction/dynamics/contact/barrier.h"

namespace tetraction {

/// A pair and the share of the area that it stands for. Its potential is
///
///     U = w U_b(√D) e(c),   e(c) = (2 − c/ε) c/ε for c < ε, else 1,
///
/// with Barrier U_b, and for two edges with directions a and b the mollifier e of c = |a × b|² (Li et al., ACM
/// Trans. Graph. 39, 2020), which makes the force continuous where edges become parallel.
struct ContactPair {
  PairKind kind = PairKind::kPointTriangle;
  double weight = 0.0;    ///< w, m²
  double parallel = 0.0;  ///< ε, m⁴; zero means e = 1
};
/// ε of two edges with these rest directions: 1e-3 |a|² |b|².
double parallel_limit(const Vector3& a, const Vector3& b);
/// c of an edge–edge pair, m⁴.
double parallel_measure(const PairPoints& points);
/// e(c).
double mollifier(double c, double limit);

/// U, J; infinite where the sides touch.
double pair_energy(const Barrier& barrier, const ContactPair& pair, const PairPoints& points);
/// ∂U/∂p, N.
PairVector pair_gradient(const Barrier& barrier, const ContactPair& pair, const PairPoints& points);
/// ∂²U/∂p², N/m. It is indefinite.
PairMatrix pair_hessian(const Barrier& barrier, const ContactPair& pair, const PairPoints& points);

/// The mean of a pair over a step.
struct MeanPair {
  PairWeights weights = PairWeights::Zero();  ///< w̄, the minimiser with the mean Gram matrix
  Vector3 difference = Vector3::Zero();       ///< Σ w̄_i p̄_i with the mean points p̄, m
  double force = 0.0;                         ///< λ̄ = −2 w ē s |difference|, N
  double stiffness = 0.0;                     ///< −∂λ̄/∂d with the distance at the end, N/m
  PairVector gradient = PairVector::Zero();   ///< the discrete gradient, N
};
/// A mean f̄ of ∂U/∂p over a step between two sets of points with f̄·Δp = ΔU up to round-off, whose sum and
/// moment about any fixed point, with the mean points as levers, vanish. With the Gram matrix G_ij = r_i·r_j
/// of the edges r_i = p_i − p_0, of which D = min uᵀGu is a concave function:
///
///     ∇̄D = ūūᵀ + [ΔD − ūūᵀ:ΔG]/(ΔG:ΔG) ΔG,   ū the minimiser with the mean of both Gram matrices,
///     f̄_i = w (2 ē s Σ_j ∇̄D_ij r̄_j + Ū_b (Δe/Δc) ∇̄c_i),   s = ΔU_b/ΔD,   f̄_0 = −Σ f̄_i.
///
/// The squared distances must be positive at both ends. The way between them is not looked at.
MeanPair mean_pair(const Barrier& barrier, const ContactPair& pair, const PairPoints& from,
                   const PairPoints& to);
/// The symmetric part of ∂f̄/∂(to), N/m, without the change of the correction to ūūᵀ. It tends to half of
/// pair_hessian() for short steps.
PairMatrix mean_pair_hessian(const Barrier& barrier, const ContactPair& pair,
                             const PairPoints& from, const PairPoints& to);

}  // namespace tetraction
