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

template <class Choice>
QComboBox* DrawingPanel::add_choice(const char* name, const QString& tip, const QStringList& items,
                                    Choice DrawingSettings::*value) {
  auto* list = new QComboBox(this);
  list->setObjectName(QLatin1String(name));
  list->setToolTip(tip);
  list->addItems(items);
  const auto set = [this, value](int i) { drawing_.*value = static_cast<Choice>(i); };
  lists_.push_back({name, list, set});
  shows_.emplace_back(
      [this, list, value] { list->setCurrentIndex(static_cast<int>(drawing_.*value)); });
  connect(list, QOverload<int>::of(&QComboBox::activated), this, [this, set](int i) {
    set(i);
    emit_changed();
  });
  return list;
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
  auto* looks = new QHBoxLayout;
  add_check(looks, tr("Smooth"), "smooth", tr("Shade the surface as a curved one"),
            &DrawingSettings::smooth);
  body->addRow(looks);
  body->addRow(tr("Antialiasing"), add_choice("antialiasing", tr("Smooth edges of the picture"),
                                              {tr("with a graphics card"), tr("off"), tr("on")},
                                              &DrawingSettings::antialiasing));
  add_slider(body, tr("Opacity"), "opacity",
             tr("Look through the surface; slow without a graphics card"), 10, 100, 0.01,
             &DrawingSettings::opacity);
  scale_ = new NumberField(tr("Factor of the displacements that are drawn"), {}, {0.0, 1e9}, this);
  scale_->setObjectName(QStringLiteral("displacement_scale"));
  body->addRow(tr("Displacements ×"), scale_);
  shows_.emplace_back([this] { scale_->set_value(drawing_.displacement_scale); });
  connect(scale_, &NumberField::refused, this, &DrawingPanel::refused);
  connect(scale_, &NumberField::entered, this, [this](double factor) {
    drawing_.displacement_scale = factor;
    emit_changed();
  });

  auto* color = add_group(column, tr("Colour"));
  field_ = new QComboBox(this);
  field_->setObjectName(QStringLiteral("color_field"));
  field_->setToolTip(tr("What colours the body"));
  for (const ColorField& field : color_fields()) {
    field_->addItem(field == nullptr ? tr("One colour") : QString::fromStdString(field.title()));
  }
  color->addRow(tr("By"), field_);
  shows_.emplace_back([this] {
    const auto place = std::ranges::find(color_fields(), drawing_.field) - color_fields().begin();
    field_->setCurrentIndex(static_cast<int>(place));
    const QString unit =
        drawing_.field == nullptr ? QString() : QString::fromUtf8(drawing_.field->unit);
    for (NumberField* end : {low_, high_}) {
      if (end->unit() != unit) end->set_unit(unit);
    }
  });
  connect(field_, QOverload<int>::of(&QComboBox::activated), this,
          [this](int i) { color_by(color_fields()[static_cast<std::size_t>(i)]); });
  color->addRow(tr("Map"),
                add_choice("color_map", tr("The colours from the lowest to the highest value"),
                           {tr("Viridis"), tr("Cividis"), tr("Cool to warm"), tr("Grey")},
                           &DrawingSettings::map));
  auto* ways = new QHBoxLayout;
  add_check(ways, tr("Averaged"), "averaged",
            tr("Average the values of tetrahedra at their vertices"), &DrawingSettings::averaged);
  add_check(ways, tr("Shaded"), "shaded",
            tr("Faces away from the light are darker than the colour bar"),
            &DrawingSettings::shaded);
  add_check(ways, tr("Min, max"), "extremes", tr("Mark the lowest and the highest value"),
            &DrawingSettings::extremes);
  color->addRow(ways);
  auto* range = new QHBoxLayout;
  low_ = new NumberField(tr("Lowest value of the colours"), {}, {-1e30, 1e30}, this);
  high_ = new NumberField(tr("Highest value of the colours"), {}, {-1e30, 1e30}, this);
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
  auto* more_kinds = new QHBoxLayout;
  add_check(more_kinds, tr("Contact"), "contacts",
            tr("Forces of obstacles on vertices, without friction, N (amber)"),
            &DrawingSettings::contacts);
  arrows->addRow(more_kinds);
  add_slider(arrows, tr("Length"), "arrow_scale",
             tr("Length of the longest arrow, 0.1 to 4 times the usual one"), 1, 40, 0.1,
             &DrawingSettings::arrow_scale);

  auto* more = add_group(column, tr("Marks"));
  auto* grid = new QGridLayout;
  auto* left = new QVBoxLayout;
  auto* right = new QVBoxLayout;
  add_check(left, tr("Fixed vertices"), "fixed", tr("Mark vertices that are held"),
            &DrawingSettings::fixed);
  add_check(left, tr("Rest shape"), "rest", tr("The body as it was made, as a wireframe"),
            &DrawingSettings::rest);
  add_check(left, tr("Ghost"), "ghost",
            tr("The shape that View → Keep as ghost has kept, as a wireframe"),
            &DrawingSettings::ghost);
  add_check(right, tr("Axes"), "axes", tr("Axes at the origin"), &DrawingSettings::axes);
  add_check(right, tr("Attraction centre"), "center",
            tr("Where the attraction pulls to, while there is one"), &DrawingSettings::center);
  add_check(left, tr("Obstacles"), "obstacles",
            tr("Planes, spheres, cylinders and boxes that the body may touch"),
            &DrawingSettings::obstacles);
  add_check(right, tr("Cube"), "cube", tr("Axes in the corner; a click on a face looks from there"),
            &DrawingSettings::cube);
  grid->addLayout(left, 0, 0);
  grid->addLayout(right, 0, 1);
  more->addRow(grid);

  auto* clip = add_group(column, tr("Clip plane"));
  auto* clip_row = new QHBoxLayout;
  add_check(clip_row, tr("Cut at"), "clip", tr("Look inside: draw one side of a plane only"),
            &DrawingSettings::clip);
  clip_row->addWidget(add_choice("clip_axis", tr("Normal of the plane"),
                                 {tr("x"), tr("y"), tr("z")}, &DrawingSettings::clip_axis));
  add_check(clip_row, tr("Other side"), "clip_flipped", tr("Draw the other side"),
            &DrawingSettings::clip_flipped);
  clip->addRow(clip_row);
  add_slider(clip, tr("Place"), "clip_at", tr("Through the rest shape from end to end"), 0, 100,
             0.01, &DrawingSettings::clip_at);

  auto* light = add_group(column, tr("Light and background"));
  add_slider(
      light, tr("Left, right"), "light_azimuth",
      tr("Light's place, degrees to the right; also by the mouse with Ctrl and the right button"),
      -90, 90, 1.0, &DrawingSettings::light_azimuth);
  add_slider(light, tr("Down, up"), "light_elevation", tr("Light's place, degrees up"), -90, 90,
             1.0, &DrawingSettings::light_elevation);
  light->addRow(tr("Background"),
                add_choice("background", tr("Background of the view"),
                           {tr("As the window"), tr("Light"), tr("White"), tr("Dark")},
                           &DrawingSettings::background));

  auto* selection = add_group(column, tr("Selection"));
  add_slider(
      selection, tr("Face angle"), "face_angle",
      tr("Ctrl+Shift and a click select a face: triangles whose neighbours differ by less than "
         "this, degrees"),
      1, 90, 1.0, &DrawingSettings::face_angle);
  column->addStretch(1);
  show_units();
  show_all();
}

void DrawingPanel::show_units() {
  for (int i = 1; i < field_->count(); ++i) {
    const ColorField& field = color_fields()[static_cast<std::size_t>(i)];
    const std::string unit = display_unit(field->unit).text;
    field_->setItemText(
        i, QString::fromStdString(field.title() + (unit.empty() ? "" : " [" + unit + "]")));
  }
  for (NumberField* end : {low_, high_}) end->set_unit(end->unit());
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

void DrawingPanel::color_by(ColorField field) {
  drawing_.field = field;
  drawing_.automatic_range = true;
  emit_changed();
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
  for (const List& choice : lists_) {
    settings.setValue(QLatin1String("drawing/") + QLatin1String(choice.name),
                      choice.list->currentIndex());
  }
  settings.setValue(QStringLiteral("drawing/color"), QString::fromStdString(drawing_.field.key()));
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
  for (const List& choice : lists_) {
    const int i = settings.value(QLatin1String("drawing/") + QLatin1String(choice.name), 0).toInt();
    if (i >= 0 && i < choice.list->count()) choice.set(i);
  }
  const std::string color =
      settings.value(QStringLiteral("drawing/color"), QString::fromStdString(drawing_.field.key()))
          .toString()
          .toStdString();
  const auto found = std::ranges::find(color_fields(), color, &ColorField::key);
  if (found != color_fields().end()) drawing_.field = *found;
  show_all();
}

}  // namespace tetraction::viewer
