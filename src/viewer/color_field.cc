#include "color_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace tetraction::viewer {
namespace {

const char* ending(const ColorField& field) {
  if (field.component < 0) return "";
  return component_endings(field->shape)[static_cast<std::size_t>(field.component)];
}

}  // namespace

std::string ColorField::title() const {
  if (quantity == nullptr) return {};
  if (component < 0) return quantity->color.name;
  std::string text = key();
  std::ranges::replace(text, '_', ' ');
  text.front() = static_cast<char>(std::toupper(text.front()));
  return text;
}

std::string ColorField::key() const {
  return quantity == nullptr ? std::string() : quantity->name + std::string(ending(*this));
}

std::optional<double> ColorField::middle() const {
  if (quantity == nullptr) return {};
  return component < 0 ? quantity->color.middle : 0.0;
}

const std::vector<ColorField>& color_fields() {
  static const std::vector<ColorField> all = [] {
    std::vector<ColorField> list{nullptr};
    for (const Quantity* quantity : color_quantities()) {
      const auto count = static_cast<int>(component_endings(quantity->shape).size());
      // A tensor has no length that would mean something.
      if (quantity->shape == ValueShape::kScalar || quantity->shape == ValueShape::kVector) {
        list.emplace_back(quantity);
      }
      for (int i = 0; count > 1 && i < count; ++i) list.emplace_back(quantity, i);
    }
    return list;
  }();
  return all;
}

std::vector<float> color_values(const Matrix& values, int component) {
  std::vector<float> result(static_cast<std::size_t>(values.cols()));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto column = values.col(static_cast<Index>(i));
    const bool known = component >= 0 && component < column.size();
    result[i] = static_cast<float>(known                ? column[component]
                                   : column.size() == 1 ? column[0]
                                                        : column.norm());
  }
  return result;
}

PrefixedUnit prefixed_unit(double size, const std::string& unit) {
  static constexpr std::array kPrefixes{"n", "µ", "m", "", "k", "M", "G", "T"};
  constexpr int kNone = 3;
  if (unit.empty() || unit.starts_with("kg") || !(size > 0.0) || !std::isfinite(size)) {
    return {1.0, unit};
  }
  // The slack is for round-off: 1000 × (1 − 1e-12) is written as 1 k.
  const int power = static_cast<int>(std::floor(std::log10(size * (1.0 + 1e-9)) / 3.0));
  const int place = std::clamp(power + kNone, 0, static_cast<int>(kPrefixes.size()) - 1);
  return {std::pow(1000.0, place - kNone), kPrefixes[static_cast<std::size_t>(place)] + unit};
}

std::string with_prefix(double value, const std::string& unit) {
  const PrefixedUnit prefixed = prefixed_unit(std::abs(value), unit);
  const std::string number = fmt::format("{:.3g}", value / prefixed.factor);
  return unit.empty() ? number : number + " " + prefixed.unit;
}

}  // namespace tetraction::viewer
