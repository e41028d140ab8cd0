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

#include "viewer/display_units.h"
#include "viewer/gui/widgets/theme.h"

namespace tetraction::viewer {
namespace {

using Map = std::array<int, 10>;
// Ten colours of each map at equal distances: Viridis (S. van der Walt, N. Smith; CC0) and Cividis (J. Nunez,
// C. Anderton, R. Renslow; CC0), which are perceptually uniform; the diverging map of K. Moreland (2009); grey.
constexpr std::array kMaps{Map{0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779,
                               0x6ece58, 0xb5de2b, 0xfde725},
                           Map{0x00224e, 0x123570, 0x3b496c, 0x575d6d, 0x707173, 0x8a8678, 0xa59c74,
                               0xc3b369, 0xe1cc55, 0xfee838},
                           Map{0x3b4cc0, 0x5d7ce6, 0x82a6fb, 0xaac7fd, 0xcdd9ec, 0xead4c8, 0xf7b89c,
                               0xf18d6f, 0xd95847, 0xb40426},
                           Map{0x1a1a1a, 0x323232, 0x4a4a4a, 0x626262, 0x7a7a7a, 0x929292, 0xaaaaaa,
                               0xc2c2c2, 0xdadada, 0xf2f2f2}};
// Colours of regions, which colour-blind people can distinguish (P. Tol's bright scheme).
constexpr std::array kRegions{0x4477aa, 0xee6677, 0x228833, 0xccbb44, 0x66ccee, 0xaa3377, 0xbbbbbb};

double part(int color, int channel) {
  return (color >> (16 - 8 * channel) & 0xff) / 255.0;
}

// The least range. Values below it are round-off of a body at rest.
double least_range(const Quantity& quantity) {
  if (quantity.unit == std::string_view("Pa")) return 1e-3;
  return *quantity.unit == '\0' ? 1e-6 : 1e-9;
}

bool follows_from_strains(const Quantity& quantity) {
  const std::string_view unit = quantity.unit;
  return unit == "Pa" || unit == "J/m³";
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
  bar_->SetLookupTable(bar_table_);
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
  for (vtkTextProperty* text : {bar_->GetTitleTextProperty(), bar_->GetLabelTextProperty(),
                                bar_->GetAnnotationTextProperty()}) {
    set_type_face(text, TextSize::kNormal);
  }
  bar_->VisibilityOff();
  renderer->AddActor2D(bar_);
}

ColorBar::~ColorBar() = default;

void ColorBar::fill(bool categories, int count) {
  constexpr int kShades = 256;
  const Map& map = kMaps[static_cast<std::size_t>(drawing_.map)];
  const int size = categories ? std::max(1, count) : kShades;
  table_->SetNumberOfTableValues(size);
  for (int i = 0; i < size; ++i) {
    const double x = categories ? 0.0 : i * (static_cast<double>(map.size()) - 1.0) / (kShades - 1);
    const auto k = std::min(static_cast<std::size_t>(x), map.size() - 2);
    const int region = kRegions[static_cast<std::size_t>(i) % kRegions.size()];
    const int low = categories ? region : map[k];
    const int high = categories ? region : map[k + 1];
    double c[3];
    for (int j = 0; j < 3; ++j) {
      c[j] = part(low, j) + (x - static_cast<double>(k)) * (part(high, j) - part(low, j));
    }
    table_->SetTableValue(i, c[0], c[1], c[2]);
  }
}

void ColorBar::set(const DrawingSettings& drawing, int region_count, double text_gray) {
  if (drawing.field != drawing_.field || drawing.automatic_range != drawing_.automatic_range) {
    known_ = false;
  }
  drawing_ = drawing;
  const bool regions = drawing.field != nullptr && drawing.field->is_integral;
  fill(regions, region_count);
  if (regions) {
    // The number of a region is in the middle of its colour.
    low_ = -0.5;
    high_ = std::max(1, region_count) - 0.5;
  } else if (!drawing.automatic_range) {
    low_ = drawing.range[0];
    high_ = drawing.range[1];
  }
  bar_->SetDrawTickLabels(!regions);
  bar_->SetDrawAnnotations(regions);
  for (vtkTextProperty* text : {bar_->GetTitleTextProperty(), bar_->GetLabelTextProperty(),
                                bar_->GetAnnotationTextProperty()}) {
    text->SetColor(text_gray, text_gray, text_gray);
  }
  bar_->SetVisibility(drawing.field != nullptr && (known_ || has_fixed_range()));
  show_range();
}

bool ColorBar::has_fixed_range() const {
  return !drawing_.automatic_range || drawing_.field == nullptr || drawing_.field->is_integral;
}

// The bar has a table of its own, because its numbers have a prefix of the unit.
void ColorBar::show_range() {
  table_->SetTableRange(low_, high_);
  bar_table_->DeepCopy(table_);
  if (drawing_.field == nullptr) return;
  std::string title = drawing_.field.title();
  const DisplayUnit unit =
      display_unit(drawing_.field->unit, std::max(std::abs(low_), std::abs(high_)));
  bar_table_->SetTableRange(unit.from_si(low_), unit.from_si(high_));
  bar_table_->ResetAnnotations();
  if (drawing_.field->is_integral) {
    for (int i = 0; i < bar_table_->GetNumberOfTableValues(); ++i) {
      bar_table_->SetAnnotation(i, std::to_string(i));
    }
  } else if (!unit.text.empty()) {
    title += "\n[" + unit.text + "]";
  }
  bar_->SetTitle(title.c_str());
}

bool ColorBar::follow(const std::vector<float>& values, const std::function<bool()>& is_strained) {
  const ColorField& field = drawing_.field;
  if (has_fixed_range()) return true;
  if (values.empty()) return known_;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (!std::isfinite(*least) || !std::isfinite(*most)) return known_;
  const std::optional<double> middle = field.middle();
  const double floor = least_range(*field);
  const double spread =
      middle ? std::max(*middle - *least, *most - *middle) : static_cast<double>(*most);
  if (!known_ && (!(spread > floor) || (follows_from_strains(*field) && !is_strained()))) {
    low_ = middle ? *middle - floor : 0.0;
    high_ = middle ? *middle + floor : floor;
    show_range();
    bar_->VisibilityOff();  // the body is grey
    return false;
  }
  bar_->VisibilityOn();
  // A range that changes in every picture cannot be read. Therefore it grows in steps, and it shrinks
  // only after it has been much too large for many pictures.
  constexpr double kMuchTooLarge = 0.4;
  constexpr int kPicturesBeforeShrinking = 60;
  too_large_ = spread < kMuchTooLarge * spread_ ? too_large_ + 1 : 0;
  if (known_ && spread <= spread_ && too_large_ < kPicturesBeforeShrinking) return true;
  known_ = true;
  too_large_ = 0;
  spread_ = round_up(std::max(spread, floor));
  low_ = middle ? *middle - spread_ : 0.0;
  high_ = middle ? *middle + spread_ : spread_;
  show_range();
  return true;
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
