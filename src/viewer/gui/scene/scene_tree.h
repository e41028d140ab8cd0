// The tree of the scene.
#pragma once

#include <QTreeWidget>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "viewer/scene/scene_editor.h"

namespace tetraction::viewer {

/// Shows groups and entries. An entry of a list has an eye, which switches it off and on, and a menu; a
/// list has a plus, which adds an entry.
class SceneTree : public QTreeWidget {
  Q_OBJECT

 public:
  explicit SceneTree(QWidget* parent = nullptr);

  void show_scene(const SceneEditor& editor);
  /// Selects an entry; the next show_scene() does it for one that is not there yet.
  void choose(const EntryPlace& place);
  std::optional<EntryPlace> chosen() const;
  /// The item of an entry, and of a group; null if there is none.
  QTreeWidgetItem* item_of(const EntryPlace& place) const;
  QTreeWidgetItem* group_of(const std::string& section) const;

 signals:
  void chosen_changed();
  void add_wanted(const QString& section);
  void delete_wanted();
  void duplicate_wanted();
  void rename_wanted(const QString& name);
  void off_wanted();
  /// For an entry that is off.
  void on_wanted(int off);
  void forget_wanted(int off);

 protected:
  void changeEvent(QEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void contextMenuEvent(QContextMenuEvent* event) override;

 private:
  void use_second_column(QTreeWidgetItem* item);
  bool may_rename(const QTreeWidgetItem& item) const;

  std::vector<OutlineGroup> shown_;
  std::vector<std::string> shown_off_;
  std::optional<EntryPlace> to_choose_;
  bool filling_ = false;
  bool menu_is_open_ = false;
};

}  // namespace tetraction::viewer
