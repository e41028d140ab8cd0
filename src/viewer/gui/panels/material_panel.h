// The panel of materials, by region.
#pragma once

#include <QWidget>
#include <utility>
#include <vector>

#include "viewer/simulation.h"

class QComboBox;
class QLabel;

namespace tetraction::viewer {

class NumberField;
class NumberSlider;

/// Model and parameters of a region, as small-strain Young's modulus and Poisson's ratio whatever the
/// scene gave.
class MaterialPanel : public QWidget {
  Q_OBJECT

 public:
  explicit MaterialPanel(QWidget* parent = nullptr);
  void show_settings(const Settings& settings);

 signals:
  void edited(tetraction::Edit edit, const QString& what, bool goes_on);
  void refused(const QString& message);

 private:
  void show_region();
  void commit(const QString& what, bool goes_on);

  std::vector<MaterialSettings> materials_;
  QComboBox *region_, *model_;
  QComboBox* volumetric_;
  NumberSlider *young_, *poisson_;
  // What the models take beside these, each parameter once.
  std::vector<std::pair<const MaterialKey*, NumberField*>> beside_;
  QLabel *lame_, *density_, *wave_;
};

}  // namespace tetraction::viewer
