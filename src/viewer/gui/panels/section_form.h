// The fields of a section of the scene.
#pragma once

#include <QObject>
#include <vector>

#include "simulation/scene/setting_keys.h"

class QFormLayout;

namespace tetraction::viewer {

class NumberSlider;

/// A row for each number of a section that has a usual range (KeyInfo::usual).
class SectionForm : public QObject {
  Q_OBJECT

 public:
  SectionForm(const SceneSection& section, QFormLayout* form, QObject* parent = nullptr);
  /// Shows the values of settings of the section.
  void show_settings(const void* settings);
  /// Puts the values of the fields into settings of the section.
  void read(void* settings) const;

 signals:
  /// The user has entered a value. `what` names it, as "Drag 2 kg/s".
  void edited(const QString& what, bool continues_previous);
  void refused(const QString& message);

 private:
  struct Row {
    const SceneKey* key;
    NumberSlider* slider;
  };
  std::vector<Row> rows_;
};

}  // namespace tetraction::viewer
