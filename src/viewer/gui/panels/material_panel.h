// The panel of the materials of the regions.
#pragma once

#include <QWidget>
#include <utility>
#include <vector>

#include "viewer/simulation.h"

class QComboBox;
class QFormLayout;
class QLabel;

namespace tetraction::viewer {

class NumberField;
class NumberSlider;

/// Shows the model and the parameters of a region. Young's modulus and Poisson's ratio of small strains
/// are shown even if the scene gives other parameters.
class MaterialPanel : public QWidget {
  Q_OBJECT

 public:
  explicit MaterialPanel(QWidget* parent = nullptr);
  void show_settings(const Settings& settings);

 signals:
  void edited(tetraction::Edit edit, const QString& what, bool continues_previous);
  void refused(const QString& message);

 private:
  void show_region();
  void commit(const QString& what, bool continues_previous);
  MaterialSettings entered(const MaterialSettings& before) const;

  std::vector<MaterialSettings> materials_;
  std::vector<LameRange> moduli_;
  QFormLayout* form_;  // of the material
  QComboBox *region_, *model_;
  QComboBox* volumetric_;
  NumberSlider *young_, *poisson_;
  // The fields of the other parameters of all models.
  std::vector<std::pair<MaterialParameter, NumberField*>> other_fields_;
  QLabel *lame_, *density_, *wave_;
};

}  // namespace tetraction::viewer
