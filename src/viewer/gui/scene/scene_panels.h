// The tree of the scene and the inspector of what is chosen in it.
#pragma once

#include <QWidget>
#include <memory>
#include <optional>
#include <vector>

#include "field_form.h"
#include "scene_tree.h"
#include "viewer/scene/scene_editor.h"

class QLabel;
class QPushButton;

namespace tetraction::viewer {

/// Knows nothing of single sections, except that it shows moduli and the stability limit.
class ScenePanels : public QObject {
  Q_OBJECT

 public:
  explicit ScenePanels(QWidget* parent);

  SceneTree* tree() const { return tree_; }
  QWidget* inspector() const { return inspector_; }
  /// The simulation whose scene is shown; null if there is none.
  void set_simulation(Simulation* simulation, std::vector<OffEntry> off = {});
  /// The entries that are switched off, for a file.
  std::vector<OffEntry> off() const;
  /// Shows the present settings. Must be called regularly.
  void update(const Snapshot& snapshot, const std::vector<Index>& selected);
  void choose(const EntryPlace& place);
  /// Adds an entry to a list, which acts on these vertices. `name` is that of a named selection.
  void add(const QString& section, const std::vector<Index>& selected, const QString& name = {});
  /// Shows the numbers in the present units.
  void show_units() { show_entry(); }

 signals:
  /// A change follows.
  void about_to_change();
  /// The user has chosen an entry.
  void chosen();
  /// The user has finished a number.
  void finished();
  /// A change is not possible, and no field can show the reason; or the user has to know what it does besides.
  void refused(const QString& message);

 private:
  void show_entry();
  void show_limit(double stable_step);
  QString change(const FieldForm::Path& path, const Json& value, const InputStage& stage = {});
  void tell(const std::string& refusal);
  FieldForm::Choices choices() const;
  Json as_selection(const std::vector<Index>& vertices) const;

  Simulation* simulation_ = nullptr;
  std::unique_ptr<SceneEditor> editor_;
  std::optional<EntryPlace> shown_;
  struct Addition {
    std::string section;
    std::vector<std::string> names;  // of the entries that there were
  };
  std::vector<std::string> names_of(const std::string& section) const;
  void choose_addition();
  std::optional<Addition> addition_;  // that the scene does not have yet
  FieldForm::Path changed_;           // the field that was changed last
  std::vector<Index> selected_;
  double stable_step_ = 0.0;
  SceneTree* tree_;
  QWidget* inspector_;
  FieldForm* form_;
  QLabel *title_, *facts_, *limit_;
  QWidget* limit_row_;
  QPushButton* half_limit_;
};

}  // namespace tetraction::viewer
