#include "vertex_panel.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <cmath>

#include "panel_layout.h"
#include "simulation/scene/setting_keys.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {
namespace {

Vector3 mean(const Vector& field, const std::vector<Index>& vertices) {
  Vector3 sum = Vector3::Zero();
  for (const Index v : vertices) sum += vertex_block(field, v);
  return sum / static_cast<double>(vertices.size());
}

QString triple_text(const Vector3& x, const char* unit) {
  const DisplayUnit shown = display_unit(unit);
  const auto n = [&](double value) { return QString::number(shown.from_si(value), 'g', 4); };
  return QStringLiteral("(%1, %2, %3) %4")
      .arg(n(x.x()), n(x.y()), n(x.z()), QString::fromStdString(shown.text));
}

}  // namespace

QLabel* VertexPanel::add_title(const QString& title, const char* unit) {
  auto* label = new QLabel(this);
  titles_.push_back({label, title, unit});
  return label;
}

void VertexPanel::show_units() {
  for (const Title& title : titles_) {
    title.label->setText(QStringLiteral("%1 [%2]").arg(
        title.text, QString::fromStdString(display_unit(title.unit).text)));
  }
  for (NumberField* field : findChildren<NumberField*>()) field->set_unit(field->unit());
}

VectorFields* VertexPanel::add_vector(QFormLayout* form, const QString& label, const QString& what,
                                      const char* unit) {
  auto* fields = new VectorFields(what, QString::fromUtf8(unit), {-1e12, 1e12}, this);
  editable_.push_back(fields);
  connect(fields, &VectorFields::refused, this, &VertexPanel::refused);
  form->addRow(add_title(label, unit));
  form->addRow(fields);
  return fields;
}

VertexPanel::VertexPanel(QWidget* parent) : QWidget(parent) {
  auto* column = new QVBoxLayout(this);
  auto* chosen = add_group(column, tr("Selection"));
  which_ = new QLabel(this);
  which_->setObjectName(QStringLiteral("which_vertices"));
  which_->setWordWrap(true);
  which_->setAlignment(Qt::AlignTop);
  // The longest text needs three lines. The fields below it stay where they are.
  which_->setFixedHeight(3 * which_->fontMetrics().lineSpacing());
  held_ = new QLabel(this);
  chosen->addRow(which_);
  chosen->addRow(tr("Held"), held_);
  auto* buttons = new QHBoxLayout;
  fix_ = new QPushButton(tr("Fix"), this);
  fix_->setObjectName(QStringLiteral("fix"));
  fix_->setToolTip(tr("Holds the selected vertices where they are (F)"));
  unfix_ = new QPushButton(tr("Unfix"), this);
  unfix_->setObjectName(QStringLiteral("unfix"));
  unfix_->setToolTip(tr("Lets the selected vertices go (U)"));
  name_ = new QPushButton(tr("Name…"), this);
  name_->setObjectName(QStringLiteral("name_selection"));
  name_->setToolTip(tr("Makes a named selection of them, for loads and constraints (N)"));
  buttons->addWidget(fix_);
  buttons->addWidget(unfix_);
  buttons->addWidget(name_);
  chosen->addRow(buttons);

  auto* state = add_group(column, tr("State"));
  position_ =
      add_vector(state, tr("Position"), tr("Position"), key_info(&FixSettings::target).unit);
  position_->field(0)->setObjectName(QStringLiteral("position_x"));
  place_ = new QPushButton(tr("Fix at these coordinates"), this);
  place_->setObjectName(QStringLiteral("place"));
  place_->setToolTip(
      tr("Holds the selection at these coordinates; several vertices keep their shape"));
  state->addRow(place_);
  momentum_ = add_vector(state, tr("Momentum of each"), tr("Momentum"),
                         key_info(&MomentumSettings::value).unit);
  momentum_->field(0)->setObjectName(QStringLiteral("momentum_x"));
  force_ = add_vector(state, tr("Your force on each, beside other loads"), tr("Force"),
                      key_info(&ForceSettings::vector).unit);
  force_->field(0)->setObjectName(QStringLiteral("force_x"));
  speed_ = new QLabel(this);
  speed_->setToolTip(tr("Mean velocity of the selected vertices"));
  reaction_ = new QLabel(this);
  reaction_->setObjectName(QStringLiteral("reaction"));
  reaction_->setToolTip(tr("Sum of what holds the selected vertices did in the last step"));
  state->addRow(new QLabel(tr("Velocity"), this));
  state->addRow(speed_);
  state->addRow(new QLabel(tr("Reaction, all together"), this));
  state->addRow(reaction_);
  for (QLabel* label : {held_, speed_, reaction_}) {  // whose texts must not move the picture
    label->setWordWrap(true);
    label->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  }
  auto* arrows = add_group(column, tr("Arrows pulled with the mouse"));
  force_scale_ =
      new NumberField(tr("Force per length of an arrow"), tr("N/m"), {0.0, 1e15, false}, this);
  momentum_scale_ =
      new NumberField(tr("Momentum per length of an arrow"), tr("kg/s"), {0.0, 1e15, false}, this);
  arrows->addRow(add_title(tr("Force"), "N/m"), force_scale_);
  arrows->addRow(add_title(tr("Momentum"), "kg/s"), momentum_scale_);
  connect(force_scale_, &NumberField::refused, this, &VertexPanel::refused);
  connect(momentum_scale_, &NumberField::refused, this, &VertexPanel::refused);
  column->addStretch(1);
  editable_.insert(editable_.end(), {fix_, unfix_, name_, place_});

  connect(fix_, &QPushButton::clicked, this, &VertexPanel::fix_wanted);
  connect(unfix_, &QPushButton::clicked, this, &VertexPanel::unfix_wanted);
  connect(name_, &QPushButton::clicked, this, &VertexPanel::name_wanted);
  connect(place_, &QPushButton::clicked, this,
          [this] { emit move_wanted(position_->value(), true); });
  connect(position_, &VectorFields::entered, this,
          [this](const EnteredVector& target) { emit move_wanted(target, false); });
  connect(momentum_, &VectorFields::entered, this, &VertexPanel::momentum_wanted);
  connect(force_, &VectorFields::entered, this, &VertexPanel::force_wanted);
  set_selection({}, {});
  show_units();
}

double VertexPanel::force_per_length() const {
  return force_scale_->value();
}

double VertexPanel::momentum_per_length() const {
  return momentum_scale_->value();
}

void VertexPanel::suggest_arrows(const TetMesh& mesh, const LameParameters& lame, double density) {
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3& x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  constexpr double kStrain = 0.1;              // of the elements at the vertex
  constexpr double kWaveSpeedFraction = 0.05;  // velocity of the vertex
  const double volume = mesh.total_volume();
  const double edge = std::cbrt(6.0 * volume / static_cast<double>(mesh.tetrahedron_count()));
  const double arrow = 0.2 * (high - low).norm();
  const double mass = density * volume / static_cast<double>(mesh.vertex_count());
  const auto round = [](double x) { return QString::number(x, 'g', 1).toDouble(); };
  force_scale_->set_value(round(kStrain * 3.0 * lame.mu * edge * edge / arrow));
  momentum_scale_->set_value(round(kWaveSpeedFraction * mass * wave_speed(lame, density) / arrow));
}

void VertexPanel::set_selection(const std::vector<Index>& vertices, const TetMesh& mesh) {
  selection_ = vertices;
  enable_fields();
  if (vertices.empty()) {
    which_->setText(
        tr("Nothing is selected. Click a vertex of the body, or drag a band around "
           "several with Shift held."));
    for (QLabel* label : {held_, reaction_, speed_}) label->setText(QStringLiteral("–"));
  } else if (vertices.size() == 1) {
    which_->setText(tr("Vertex %1").arg(static_cast<qlonglong>(mesh.vertex_id(vertices[0]))));
  } else {
    which_->setText(tr("%1 vertices: means of them are shown").arg(vertices.size()));
  }
}

void VertexPanel::show_state(const Snapshot& snapshot) {
  if (selection_.empty()) return;
  position_->set_value(mean(snapshot.position, selection_));
  momentum_->set_value(mean(snapshot.momentum, selection_));
  // A replay does not know which of the loads came from the user.
  const bool known = snapshot.user_force.size() > 0;
  force_->set_value(mean(known ? snapshot.user_force : snapshot.external_force, selection_));
  speed_->setText(triple_text(mean(snapshot.velocity, selection_), "m/s"));
  reaction_->setText(triple_text(
      mean(snapshot.reaction_force, selection_) * static_cast<double>(selection_.size()), "N"));
  std::size_t held = 0;
  for (const Index v : selection_) held += snapshot.fixed[static_cast<std::size_t>(v)];
  held_->setText(held == 0                   ? tr("no")
                 : held == selection_.size() ? tr("yes")
                                             : tr("%1 of them").arg(held));
  unfix_->setEnabled(may_edit_ && held > 0);
}

void VertexPanel::set_editable(bool editable) {
  may_edit_ = editable;
  enable_fields();
}

void VertexPanel::enable_fields() {
  for (QWidget* widget : editable_) widget->setEnabled(may_edit_ && !selection_.empty());
}

}  // namespace tetraction::viewer
