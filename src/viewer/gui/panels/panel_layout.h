// The common layout of the panels.
#pragma once

#include <QFormLayout>
#include <QGroupBox>
#include <QVBoxLayout>

namespace tetraction::viewer {

/// Adds a group with a title to the end of a column. Its rows consist of a label and a widget.
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
