#include "color_field.h"

#include <algorithm>
#include <cctype>

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

}  // namespace tetraction::viewer
