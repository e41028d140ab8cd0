#include "tetraction/material/gent.h"

#include <fmt/format.h>

#include <cmath>

#include "tetraction/core/error.h"

namespace tetraction {

Gent::Gent(double mu, double jm, double kappa) : parameters_{mu, jm, kappa} {
  if (!std::isfinite(mu) || !(mu > 0.0)) {
    throw InputError(fmt::format("gent: mu = {} Pa must be positive and finite.", mu));
  }
  if (!std::isfinite(jm) || !(jm > 0.0)) {
    throw InputError(fmt::format(
        "gent: jm = {} must be positive and finite; it is the limit of I1bar - 3.", jm));
  }
  if (!std::isfinite(kappa) || !(kappa >= 0.0)) {
    throw InputError(fmt::format("gent: kappa = {} Pa must not be negative or infinite.", kappa));
  }
}

}  // namespace tetraction
