// The panel of environment, loads and damping.
#pragma once

#include <QWidget>
#include <functional>
#include <vector>

#include "viewer/simulation.h"

class QComboBox;
class QLabel;
class QVBoxLayout;

namespace tetraction::viewer {

class LoadEditor;
class NumberField;
class NumberSlider;
class VectorFields;

class SurroundingsPanel : public QWidget {
  Q_OBJECT

 public:
  explicit SurroundingsPanel(QWidget* parent = nullptr);
  void show_settings(const Settings& settings);

 signals:
  void edited(tetraction::Edit edit, const QString& what, bool continues_previous);
  void refused(const QString& message);

 private:
  template <class Section>
  void add_form(QVBoxLayout* column, Section ChangeableSections::*member);
  void environment_edited(bool continues_previous);
  void show_environment();

  ChangeableSections present_;
  EnvironmentSettings environment_;           // what the fields show
  std::vector<std::function<void()>> forms_;  // show the present settings
  QComboBox* kind_;
  LoadEditor* loads_;
  NumberSlider *gravity_, *attraction_;
  VectorFields* direction_;
  Vector3 typed_direction_ = Vector3::Zero();  // not normalised
  NumberField* softening_;
  QLabel* amplitude_;
};

}  // namespace tetraction::viewer
