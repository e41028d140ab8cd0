#include "color_bar.h"

#include <vtkLookupTable.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace tetraction::viewer {
namespace {

// Ten colours of Viridis (S. van der Walt, N. Smith; CC0), which is perceptually uniform.
constexpr std::array<std::array<double, 3>, 10> kViridis = {{{0.267, 0.005, 0.329},
                                                             {0.283, 0.141, 0.458},
                                                             {0.254, 0.265, 0.530},
                                                             {0.207, 0.372, 0.553},
                                                             {0.164, 0.471, 0.558},
                                                             {0.128, 0.567, 0.551},
                                                             {0.135, 0.659, 0.518},
                                                             {0.267, 0.749, 0.441},
                                                             {0.478, 0.821, 0.318},
                                                             {0.741, 0.873, 0.150}}};
// Colours of regions, which colour-blind people can distinguish (P. Tol's bright scheme).
constexpr std::array<std::array<double, 3>, 7> kRegions = {{{0.27, 0.47, 0.67},
                                                            {0.93, 0.40, 0.47},
                                                            {0.13, 0.53, 0.20},
                                                            {0.80, 0.73, 0.27},
                                                            {0.40, 0.80, 0.93},
                                                            {0.67, 0.20, 0.47},
                                                            {0.73, 0.73, 0.73}}};

// The least range. Values below it are round-off of a body at rest.
double least_range(const Quantity& quantity) {
  return quantity.unit == std::string_view("Pa") ? 1e-3 : 1e-9;
}

// The smallest number with one or two digits that is not below x > 0.
double round_up(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  constexpr double kSlack = 1e-9;  // for round-off: 3 × 0.1 is above 0.3
  for (const double digits : {1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (x <= digits * power * (1.0 + kSlack)) return digits * power;
  }
  return 10.0 * power;
}

}  // namespace

ColorBar::ColorBar(vtkRenderer* renderer) {
  fill(false, 0);
  bar_->SetLookupTable(table_);
  bar_->SetNumberOfLabels(5);
  bar_->SetLabelFormat("%.3g");
  bar_->UnconstrainedFontSizeOn();
  bar_->SetBarRatio(0.17);
  bar_->SetTitleRatio(0.4);
  bar_->SetVerticalTitleSeparation(8);
  bar_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  bar_->SetPosition(0.04, 0.2);
  bar_->SetWidth(0.92);
  bar_->SetHeight(0.62);
  for (vtkTextProperty* text : {bar_->GetTitleTextProperty(), bar_->GetLabelTextProperty()}) {
    text->SetFontFamilyToArial();
    text->SetBold(false);
    text->SetItalic(false);
    text->SetShadow(false);
    text->SetFontSize(13);
  }
  bar_->VisibilityOff();
  renderer->AddActor2D(bar_);
}

ColorBar::~ColorBar() = default;

void ColorBar::fill(bool categories, int count) {
  if (categories) {
    table_->SetNumberOfTableValues(std::max(1, count));
    for (int i = 0; i < std::max(1, count); ++i) {
      const auto& c = kRegions[static_cast<std::size_t>(i) % kRegions.size()];
      table_->SetTableValue(i, c[0], c[1], c[2]);
    }
    return;
  }
  constexpr int kShades = 256;
  table_->SetNumberOfTableValues(kShades);
  for (int i = 0; i < kShades; ++i) {
    const double x = i * (static_cast<double>(kViridis.size()) - 1.0) / (kShades - 1);
    const auto k = std::min(static_cast<std::size_t>(x), kViridis.size() - 2);
    const double t = x - static_cast<double>(k);
    double c[3];
    for (std::size_t j = 0; j < 3; ++j) c[j] = (1.0 - t) * kViridis[k][j] + t * kViridis[k + 1][j];
    table_->SetTableValue(i, c[0], c[1], c[2]);
  }
}

void ColorBar::set(const DrawingSettings& drawing, int region_count, double text_gray) {
  if (drawing.field != drawing_.field || drawing.automatic_range != drawing_.automatic_range) {
    known_ = false;
  }
  drawing_ = drawing;
  const Quantity* field = drawing.field;
  const bool regions = field != nullptr && field->is_integral;
  const int shown = regions ? region_count : 0;
  if (shown != shown_regions_) {
    shown_regions_ = shown;
    fill(regions, region_count);
  }
  if (regions) {
    // The number of a region is in the middle of its colour.
    low_ = -0.5;
    high_ = std::max(1, region_count) - 0.5;
  } else if (!drawing.automatic_range) {
    low_ = drawing.range[0];
    high_ = drawing.range[1];
  }
  table_->SetTableRange(low_, high_);
  bar_->SetNumberOfLabels(5);
  table_->ResetAnnotations();
  bar_->SetDrawTickLabels(!regions);
  bar_->SetDrawAnnotations(regions);
  if (regions) {
    for (int i = 0; i < region_count; ++i) table_->SetAnnotation(i, std::to_string(i));
  }
  std::string title = field != nullptr ? field->color.name : "";
  if (field != nullptr && *field->unit != '\0') title += std::string("\n[") + field->unit + "]";
  bar_->SetTitle(title.c_str());
  bar_->GetTitleTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->GetLabelTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->GetAnnotationTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->SetVisibility(field != nullptr);
}

void ColorBar::follow(const std::vector<float>& values) {
  const Quantity* field = drawing_.field;
  if (!drawing_.automatic_range || field == nullptr || field->is_integral || values.empty()) return;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (!std::isfinite(*least) || !std::isfinite(*most)) return;
  const std::optional<double> middle = field->color.middle;
  const double spread = middle ? std::max({*middle - *least, *most - *middle, 1e-6})
                               : std::max<double>(*most, least_range(*field));
  // A range that changes in every picture cannot be read. Therefore it grows in steps, and it shrinks
  // only after it has been much too large for many pictures.
  constexpr double kMuchTooLarge = 0.4;
  constexpr int kPicturesBeforeShrinking = 60;
  too_large_ = spread < kMuchTooLarge * spread_ ? too_large_ + 1 : 0;
  if (known_ && spread <= spread_ && too_large_ < kPicturesBeforeShrinking) return;
  known_ = true;
  too_large_ = 0;
  spread_ = round_up(spread);
  low_ = middle ? *middle - spread_ : 0.0;
  high_ = middle ? *middle + spread_ : spread_;
  table_->SetTableRange(low_, high_);
}

void ColorBar::forget_range() {
  known_ = false;
}

double ColorBar::low() const {
  return low_;
}

double ColorBar::high() const {
  return high_;
}

}  // namespace tetraction::viewer
