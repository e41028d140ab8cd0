#include "load_editor.h"

#include <QComboBox>
#include <QFormLayout>
#include <QLabel>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "panel_layout.h"
#include "simulation/scene/setting_keys.h"
#include "viewer/gui/widgets/number_field.h"
#include "viewer/gui/widgets/vector_fields.h"

namespace tetraction::viewer {
namespace {

// "Body force" for body_force.
QString title(LoadKind kind) {
  QString title = QString::fromUtf8(name_of(kind)).replace('_', ' ');
  title[0] = title[0].toUpper();
  return title;
}

// The vector of a load that has one.
const Vector3& vector_of(const ForceSettings& load) {
  if (load.total) return *load.total;
  return load.acceleration ? *load.acceleration : load.vector;
}

// The scene key that has the value which the fields show.
std::string_view key_of(const ForceSettings& load) {
  if (load.kind == LoadKind::kPressure) return "value";
  if (load.total) return "total";
  return load.acceleration ? "acceleration" : "vector";
}

// The unit of that key, with what completes it.
QString unit_of(const ForceSettings& load) {
  const KeyInfo& key = section_of(load.kind).find(key_of(load))->info;
  QString unit = QObject::tr(key.unit);
  if (key.per[0] != '\0') unit += QChar(' ') + QObject::tr(key.per);
  return load.total ? QObject::tr("%1 in all").arg(unit) : unit;
}

}  // namespace

LoadEditor::LoadEditor(QWidget* parent) : QWidget(parent) {
  auto* form = new QFormLayout(this);
  form->setRowWrapPolicy(QFormLayout::WrapLongRows);  // three fields need the whole width
  form->setContentsMargins(0, 0, 0, 0);
  which_ = new QComboBox(this);
  which_->setObjectName(QStringLiteral("load"));
  which_->setToolTip(tr("The loads of the scene and those that were added, with their numbers"));
  form->addRow(tr("Load"), which_);
  value_ = new VectorFields(tr("Load"), QString(), kFinite, this);
  for (int i = 0; i < 3; ++i) {
    value_->field(i)->setObjectName(QStringLiteral("load_%1").arg(QChar('x' + i)));
  }
  connect(value_, &VectorFields::entered, this, &LoadEditor::value_entered);
  connect(value_, &VectorFields::refused, this, &LoadEditor::refused);
  unit_ = new QLabel(this);
  form->addRow(unit_, value_);
  history_ = new QLabel(this);
  history_->setWordWrap(true);
  // A long name must not make the panel wider.
  history_->setMinimumWidth(0);
  history_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  form->addRow(history_);
  connect(which_, QOverload<int>::of(&QComboBox::activated), this, [this] { show_chosen(); });
}

void LoadEditor::show_loads(const LoadLists& loads) {
  loads_ = loads;
  // The kind and the number of each load are kept with its entry. The list is made anew only if it
  // changes, because it may be open, and the same load stays chosen.
  std::vector<QPoint> entries;
  for (const LoadKind kind : values_of<LoadKind>()) {
    for (std::size_t i = 0; i < loads_.list(kind).size(); ++i) {
      entries.emplace_back(static_cast<int>(kind), static_cast<int>(i));
    }
  }
  if (entries != entries_) {
    const QVariant chosen = which_->currentData();
    which_->clear();
    for (const QPoint& entry : entries) {
      which_->addItem(
          QStringLiteral("%1 %2").arg(title(static_cast<LoadKind>(entry.x()))).arg(entry.y()),
          entry);
    }
    which_->setCurrentIndex(std::max(0, which_->findData(chosen)));
    entries_ = std::move(entries);
  }
  setEnabled(which_->count() > 0);
  show_chosen();
}

const ForceSettings& LoadEditor::chosen() const {
  const QPoint place = which_->currentData().toPoint();
  return loads_.list(static_cast<LoadKind>(place.x())).at(static_cast<std::size_t>(place.y()));
}

void LoadEditor::show_chosen() {
  if (which_->count() == 0) {
    unit_->setText(tr("The scene has no loads"));
    value_->hide();
    history_->hide();
    return;
  }
  const ForceSettings& load = chosen();
  const bool is_scalar = load.kind == LoadKind::kPressure;
  for (int i = 1; i < 3; ++i) value_->field(i)->setVisible(!is_scalar);
  value_->set_value(is_scalar ? Vector3(load.value, 0.0, 0.0) : vector_of(load));
  value_->show();
  unit_->setText(tr("Value [%1]").arg(unit_of(load)));
  QString history;
  if (!load.amplitude.empty()) {
    history = tr("times the amplitude \"%1\"").arg(QString::fromStdString(load.amplitude));
  }
  if (load.from > 0.0 || std::isfinite(load.until)) {
    history += (history.isEmpty() ? "" : ", ") +
               tr("from %1 s until %2")
                   .arg(load.from)
                   .arg(std::isfinite(load.until) ? tr("%1 s").arg(load.until) : tr("the end"));
  }
  history_->setText(history);
  history_->setToolTip(history);
  history_->setVisible(!history.isEmpty());
}

void LoadEditor::value_entered() {
  if (which_->count() == 0) return;
  ForceSettings load = chosen();
  const Vector3 value = value_->value();
  QString text = QStringLiteral("[%1, %2, %3]").arg(value.x()).arg(value.y()).arg(value.z());
  if (load.kind == LoadKind::kPressure) {
    load.value = value.x();
    text = QString::number(value.x());
  } else if (load.total) {
    load.total = value;
  } else if (load.acceleration) {
    load.acceleration = value;
  } else {
    load.vector = value;
  }
  const QPoint place = which_->currentData().toPoint();
  emit edited(SetForce{static_cast<std::size_t>(place.y()), load},
              tr("%1: %2 %3").arg(which_->currentText(), text, unit_of(load)), false);
}

}  // namespace tetraction::viewer
