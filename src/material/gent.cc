#include "tetraction/material/gent.h"

#include <fmt/format.h>

#include <cmath>

#include "strain_invariants.h"
#include "tetraction/core/error.h"

namespace tetraction {

Gent::Gent(double mu, double jm, double kappa) : parameters_{mu, jm, kappa} {
  if (!std::isfinite(mu) || !(mu > 0.0)) {
    throw InputError(fmt::format("gent: mu = {} Pa must be positive and finite.", mu));
  }
  if (!std::isfinite(jm) || !(jm >= kLeastLimit)) {
    throw InputError(
        fmt::format("gent: jm = {} must be {} or more and finite; it is the limit of I1bar - 3, "
                    "and a smaller one is lost in the round-off of positions.",
                    jm, kLeastLimit));
  }
  if (!std::isfinite(kappa) || !(kappa >= 0.0)) {
    throw InputError(fmt::format("gent: kappa = {} Pa must not be negative or infinite.", kappa));
  }
}

double Gent::stretch_margin(const Matrix3& f) const {
  // With u = 2/3 ln J: Ī₁ − 3 = e⁻ᵘ (I₁ − 3 − 2 ln J − 3 (eᵘ − 1 − u)), which keeps its digits near rest.
  const StrainInvariants s(f);
  const double u = 2.0 / 3.0 * s.log_j;
  const double x = std::exp(-u) * (s.i1_term - 3.0 * x_minus_log1p(std::expm1(u)));
  return 1.0 - x / jm();
}

}  // namespace tetraction
