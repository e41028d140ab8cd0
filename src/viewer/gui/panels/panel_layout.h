// How panels are laid out, the same everywhere.
#pragma once

#include <QFormLayout>
#include <QGroupBox>
#include <QVBoxLayout>

namespace tetraction::viewer {

/// A titled group of rows "label, widget" at the end of a column.
inline QFormLayout* add_group(QVBoxLayout* column, const QString& title) {
  auto* group = new QGroupBox(title);
  auto* form = new QFormLayout(group);
  form->setContentsMargins(8, 6, 8, 6);
  form->setVerticalSpacing(5);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  column->addWidget(group);
  return form;
}

}  // namespace tetraction::viewer
