// The panel of environment, loads and damping.
#pragma once

#include <QWidget>

#include "viewer/simulation.h"

class QComboBox;
class QLabel;

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
  void damping_edited(const QString& what, bool continues_previous);
  void environment_edited(bool continues_previous);
  void show_environment();

  Damping damping_;
  EnvironmentSettings environment_;
  QComboBox* kind_;
  LoadEditor* loads_;
  NumberSlider *gravity_, *attraction_;
  VectorFields* direction_;
  Vector3 typed_direction_ = Vector3::Zero();  // not normalised
  NumberField* softening_;
  QLabel* amplitude_;
  NumberSlider *drag_, *mass_damping_, *viscosity_;
};

}  // namespace tetraction::viewer
