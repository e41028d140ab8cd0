// Shows the loads of the body, one at a time, and changes their values.
#pragma once

#include <QPoint>
#include <QWidget>
#include <vector>

#include "viewer/simulation.h"

class QComboBox;
class QFormLayout;
class QLabel;

namespace tetraction::viewer {

class VectorFields;

class LoadEditor : public QWidget {
  Q_OBJECT

 public:
  explicit LoadEditor(QWidget* parent = nullptr);
  void show_loads(const LoadLists& loads);

 signals:
  void edited(tetraction::Edit edit, const QString& what, bool continues_previous);
  void refused(const QString& message);

 private:
  void show_chosen();
  void value_entered();
  const ForceSettings& chosen() const;

  LoadLists loads_;
  std::vector<QPoint> entries_;  // kind and number of each load in the list
  QComboBox* which_;
  QLabel* unit_;
  QLabel* history_;
  VectorFields* value_;
};

}  // namespace tetraction::viewer
