// Laws in principal stretches, Ψ = Σ w(ln λ̄ᵢ) + κ/2 (J − 1)² with λ̄ᵢ = J^{−1/3} λᵢ (K. C. Valanis, R. F. Landel,
// J. Appl. Phys. 38, 1967). Highway includes this file once for each instruction set.
//
// With the eigenvalues cᵢ = λᵢ² and eigenvectors nᵢ of C, εᵢ = ln λ̄ᵢ, and the isochoric Kirchhoff stresses
// τᵢ = w'(εᵢ) − ⅓ Σ w'(εⱼ), the isochoric second Piola–Kirchhoff stress is S = Σ sᵢ nᵢ ⊗ nᵢ with sᵢ = τᵢ/cᵢ. For a
// change of C with the entries Cᵢⱼ' in the basis of the nᵢ, that of S has the entries
//
//     Sᵢᵢ' = Σⱼ hᵢⱼ Cⱼⱼ',  hᵢⱼ = ∂sᵢ/∂cⱼ,    Sᵢⱼ' = θᵢⱼ Cᵢⱼ',  θᵢⱼ = (sᵢ − sⱼ)/(cᵢ − cⱼ)
//
// (R. W. Ogden, Non-linear elastic deformations, 1984, sec. 6.1.4). θᵢⱼ has a limit where stretches are equal.
// Nothing cancels there, because it is computed from the quotient (w'(εᵢ) − w'(εⱼ))/(εᵢ − εⱼ), which a law gives.
#if defined(TETRACTION_MATERIAL_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_PRINCIPAL_INL_H_
#undef TETRACTION_MATERIAL_PRINCIPAL_INL_H_
#else
#define TETRACTION_MATERIAL_PRINCIPAL_INL_H_
#endif

#include "material/uneven_stretches.h"
#include "volumetric-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// eˣ − 1 − x.
template <class Real>
HWY_INLINE Real exponential_excess(Real x) {
  // The first term of the series that is left out is below 1e-17 of the sum.
  constexpr double kNear = 0.3;
  Real sum(0.0);
  double factorial = 479001600.0;  // 12!
  for (int n = 12; n >= 2; --n) {
    sum = mul_add(sum, x, Real(1.0 / factorial));
    factorial /= n;
  }
  return where_small(x, kNear, x * x * sum, exponential_minus_1(x) - x);
}

/// (eˣ − eʸ)/(x − y).
template <class Real>
HWY_INLINE Real exponential_quotient(Real x, Real y) {
  const Real half = Real(0.5) * (x - y);
  const Real square = half * half;
  // sinh(z)/z with z = (x − y)/2. The first term that is left out is below 1e-17.
  constexpr double kNear = 0.5;
  Real sum(0.0);
  double factorial = 6227020800.0;  // 13!
  for (int n = 13; n >= 1; n -= 2) {
    sum = mul_add(sum, square, Real(1.0 / factorial));
    factorial /= n * (n - 1.0);
  }
  const Real divisor = where_small(half, kNear, Real(1.0), x - y);
  return where_small(half, kNear, exponential(Real(0.5) * (x + y)) * sum,
                     (exponential(x) - exponential(y)) / divisor);
}

/// The eigenvalues and eigenvectors of symmetric matrices by Jacobi's method. Errors of the eigenvalues are of the
/// order of round-off times the largest one. It converges quadratically: five sweeps leave round-off.
template <class Real>
struct PrincipalAxes {
  Real values[3];
  Real axes[3][3];  ///< axes[i] belongs to values[i]

  /// The matrix has the entries 00 01 02 11 12 22.
  HWY_INLINE explicit PrincipalAxes(const Real* m) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) axes[i][k] = Real(i == k ? 1.0 : 0.0);
    }
    values[0] = m[0];
    values[1] = m[3];
    values[2] = m[5];
    Real off[3] = {m[4], m[2], m[1]};  // off[i] is the entry of the other two axes
    constexpr int kSweeps = 5;
    for (int i = 0; i < 3 * kSweeps; ++i) rotate(i % 3, off);
  }

 private:
  // Rotates the two axes beside r so that their entry vanishes.
  HWY_INLINE void rotate(int r, Real* off) {
    const int p = (r + 1) % 3;
    const int q = (r + 2) % 3;
    const Real d = values[q] - values[p];
    const Real b = off[r] + off[r];
    // tan of the angle: b/(d ± √(d² + b²)) with the sign of d. The least divisor stands for 0.
    const Real root = larger_magnitude(square_root(mul_add(d, d, b * b)), b);
    const Real t = b / with_sign(larger_magnitude(d, Real(0.0)) + root + Real(1e-300), d);
    const Real c = Real(1.0) / square_root(mul_add(t, t, Real(1.0)));
    const Real s = t * c;
    const Real small = s / (c + Real(1.0));  // tan of half of the angle
    values[p] = values[p] - t * off[r];
    values[q] = mul_add(t, off[r], values[q]);
    off[r] = Real(0.0);
    turn(s, small, off[q], off[p]);
    for (int k = 0; k < 3; ++k) turn(s, small, axes[p][k], axes[q][k]);
  }
  static HWY_INLINE void turn(Real s, Real small, Real& x, Real& y) {
    const Real old = x;
    x = x - s * mul_add(small, x, y);
    y = mul_add(s, old - small * y, y);
  }
};

/// Squares of stretches that differ by more than this factor are computed without C.
inline constexpr double kMostEven = 64.0;

/// The principal stretches of A = C − I. Of `values` only differences are used after the constructor.
template <class Real>
struct Stretches : PrincipalAxes<Real> {
  Real c[3];    ///< λᵢ²
  Real log[3];  ///< εᵢ = ln λ̄ᵢ

  HWY_INLINE explicit Stretches(const Real* a) : PrincipalAxes<Real>(a) {
    Real sum(0.0);
    for (int i = 0; i < 3; ++i) {
      c[i] = this->values[i] + Real(1.0);
      log[i] = Real(0.5) * log_of_1_plus(this->values[i]);
      sum = sum + log[i];
    }
    for (Real& number : log) number = number - Real(1.0 / 3.0) * sum;
  }

  /// Whether the smallest stretch may have lost digits in C, in any lane.
  HWY_INLINE bool is_uneven() const { return differ_by(kMostEven, c); }
  /// Computes the stretches where they are uneven from the columns of a matrix B with BᵀB = C.
  HWY_NOINLINE void refine(const Real (&columns)[3][3]) {
    constexpr std::size_t kLanes = kLanesOf<Real>;
    double of_columns[3][3][kLanes];
    double of_axes[3][3][kLanes];
    double of_values[3][kLanes];
    double of_c[3][kLanes];
    double of_log[3][kLanes];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        to_lanes(columns[i][k], of_columns[i][k]);
        to_lanes(this->axes[i][k], of_axes[i][k]);
      }
      to_lanes(this->values[i], of_values[i]);
      to_lanes(c[i], of_c[i]);
      to_lanes(log[i], of_log[i]);
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double squares[3] = {of_c[0][lane], of_c[1][lane], of_c[2][lane]};
      if (!differ_by(kMostEven, squares)) continue;
      double own[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) own[i][k] = of_columns[i][k][lane];
      }
      const UnevenStretches exact = uneven_stretches(own);
      for (int i = 0; i < 3; ++i) {
        of_values[i][lane] = of_c[i][lane] = exact.c[i];
        of_log[i][lane] = exact.log[i];
        for (int k = 0; k < 3; ++k) of_axes[i][k][lane] = exact.axes[i][k];
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) from_lanes(of_axes[i][k], this->axes[i][k]);
      from_lanes(of_values[i], this->values[i]);
      from_lanes(of_c[i], c[i]);
      from_lanes(of_log[i], log[i]);
    }
  }

  /// Ψ without its volumetric part.
  template <class Law, class P>
  HWY_INLINE Real energy(const P& m) const {
    return Law::energy(m, log[0]) + Law::energy(m, log[1]) + Law::energy(m, log[2]);
  }
  template <class Law, class P>
  HWY_INLINE void kirchhoff(const P& m, Real* tau) const {
    for (int i = 0; i < 3; ++i) tau[i] = Law::first_derivative(m, log[i]);
    const Real mean = Real(1.0 / 3.0) * (tau[0] + tau[1] + tau[2]);
    for (int i = 0; i < 3; ++i) tau[i] = tau[i] - mean;
  }
  /// sᵢ.
  template <class Law, class P>
  HWY_INLINE void stress(const P& m, Real* s) const {
    kirchhoff<Law>(m, s);
    for (int i = 0; i < 3; ++i) s[i] = s[i] / c[i];
  }
};

/// hᵢⱼ and θᵢⱼ.
template <class Real>
struct PrincipalTangent {
  Real h[3][3];
  Real theta[3];  ///< theta[i] is that of the other two axes

  // A constructor that the compiler makes by itself would not belong to the instruction set.
  HWY_INLINE PrincipalTangent() {}  // NOLINT(modernize-use-equals-default)

  template <class Law, class P>
  static HWY_INLINE PrincipalTangent of(const P& m, const Stretches<Real>& at) {
    PrincipalTangent t;
    Real tau[3];
    at.template kirchhoff<Law>(m, tau);
    Real second[3];
    for (int i = 0; i < 3; ++i) second[i] = Law::second_derivative(m, at.log[i]);
    const Real ninth = Real(1.0 / 9.0) * (second[0] + second[1] + second[2]);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        Real change = ninth - Real(1.0 / 3.0) * (second[i] + second[j]);  // ∂τᵢ/∂εⱼ
        if (i == j) change = change + second[i] - Real(2.0) * tau[i];
        t.h[i][j] = change / (Real(2.0) * at.c[i] * at.c[j]);
      }
    }
    for (int r = 0; r < 3; ++r) {
      const int i = (r + 1) % 3;
      const int j = (r + 2) % 3;
      // With δ = ln λᵢ − ln λⱼ: (cᵢ + cⱼ)/2 · δ/(cᵢ − cⱼ) = ½ δ/tanh δ and tanh δ = (cᵢ − cⱼ)/(cᵢ + cⱼ).
      const Real tanh = (at.values[i] - at.values[j]) / (at.c[i] + at.c[j]);
      constexpr double kNear = 0.1;
      const Real square = tanh * tanh;
      Real series(1.0 / 17.0);
      for (int k = 15; k >= 1; k -= 2) series = mul_add(series, square, Real(1.0 / k));
      const Real divisor = where_small(tanh, kNear, Real(1.0), tanh);
      const Real ratio = where_small(tanh, kNear, series, (at.log[i] - at.log[j]) / divisor);
      const Real quotient = Law::difference_quotient(m, at.log[i], at.log[j]);
      t.theta[r] = Real(0.5) * (quotient * ratio - (tau[i] + tau[j])) / (at.c[i] * at.c[j]);
    }
    return t;
  }

  /// The factors of yᵢ ⊗ yⱼ in ∂²W/∂xₐ∂x_b, where yᵢ = F nᵢ and `at_a`, `at_b` are the components of the nᵢ along the
  /// gradients of the shape functions of two nodes: hence those of F ⊗ F if these are unit vectors.
  HWY_INLINE void factors(const Real* at_a, const Real* at_b, Real (*out)[3]) const {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        out[i][j] = Real(2.0) * h[i][j] * at_a[i] * at_b[j];
        if (i != j) out[i][j] = mul_add(theta[3 - i - j] * at_a[j], at_b[i], out[i][j]);
      }
      for (int j = 0; j < 3; ++j) {
        if (i != j) out[i][i] = mul_add(theta[3 - i - j] * at_a[j], at_b[j], out[i][i]);
      }
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
