#include "drawing_panel.h"

#include <QCheckBox>
#include <QComboBox>
#include <QGridLayout>
#include <QPushButton>
#include <QSettings>
#include <QSlider>
#include <algorithm>
#include <cmath>

#include "panel_layout.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
namespace {

// The place of a colour in the list, which begins with one colour.
int place_of(ColorField field) {
  return field != nullptr ? field->color.place : 0;
}

ColorField color_at(int place) {
  return place > 0 ? color_quantities()[static_cast<std::size_t>(place) - 1] : nullptr;
}

}  // namespace

QCheckBox* DrawingPanel::add_check(QLayout* layout, const QString& text, const char* name,
                                   const QString& tip, bool DrawingSettings::*flag) {
  auto* check = new QCheckBox(text, this);
  check->setObjectName(QLatin1String(name));
  check->setToolTip(tip);
  layout->addWidget(check);
  flags_.emplace_back(name, flag);
  shows_.emplace_back([this, check, flag] { check->setChecked(drawing_.*flag); });
  connect(check, &QCheckBox::clicked, this, [this, flag](bool on) {
    drawing_.*flag = on;
    emit_changed();
  });
  return check;
}

QSlider* DrawingPanel::add_slider(QFormLayout* form, const QString& text, const char* name,
                                  const QString& tip, int low, int high, double factor,
                                  double DrawingSettings::*value) {
  auto* slider = new QSlider(Qt::Horizontal, this);
  slider->setObjectName(QLatin1String(name));
  slider->setRange(low, high);
  slider->setToolTip(tip);
  form->addRow(text, slider);
  numbers_.emplace_back(name, value);
  shows_.emplace_back([this, slider, factor, value] {
    const QSignalBlocker quiet(slider);
    slider->setValue(static_cast<int>(std::lround(drawing_.*value / factor)));
  });
  connect(slider, &QSlider::valueChanged, this, [this, factor, value](int place) {
    drawing_.*value = place * factor;
    emit_changed();
  });
  return slider;
}

DrawingPanel::DrawingPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);

  auto* body = add_group(column, tr("Body"));
  auto* kinds = new QHBoxLayout;
  add_check(kinds, tr("Surface"), "surface", tr("Draw the body's faces"),
            &DrawingSettings::surface);
  add_check(kinds, tr("Edges"), "edges", tr("Draw the edges of the faces (wireframe)"),
            &DrawingSettings::edges);
  add_check(kinds, tr("Points"), "points", tr("Draw every vertex, also those inside"),
            &DrawingSettings::points);
  body->addRow(kinds);

  auto* color = add_group(column, tr("Colour"));
  field_ = new QComboBox(this);
  field_->setObjectName(QStringLiteral("color_field"));
  field_->setToolTip(tr("What colours the body"));
  field_->addItem(tr("One colour"));
  for (const Quantity* quantity : color_quantities()) {
    const QString unit = QString::fromUtf8(quantity->unit);
    const QString name = QString::fromUtf8(quantity->color.name);
    field_->addItem(unit.isEmpty() ? name : QStringLiteral("%1 [%2]").arg(name, unit));
  }
  color->addRow(tr("By"), field_);
  shows_.emplace_back([this] { field_->setCurrentIndex(place_of(drawing_.field)); });
  connect(field_, QOverload<int>::of(&QComboBox::activated), this, [this](int i) {
    drawing_.field = color_at(i);
    drawing_.automatic_range = true;
    emit_changed();
  });
  auto* range = new QHBoxLayout;
  low_ = new NumberField(tr("Lowest value of the colours"), tr("the field's unit"), {-1e30, 1e30},
                         this);
  high_ = new NumberField(tr("Highest value of the colours"), tr("the field's unit"), {-1e30, 1e30},
                          this);
  low_->setObjectName(QStringLiteral("range_low"));
  high_->setObjectName(QStringLiteral("range_high"));
  range->addWidget(low_);
  range->addWidget(high_);
  color->addRow(tr("From, to"), range);
  auto* fit = new QHBoxLayout;
  add_check(fit, tr("Follow the data"), "automatic_range",
            tr("The colours' range grows with the values"), &DrawingSettings::automatic_range);
  refit_ = new QPushButton(tr("Fit now"), this);
  refit_->setObjectName(QStringLiteral("fit_colors"));
  refit_->setToolTip(tr("Fits the colours to the values of this moment"));
  fit->addWidget(refit_);
  color->addRow(fit);
  connect(refit_, &QPushButton::clicked, this, &DrawingPanel::refit_wanted);
  for (NumberField* end : {low_, high_}) {
    connect(end, &NumberField::refused, this, &DrawingPanel::refused);
    connect(end, &NumberField::entered, this, [this] {
      if (!(low_->value() < high_->value())) {
        show_range(drawing_.range[0], drawing_.range[1]);
        emit refused(tr("Colours: the lowest value must be below the highest."));
        return;
      }
      drawing_.automatic_range = false;
      drawing_.range[0] = low_->value();
      drawing_.range[1] = high_->value();
      emit_changed();
    });
  }

  auto* arrows = add_group(column, tr("Arrows"));
  auto* arrow_kinds = new QHBoxLayout;
  add_check(arrow_kinds, tr("Forces"), "forces", tr("External forces on vertices, N (red)"),
            &DrawingSettings::forces);
  add_check(arrow_kinds, tr("Momenta"), "momenta", tr("Momenta of vertices, kg m/s (blue)"),
            &DrawingSettings::momenta);
  add_check(arrow_kinds, tr("Reactions"), "reactions",
            tr("Forces of what holds vertices, N (green)"), &DrawingSettings::reactions);
  arrows->addRow(arrow_kinds);
  add_slider(arrows, tr("Length"), "arrow_scale",
             tr("Length of the longest arrow, 0.1 to 4 times the usual one"), 1, 40, 0.1,
             &DrawingSettings::arrow_scale);

  auto* more = add_group(column, tr("Also"));
  auto* grid = new QGridLayout;
  auto* left = new QVBoxLayout;
  auto* right = new QVBoxLayout;
  add_check(left, tr("Fixed vertices"), "fixed", tr("Mark vertices that are held"),
            &DrawingSettings::fixed);
  add_check(left, tr("Rest shape"), "rest", tr("The body as it was made, as a wireframe"),
            &DrawingSettings::rest);
  add_check(right, tr("Axes"), "axes", tr("Axes at the origin"), &DrawingSettings::axes);
  add_check(right, tr("Attraction centre"), "center",
            tr("Where the attraction pulls to, while there is one"), &DrawingSettings::center);
  grid->addLayout(left, 0, 0);
  grid->addLayout(right, 0, 1);
  more->addRow(grid);

  auto* clip = add_group(column, tr("Clip plane"));
  auto* clip_row = new QHBoxLayout;
  add_check(clip_row, tr("Cut at"), "clip", tr("Look inside: draw one side of a plane only"),
            &DrawingSettings::clip);
  clip_axis_ = new QComboBox(this);
  clip_axis_->addItems({tr("x"), tr("y"), tr("z")});
  clip_axis_->setObjectName(QStringLiteral("clip_axis"));
  clip_axis_->setToolTip(tr("Normal of the plane"));
  clip_row->addWidget(clip_axis_);
  add_check(clip_row, tr("Other side"), "clip_flipped", tr("Draw the other side"),
            &DrawingSettings::clip_flipped);
  clip->addRow(clip_row);
  add_slider(clip, tr("Place"), "clip_at", tr("Through the rest shape from end to end"), 0, 100,
             0.01, &DrawingSettings::clip_at);
  connect(clip_axis_, QOverload<int>::of(&QComboBox::activated), this, [this](int axis) {
    drawing_.clip_axis = axis;
    emit_changed();
  });
  shows_.emplace_back([this] { clip_axis_->setCurrentIndex(drawing_.clip_axis); });

  auto* light = add_group(column, tr("Light and background"));
  add_slider(
      light, tr("Left, right"), "light_azimuth",
      tr("Light's place, degrees to the right; also by the mouse with Ctrl and the right button"),
      -90, 90, 1.0, &DrawingSettings::light_azimuth);
  add_slider(light, tr("Down, up"), "light_elevation", tr("Light's place, degrees up"), -90, 90,
             1.0, &DrawingSettings::light_elevation);
  background_ = new QComboBox(this);
  background_->addItems({tr("Light"), tr("White"), tr("Dark")});
  background_->setObjectName(QStringLiteral("background"));
  background_->setToolTip(tr("Background of the view"));
  light->addRow(tr("Background"), background_);
  connect(background_, QOverload<int>::of(&QComboBox::activated), this, [this](int i) {
    drawing_.background = static_cast<Background>(i);
    emit_changed();
  });
  shows_.emplace_back(
      [this] { background_->setCurrentIndex(static_cast<int>(drawing_.background)); });
  column->addStretch(1);
  show_all();
}

void DrawingPanel::show_all() {
  for (const auto& show : shows_) show();
}

void DrawingPanel::emit_changed() {
  show_all();
  emit changed(drawing_);
}

void DrawingPanel::show_range(double low, double high) {
  // The range stays the same when the user turns the automatic range off.
  drawing_.range[0] = low;
  drawing_.range[1] = high;
  low_->set_value(low);
  high_->set_value(high);
}

void DrawingPanel::turn_light(double azimuth, double elevation) {
  constexpr double kMost = 90.0;  // the range of the sliders
  drawing_.light_azimuth = std::clamp(drawing_.light_azimuth + azimuth, -kMost, kMost);
  drawing_.light_elevation = std::clamp(drawing_.light_elevation + elevation, -kMost, kMost);
  emit_changed();
}

void DrawingPanel::save(QSettings& settings) const {
  for (const auto& [name, flag] : flags_) {
    settings.setValue(QLatin1String("drawing/") + QLatin1String(name), drawing_.*flag);
  }
  for (const auto& [name, number] : numbers_) {
    settings.setValue(QLatin1String("drawing/") + QLatin1String(name), drawing_.*number);
  }
  settings.setValue(QStringLiteral("drawing/field"), place_of(drawing_.field));
  settings.setValue(QStringLiteral("drawing/background"), static_cast<int>(drawing_.background));
}

void DrawingPanel::load(QSettings& settings) {
  for (const auto& [name, flag] : flags_) {
    drawing_.*flag =
        settings.value(QLatin1String("drawing/") + QLatin1String(name), drawing_.*flag).toBool();
  }
  for (const auto& [name, number] : numbers_) {
    drawing_.*number =
        settings.value(QLatin1String("drawing/") + QLatin1String(name), drawing_.*number)
            .toDouble();
  }
  // These settings belong to one body. They are not restored for the next one.
  drawing_.clip = false;
  drawing_.automatic_range = true;
  const int field =
      settings.value(QStringLiteral("drawing/field"), place_of(drawing_.field)).toInt();
  if (field >= 0 && field < field_->count()) drawing_.field = color_at(field);
  const int background = settings.value(QStringLiteral("drawing/background"), 0).toInt();
  if (background >= 0 && background <= static_cast<int>(Background::kDark)) {
    drawing_.background = static_cast<Background>(background);
  }
  show_all();
}

}  // namespace tetraction::viewer
