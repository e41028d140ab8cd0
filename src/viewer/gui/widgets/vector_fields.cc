#include "vector_fields.h"

#include <QApplication>
#include <QHBoxLayout>
#include <algorithm>
#include <utility>

#include "number_field.h"

namespace tetraction::viewer {

Vector3 EnteredVector::over(const Vector3& present) const {
  Vector3 result = present;
  for (int i = 0; i < 3; ++i) {
    if (typed[static_cast<std::size_t>(i)]) result[i] = value[i];
  }
  return result;
}

VectorFields::VectorFields(const QString& what, const QString& unit, const NumberRange& range,
                           QWidget* parent)
    : QWidget(parent) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  for (std::size_t i = 0; i < 3; ++i) {
    fields_[i] = new NumberField(tr("%1, %2").arg(what).arg(QChar('x' + static_cast<int>(i))), unit,
                                 range, this);
    row->addWidget(fields_[i]);
    connect(fields_[i], &NumberField::entered, this, [this, i] {
      typed_[i] = true;
      if (!has_focus()) commit();
    });
    connect(fields_[i], &NumberField::left, this, [this] {
      if (!has_focus()) commit();
    });
    connect(fields_[i], &NumberField::finished, this, &VectorFields::commit);
    connect(fields_[i], &NumberField::refused, this, &VectorFields::refused);
  }
}

Vector3 VectorFields::value() const {
  return {fields_[0]->value(), fields_[1]->value(), fields_[2]->value()};
}

void VectorFields::set_value(const Vector3& value) {
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!typed_[k]) fields_[k]->set_value(value[i]);
  }
}

void VectorFields::set_none() {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!typed_[i]) fields_[i]->set_text_value({});
  }
}

bool VectorFields::has_focus() const {
  return std::find(fields_.begin(), fields_.end(), QApplication::focusWidget()) != fields_.end();
}

void VectorFields::commit() {
  const std::array<bool, 3> typed = std::exchange(typed_, {});
  if (typed[0] || typed[1] || typed[2]) emit entered({value(), typed});
}

}  // namespace tetraction::viewer
