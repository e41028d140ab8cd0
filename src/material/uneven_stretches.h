// The principal stretches of a deformation whose stretches differ by orders of magnitude.
#pragma once

namespace tetraction {

/// The stretches of one element, as Stretches (laws/principal-inl.h) has them.
struct UnevenStretches {
  double c[3];        ///< λᵢ²
  double log[3];      ///< ln λᵢ − ⅓ ln J
  double axes[3][3];  ///< axes[i] belongs to c[i]
};

/// The stretches of B, whose columns are given, by one-sided Jacobi rotations of the columns. C = BᵀB has round-off of
/// the order of its largest entry, in which small eigenvalues are lost. The columns keep it (J. Demmel, K. Veselić,
/// SIAM J. Matrix Anal. Appl. 13, 1992).
UnevenStretches uneven_stretches(const double (&columns)[3][3]);

}  // namespace tetraction
