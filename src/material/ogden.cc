#include "tetraction/material/ogden.h"

#include <fmt/format.h>

#include <cmath>

#include "tetraction/core/error.h"

namespace tetraction {

Ogden::Ogden(const std::vector<double>& mu, const std::vector<double>& alpha, double kappa)
    : parameters_{} {
  if (mu.size() != alpha.size()) {
    throw InputError(
        fmt::format("ogden: mu has {} and alpha {} entries; every term needs one of both.",
                    mu.size(), alpha.size()));
  }
  if (mu.empty() || mu.size() > static_cast<std::size_t>(kMostTerms)) {
    throw InputError(fmt::format("ogden: mu and alpha have {} entries; there must be 1 to {}.",
                                 mu.size(), kMostTerms));
  }
  for (std::size_t p = 0; p < mu.size(); ++p) {
    if (!std::isfinite(mu[p])) {
      throw InputError(fmt::format("ogden: mu.{} = {} Pa must be finite.", p, mu[p]));
    }
    if (!std::isfinite(alpha[p]) || alpha[p] == 0.0) {
      throw InputError(fmt::format("ogden: alpha.{} = {} must be finite and not 0.", p, alpha[p]));
    }
    parameters_.mu[p] = mu[p];
    parameters_.alpha[p] = alpha[p];
  }
  parameters_.kappa = kappa;
  parameters_.terms = static_cast<int>(mu.size());
  const double modulus = initial_lame().mu;
  if (!(modulus > 0.0)) {
    throw InputError(
        fmt::format("ogden: the shear modulus of small strains, half of the sum of mu alpha, is {} "
                    "Pa and must be positive.",
                    modulus));
  }
  if (!std::isfinite(kappa) || !(kappa >= 0.0)) {
    throw InputError(fmt::format("ogden: kappa = {} Pa must not be negative or infinite.", kappa));
  }
}

Ogden Ogden::instead(const std::vector<double>& mu, const std::vector<double>& alpha,
                     double poissons_ratio) {
  if (!(poissons_ratio > -1.0 && poissons_ratio < 0.5)) {
    throw InputError(fmt::format("poissons_ratio = {} must lie between -1 and 0.5, both excluded.",
                                 poissons_ratio));
  }
  const double modulus = Ogden(mu, alpha, 0.0).initial_lame().mu;
  return {mu, alpha, 2.0 * modulus * (1.0 + poissons_ratio) / (3.0 * (1.0 - 2.0 * poissons_ratio))};
}

// The ratios of the three terms are those of R. W. Ogden, Proc. R. Soc. A 326, 1972, for Treloar's rubber.
Ogden Ogden::like(const LameParameters& lame) {
  const double unit = lame.mu / 0.4225;
  return {{0.63 * unit, 0.0012 * unit, -0.01 * unit},
          {1.3, 5.0, -2.0},
          lame.lambda + 2.0 / 3.0 * lame.mu};
}

LameParameters Ogden::initial_lame() const {
  double sum = 0.0;
  for (int p = 0; p < parameters_.terms; ++p) sum += parameters_.mu[p] * parameters_.alpha[p];
  return {0.5 * sum, kappa() - sum / 3.0};
}

Ogden Ogden::without_volumetric_part() const {
  Ogden result = *this;
  result.parameters_.kappa = 0.0;
  return result;
}

std::string Ogden::instability() const {
  constexpr int kSteps = 400;
  constexpr double kLargest = 10.0;
  // Whether the stress at the stretch e^log has the sign that it has near rest.
  const auto resists = [this](double log) {
    double slope = 0.0;  // dΨ/d ln λ at the stretches λ, 1/√λ, 1/√λ
    for (int p = 0; p < parameters_.terms; ++p) {
      const double exponent = parameters_.alpha[p] * log;
      slope += parameters_.mu[p] * (std::expm1(exponent) - std::expm1(-0.5 * exponent));
    }
    // Terms that overflow say nothing about the sign.
    return slope * log > 0.0 || !std::isfinite(slope);
  };
  for (int i = 1; i <= kSteps; ++i) {
    for (const double sign : {1.0, -1.0}) {
      const double step = sign / kSteps * std::log(kLargest);
      if (resists(i * step)) continue;
      double near = (i - 1) * step;  // the material resists from rest up to here
      double far = i * step;
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (near + far);
        (resists(middle) ? near : far) = middle;
      }
      // The four digits are rounded towards 1, where the stress has not fallen to zero yet.
      const double stretch = std::exp(near);
      const double unit = std::pow(10.0, std::floor(std::log10(stretch)) - 3.0);
      const double told = sign > 0.0 ? std::floor(stretch / unit) : std::ceil(stretch / unit);
      return fmt::format(
          "the ogden material is unstable: at a stretch of {:.4g} of a uniaxial state its stress "
          "has fallen to zero, and further strain sets energy free. Keep the strains well below "
          "that, or take terms with mu alpha > 0 only.",
          told * unit);
    }
  }
  return {};
}

std::span<const double> Ogden::mu() const {
  return {parameters_.mu, static_cast<std::size_t>(parameters_.terms)};
}
std::span<const double> Ogden::alpha() const {
  return {parameters_.alpha, static_cast<std::size_t>(parameters_.terms)};
}

std::array<double, Ogden::kNumbers> Ogden::parameter_values() const {
  std::array<double, kNumbers> values{};
  std::size_t next = 0;
  for (const double number : parameters_.mu) values[next++] = number;
  for (const double number : parameters_.alpha) values[next++] = number;
  values[next] = kappa();
  return values;
}

Ogden Ogden::with_values(const double* values) const {
  const double* exponents = values + kMostTerms;
  return {
      {values, values + term_count()}, {exponents, exponents + term_count()}, values[kNumbers - 1]};
}

}  // namespace tetraction
