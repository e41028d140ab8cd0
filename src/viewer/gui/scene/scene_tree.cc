#include "scene_tree.h"

#include <QContextMenuEvent>
#include <QHeaderView>
#include <QMenu>
#include <QPainter>
#include <algorithm>

#include "form_texts.h"

namespace tetraction::viewer {
namespace {

// What an item stands for.
constexpr int kSection = Qt::UserRole;
constexpr int kNumber = Qt::UserRole + 1;  // of an entry; −1 for a group with entries
constexpr int kOff = Qt::UserRole + 2;     // of an entry that is off; otherwise −1
constexpr int kIsList = Qt::UserRole + 3;

constexpr int kSecondColumn = 28;  // its width, pixels

// An eye, a crossed one, or a plus.
enum class Sign { kOpenEye, kShutEye, kAdd };
QPixmap picture(Sign sign, const QColor& color) {
  constexpr int kSize = 32;
  QPixmap pixmap(kSize, kSize);
  pixmap.fill(Qt::transparent);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(QPen(color, 2.5));
  if (sign == Sign::kAdd) {
    painter.drawLine(16, 7, 16, 25);
    painter.drawLine(7, 16, 25, 16);
  } else {
    painter.drawChord(4, 8, 24, 26, 30 * 16, 120 * 16);
    painter.drawArc(4, -2, 24, 26, 210 * 16, 120 * 16);
    painter.setBrush(color);
    painter.drawEllipse(QPoint(16, 16), 4, 4);
    if (sign == Sign::kShutEye) painter.drawLine(6, 26, 26, 6);
  }
  return pixmap;
}

QIcon icon(Sign sign, const QPalette& palette) {
  QIcon both(picture(sign, palette.color(QPalette::Text)));
  both.addPixmap(picture(sign, palette.color(QPalette::HighlightedText)), QIcon::Selected);
  return both;
}

bool same(const std::vector<OutlineGroup>& a, const std::vector<OutlineGroup>& b) {
  const auto same_entries = [](const OutlineGroup& x, const OutlineGroup& y) {
    return std::equal(x.entries.begin(), x.entries.end(), y.entries.begin(), y.entries.end(),
                      [](const OutlineEntry& p, const OutlineEntry& q) {
                        return p.place == q.place && p.label == q.label;
                      });
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_entries);
}

}  // namespace

SceneTree::SceneTree(QWidget* parent) : QTreeWidget(parent) {
  setObjectName(QStringLiteral("scene_tree"));
  setColumnCount(2);
  setHeaderHidden(true);
  setIndentation(14);
  setEditTriggers(NoEditTriggers);
  setExpandsOnDoubleClick(false);
  setUniformRowHeights(true);
  header()->setStretchLastSection(false);
  header()->setSectionResizeMode(0, QHeaderView::Stretch);
  header()->setSectionResizeMode(1, QHeaderView::Fixed);
  header()->setMinimumSectionSize(24);
  header()->resizeSection(1, kSecondColumn);
  setTextElideMode(Qt::ElideRight);
  setMinimumWidth(164);
  connect(this, &QTreeWidget::currentItemChanged, this, [this] {
    if (filling_) return;
    to_choose_.reset();
    emit chosen_changed();
  });
  connect(this, &QTreeWidget::itemClicked, this, [this](QTreeWidgetItem* item, int column) {
    if (column == 1) use_second_column(item);
  });
  connect(this, &QTreeWidget::itemDoubleClicked, this, [this](QTreeWidgetItem* item, int column) {
    if (column == 0 && may_rename(*item)) editItem(item, 0);
  });
  connect(this, &QTreeWidget::itemChanged, this, [this](QTreeWidgetItem* item, int column) {
    if (!filling_ && column == 0) emit rename_wanted(item->text(0));
  });
}

void SceneTree::show_scene(const SceneEditor& editor) {
  std::vector<OutlineGroup> groups = editor.outline();
  std::vector<std::string> off;
  for (const OffEntry& entry : editor.off()) {
    std::string label = entry.label;
    if (!has_names(entry.section)) label = text_in_units(entry.section, entry.table);
    if (label.empty()) label = tr("off").toStdString();
    off.push_back(editor.is_off(entry) ? label : "");
  }
  // An item that is in use must stay.
  if (menu_is_open_ || state() == EditingState) return;
  if (same(groups, shown_) && off == shown_off_) return;
  const std::optional<EntryPlace> before = to_choose_ ? to_choose_ : chosen();
  const QTreeWidgetItem* last = currentItem();
  const std::string last_section =
      last != nullptr ? last->data(0, kSection).toString().toStdString() : std::string();
  const QSignalBlocker quiet(this);
  filling_ = true;
  shown_ = std::move(groups);
  shown_off_ = std::move(off);
  clear();
  for (const OutlineGroup& group : shown_) {
    auto* top = new QTreeWidgetItem(this, {from_utf8(group.title)});
    const int text = fontMetrics().horizontalAdvance(top->text(0));
    setMinimumWidth(std::max(minimumWidth(), text + 2 * indentation() + kSecondColumn));
    top->setData(0, kSection, from_utf8(group.section));
    top->setData(0, kNumber, group.is_list ? -1 : 0);
    top->setData(0, kOff, -1);
    top->setData(0, kIsList, group.is_list);
    top->setToolTip(0, from_utf8(group.title));
    if (!group.is_list) continue;
    top->setIcon(1, icon(Sign::kAdd, palette()));
    top->setToolTip(1, tr("Add"));
    const auto add = [&](const std::string& label, int number, int switched_off) {
      auto* item = new QTreeWidgetItem(top, {from_utf8(label)});
      item->setData(0, kSection, from_utf8(group.section));
      item->setData(0, kNumber, number);
      item->setData(0, kOff, switched_off);
      item->setData(0, kIsList, true);
      item->setToolTip(0, from_utf8(label));
      const bool is_off = switched_off >= 0;
      item->setIcon(1, icon(is_off ? Sign::kShutEye : Sign::kOpenEye, palette()));
      item->setToolTip(1, is_off ? tr("Switch on") : tr("Switch off"));
      if (is_off) item->setForeground(0, palette().color(QPalette::Disabled, QPalette::Text));
      if (may_rename(*item)) item->setFlags(item->flags() | Qt::ItemIsEditable);
    };
    for (const OutlineEntry& entry : group.entries) {
      add(entry.label, static_cast<int>(entry.place.index), -1);
    }
    for (std::size_t i = 0; i < shown_off_.size(); ++i) {
      const OffEntry& entry = editor.off()[i];
      if (!shown_off_[i].empty() && entry.section == group.section) {
        add(shown_off_[i], -1, static_cast<int>(i));
      }
    }
    top->setExpanded(true);
  }
  QTreeWidgetItem* item = before ? item_of(*before) : nullptr;
  if (item != nullptr) {
    to_choose_.reset();
  } else {
    item = group_of(last_section);
  }
  setCurrentItem(item != nullptr ? item : topLevelItem(0));
  filling_ = false;
}

QTreeWidgetItem* SceneTree::group_of(const std::string& section) const {
  for (int i = 0; i < topLevelItemCount(); ++i) {
    if (topLevelItem(i)->data(0, kSection).toString() == from_utf8(section)) return topLevelItem(i);
  }
  return nullptr;
}

QTreeWidgetItem* SceneTree::item_of(const EntryPlace& place) const {
  QTreeWidgetItem* group = group_of(place.section);
  if (group == nullptr || !group->data(0, kIsList).toBool()) return group;
  for (int i = 0; i < group->childCount(); ++i) {
    if (group->child(i)->data(0, kNumber).toInt() == static_cast<int>(place.index)) {
      return group->child(i);
    }
  }
  return nullptr;
}

void SceneTree::choose(const EntryPlace& place) {
  if (QTreeWidgetItem* item = item_of(place)) {
    setCurrentItem(item);
    scrollToItem(item);
  } else {
    to_choose_ = place;
  }
}

std::optional<EntryPlace> SceneTree::chosen() const {
  const QTreeWidgetItem* item = currentItem();
  if (item == nullptr || item->data(0, kNumber).toInt() < 0) return std::nullopt;
  return EntryPlace{item->data(0, kSection).toString().toStdString(),
                    static_cast<std::size_t>(item->data(0, kNumber).toInt())};
}

bool SceneTree::may_rename(const QTreeWidgetItem& item) const {
  return item.data(0, kIsList).toBool() && item.data(0, kNumber).toInt() >= 0 &&
         has_names(item.data(0, kSection).toString().toStdString());
}

void SceneTree::use_second_column(QTreeWidgetItem* item) {
  if (!item->data(0, kIsList).toBool()) return;
  const int off = item->data(0, kOff).toInt();
  if (off >= 0) {
    emit on_wanted(off);
  } else if (item->data(0, kNumber).toInt() < 0) {
    emit add_wanted(item->data(0, kSection).toString());
  } else {
    emit off_wanted();
  }
}

void SceneTree::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) shown_.clear();  // the signs get other colours
  QTreeWidget::changeEvent(event);
}

void SceneTree::keyPressEvent(QKeyEvent* event) {
  QTreeWidgetItem* item = currentItem();
  const bool is_entry = chosen() && item->data(0, kIsList).toBool();
  if (is_entry && event->key() == Qt::Key_Delete) {
    emit delete_wanted();
  } else if (is_entry && event->key() == Qt::Key_F2 && may_rename(*item)) {
    editItem(item, 0);
  } else if (is_entry && event->key() == Qt::Key_D && event->modifiers() == Qt::ControlModifier) {
    emit duplicate_wanted();
  } else {
    QTreeWidget::keyPressEvent(event);
  }
}

void SceneTree::contextMenuEvent(QContextMenuEvent* event) {
  QTreeWidgetItem* item = itemAt(event->pos());
  if (item == nullptr || !item->data(0, kIsList).toBool()) return;
  setCurrentItem(item);
  QMenu menu(this);
  const int off = item->data(0, kOff).toInt();
  if (off >= 0) {
    menu.addAction(tr("Switch on"), this, [this, off] { emit on_wanted(off); });
    menu.addAction(tr("Delete"), this, [this, off] { emit forget_wanted(off); });
  } else if (!chosen()) {
    menu.addAction(tr("Add"), this, [this, item] { use_second_column(item); });
  } else {
    if (may_rename(*item)) {
      menu.addAction(
          tr("Rename"), this, [this, item] { editItem(item, 0); }, Qt::Key_F2);
    }
    menu.addAction(tr("Duplicate"), this, &SceneTree::duplicate_wanted, tr("Ctrl+D"));
    menu.addAction(tr("Switch off"), this, &SceneTree::off_wanted);
    menu.addAction(tr("Delete"), this, &SceneTree::delete_wanted, Qt::Key_Delete);
  }
  menu_is_open_ = true;
  menu.exec(event->globalPos());
  menu_is_open_ = false;
}

}  // namespace tetraction::viewer
