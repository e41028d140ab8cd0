// A formula of a scene, as text.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace tetraction {

/// A formula in variables with given names. It may contain numbers with a decimal point, whatever
/// the locale, pi, the operators + - * / ^, comparisons, && || ?: and the functions of muParser: sin,
/// cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, asinh, acosh, atanh, exp, ln, log (natural),
/// log2, log10, sqrt, abs, sign, rint, min, max, sum, avg.
class Formula {
 public:
  /// Throws InputError if the formula is wrong. The message begins with the formula and names the
  /// position of the mistake, counted from 1.
  Formula(const std::string& text, const std::vector<std::string>& variables);
  ~Formula();
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;

  /// The value for these values of the variables. It may be NaN or infinite.
  double operator()(const std::vector<double>& values) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
