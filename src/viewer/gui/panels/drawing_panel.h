// The panel of the drawing settings.
#pragma once

#include <QWidget>
#include <functional>
#include <vector>

#include "viewer/gui/body/drawing_settings.h"

class QCheckBox;
class QFormLayout;
class QLayout;
class QComboBox;
class QPushButton;
class QSettings;
class QSlider;

namespace tetraction::viewer {

class NumberField;

class DrawingPanel : public QWidget {
  Q_OBJECT

 public:
  explicit DrawingPanel(QWidget* parent = nullptr);

  const DrawingSettings& drawing() const { return drawing_; }
  /// Shows the present range of the colours.
  void show_range(double low, double high);
  /// Colours the body by another field, with a range that follows the data.
  void color_by(ColorField field);
  /// Shows the range and the fields in the present units.
  void show_units();
  /// Turns the light by these angles, degrees to the right and up.
  void turn_light(double azimuth, double elevation);
  void save(QSettings& settings) const;
  void load(QSettings& settings);

 signals:
  void changed(const tetraction::viewer::DrawingSettings& drawing);
  void refit_wanted();
  void refused(const QString& message);

 private:
  QCheckBox* add_check(QLayout* layout, const QString& text, const char* name, const QString& tip,
                       bool DrawingSettings::*flag);
  QSlider* add_slider(QFormLayout* form, const QString& text, const char* name, const QString& tip,
                      int low, int high, double factor, double DrawingSettings::*value);
  template <class Choice>
  QComboBox* add_choice(const char* name, const QString& tip, const QStringList& items,
                        Choice DrawingSettings::*value);
  void show_all();
  void emit_changed();

  DrawingSettings drawing_;
  std::vector<std::function<void()>> shows_;  // each shows one setting in its widget
  std::vector<std::pair<const char*, bool DrawingSettings::*>> flags_;
  std::vector<std::pair<const char*, double DrawingSettings::*>> numbers_;
  struct List {
    const char* name;
    QComboBox* list;
    std::function<void(int)> set;
  };
  std::vector<List> lists_;
  QComboBox* field_;
  NumberField *low_, *high_, *scale_;
  QPushButton* refit_;
};

}  // namespace tetraction::viewer
