#include "color_bar.h"

#include <vtkLookupTable.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace tetraction::viewer {
namespace {

// Viridis (S. van der Walt, N. Smith; CC0) at ten places: even to the eye, readable in grey.
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
// Of regions: told apart by people who confuse red and green, too (P. Tol's bright scheme).
constexpr std::array<std::array<double, 3>, 7> kRegions = {{{0.27, 0.47, 0.67},
                                                            {0.93, 0.40, 0.47},
                                                            {0.13, 0.53, 0.20},
                                                            {0.80, 0.73, 0.27},
                                                            {0.40, 0.80, 0.93},
                                                            {0.67, 0.20, 0.47},
                                                            {0.73, 0.73, 0.73}}};

// Less than this is round-off of a body at rest, not something to see.
double least_range(ColorField field) {
  return field == ColorField::kVonMises ? 1e-3 : 1e-9;
}

}  // namespace

const char* field_name(ColorField field) {
  switch (field) {
    case ColorField::kNone:
      return "One colour";
    case ColorField::kDisplacement:
      return "Displacement";
    case ColorField::kSpeed:
      return "Speed";
    case ColorField::kVonMises:
      return "von Mises stress";
    case ColorField::kEnergyDensity:
      return "Energy density";
    case ColorField::kJacobian:
      return "Volume ratio J";
    case ColorField::kRegion:
      return "Region";
  }
  return "";
}

const char* field_unit(ColorField field) {
  switch (field) {
    case ColorField::kDisplacement:
      return "m";
    case ColorField::kSpeed:
      return "m/s";
    case ColorField::kVonMises:
      return "Pa";
    case ColorField::kEnergyDensity:
      return "J/m³";
    default:
      return "";
  }
}

ColorBar::ColorBar(vtkRenderer* renderer) {
  fill(false, 0);
  bar_->SetLookupTable(table_);
  bar_->SetNumberOfLabels(5);
  bar_->SetLabelFormat("%.3g");
  bar_->UnconstrainedFontSizeOn();
  bar_->SetBarRatio(0.22);
  bar_->SetTitleRatio(0.4);
  bar_->SetVerticalTitleSeparation(8);
  bar_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  bar_->SetPosition(0.86, 0.28);
  bar_->SetWidth(0.13);
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
  const bool regions = drawing.field == ColorField::kRegion;
  const int shown = regions ? region_count : 0;
  if (shown != shown_regions_) {
    shown_regions_ = shown;
    fill(regions, region_count);
  }
  if (regions) {
    // Each number in the middle of its colour.
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
  std::string title = field_name(drawing.field);
  if (const std::string unit = field_unit(drawing.field); !unit.empty()) {
    title += "\n[" + unit + "]";
  }
  bar_->SetTitle(title.c_str());
  bar_->GetTitleTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->GetLabelTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->GetAnnotationTextProperty()->SetColor(text_gray, text_gray, text_gray);
  bar_->SetVisibility(drawing.field != ColorField::kNone);
}

void ColorBar::follow(const std::vector<float>& values) {
  if (!drawing_.automatic_range || drawing_.field == ColorField::kRegion || values.empty()) return;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  double low = *least;
  double high = *most;
  if (!std::isfinite(low) || !std::isfinite(high)) return;
  // Magnitudes and densities begin at zero; J has 1 in its middle.
  if (drawing_.field == ColorField::kJacobian) {
    const double spread = std::max({1.0 - low, high - 1.0, 1e-6});
    low = 1.0 - spread;
    high = 1.0 + spread;
  } else {
    low = 0.0;
    high = std::max(high, least_range(drawing_.field));
  }
  // A range that only grows does not flicker; it shrinks slowly once much too large.
  constexpr double kKept = 0.995;
  if (known_) {
    const double middle = drawing_.field == ColorField::kJacobian ? 1.0 : 0.0;
    high = std::max(high, middle + kKept * (high_ - middle));
    low = std::min(low, middle + kKept * (low_ - middle));
  }
  known_ = true;
  low_ = low;
  high_ = high;
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
