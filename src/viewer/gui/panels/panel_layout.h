// The common layout of the panels.
#pragma once

#include <QFormLayout>
#include <QGroupBox>
#include <QVBoxLayout>
#include <limits>

namespace tetraction::viewer {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A number with four digits, for labels and the names of edits.
inline QString short_number(double value) {
  return QString::number(value, 'g', 4);
}

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
