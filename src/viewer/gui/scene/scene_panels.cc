#include "scene_panels.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QScrollArea>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "form_texts.h"
#include "viewer/display_units.h"
#include "viewer/scene/entry_facts.h"

namespace tetraction::viewer {
namespace {

bool is_time(const EntryPlace& place) {
  return section_of_entries(place.section).type == typeid(TimeSettings);
}

}  // namespace

ScenePanels::ScenePanels(QWidget* parent)
    : QObject(parent), tree_(new SceneTree(parent)), inspector_(new QWidget(parent)) {
  auto* column = new QVBoxLayout(inspector_);
  column->setContentsMargins(kFormSpace, kFormSpace, kFormSpace, kFormSpace);
  column->setSpacing(kFormSpace);
  title_ = new QLabel;
  title_->setObjectName(QStringLiteral("entry_title"));
  QFont font = title_->font();
  font.setBold(true);
  title_->setFont(font);
  title_->setWordWrap(true);
  column->addWidget(title_);
  form_ = new FieldForm([this](const FieldForm::Path& path, const Json& value,
                               const InputStage& stage) { return change(path, value, stage); });
  form_->set_finished([this] { emit finished(); });
  column->addWidget(form_);
  limit_row_ = new QWidget;
  auto* limit = new QHBoxLayout(limit_row_);
  limit->setContentsMargins(0, 0, 0, 0);
  limit->addWidget(new QLabel(tr("Stability limit")));
  limit_ = new QLabel;
  limit_->setWordWrap(true);
  limit_->setObjectName(QStringLiteral("limit"));
  limit_->setToolTip(tr("Largest stable step of the explicit rules, 2/ω_max, estimated now"));
  limit->addWidget(limit_, 1);
  half_limit_ = new QPushButton(tr("Use half"));
  half_limit_->setObjectName(QStringLiteral("use_half"));
  half_limit_->setToolTip(tr("Sets the step to half the stability limit"));
  half_limit_->setFocusPolicy(Qt::TabFocus);
  limit->addWidget(half_limit_);
  column->addWidget(limit_row_);
  facts_ = new QLabel;
  facts_->setObjectName(QStringLiteral("facts"));
  facts_->setWordWrap(true);
  facts_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  facts_->setFocusPolicy(Qt::NoFocus);
  column->addWidget(facts_);
  column->addStretch(1);

  connect(half_limit_, &QPushButton::clicked, this, [this] {
    if (!shown_ || !(stable_step_ > 0.0) || !std::isfinite(stable_step_)) return;
    const double half = QString::number(0.5 * stable_step_, 'g', 4).toDouble();
    tell(change({"step"}, half).toStdString());
  });
  connect(tree_, &SceneTree::chosen_changed, this, [this] {
    show_entry();
    emit chosen();
  });
  connect(tree_, &SceneTree::add_wanted, this,
          [this](const QString& section) { add(section, selected_); });
  const auto with_chosen = [this](const auto& work) {
    const std::optional<EntryPlace> place = tree_->chosen();
    if (!editor_ || !place) return;
    emit about_to_change();
    tell(work(*place));
  };
  // An event of the scene cannot change an entry that is not there.
  const auto take_away = [this, with_chosen](const QString& how, const auto& work) {
    with_chosen([&](const EntryPlace& place) {
      const std::string events = editor_->events_that_change(place);
      std::string refusal = work(place);
      if (refusal.empty() && !events.empty()) {
        emit refused(
            tr("%1 is %2, and what %3 would change of it is not made. Undo brings it back.")
                .arg(from_utf8(title_of_entry(place)), how, from_utf8(events)));
      }
      return refusal;
    });
  };
  connect(tree_, &SceneTree::delete_wanted, this, [this, take_away] {
    take_away(tr("deleted"), [this](const EntryPlace& place) { return editor_->remove(place); });
  });
  connect(tree_, &SceneTree::duplicate_wanted, this, [this, with_chosen] {
    with_chosen([this](const EntryPlace& place) { return editor_->duplicate(place); });
  });
  connect(tree_, &SceneTree::off_wanted, this, [this, take_away] {
    take_away(tr("switched off"),
              [this](const EntryPlace& place) { return editor_->switch_off(place); });
  });
  connect(tree_, &SceneTree::rename_wanted, this, [this, with_chosen](const QString& name) {
    with_chosen([&](const EntryPlace& place) {
      if (name_of_entry(editor_->scene(), place) == name.toStdString()) return std::string();
      return editor_->change({SceneChange::Kind::kRename, place, {}, name.toStdString()});
    });
  });
  connect(tree_, &SceneTree::on_wanted, this, [this](int off) {
    if (!editor_) return;
    emit about_to_change();
    tell(editor_->switch_on(static_cast<std::size_t>(off)));
  });
  connect(tree_, &SceneTree::forget_wanted, this, [this](int off) {
    if (!editor_) return;
    editor_->forget(static_cast<std::size_t>(off));
    tree_->show_scene(*editor_);
  });
}

void ScenePanels::set_simulation(Simulation* simulation, std::vector<OffEntry> off) {
  simulation_ = simulation;
  editor_ =
      simulation != nullptr ? std::make_unique<SceneEditor>(*simulation, std::move(off)) : nullptr;
  shown_.reset();
  addition_.reset();
  if (!editor_) return;
  tree_->show_scene(*editor_);
  show_entry();
}

std::vector<OffEntry> ScenePanels::off() const {
  return editor_ ? editor_->off_now() : std::vector<OffEntry>();
}

// A change that was refused: the tree shows the scene as it is.
void ScenePanels::tell(const std::string& refusal) {
  if (refusal.empty()) return;
  emit refused(from_utf8(refusal));
  if (editor_) tree_->show_scene(*editor_);
}

// The vertices; null if there are none.
Json ScenePanels::as_selection(const std::vector<Index>& vertices) const {
  const TetMesh& mesh = simulation_->mesh();
  Json ids = Json::array();
  for (const Index v : vertices) {
    if (v < mesh.vertex_count()) ids.push_back(mesh.vertex_id(v));  // the mesh may be another one
  }
  return ids.empty() ? Json() : Json{{"vertices", ids}};
}

FieldForm::Choices ScenePanels::choices() const {
  FieldForm::Choices choices;
  const TetMesh& mesh = simulation_->mesh();
  for (std::size_t i = 0; i < entry_count(editor_->scene(), kSelections); ++i) {
    choices.names.push_back(name_of_entry(editor_->scene(), {kSelections, i}));
  }
  for (const auto& group : mesh.groups) choices.groups.push_back(group.name);
  choices.selected = as_selection(selected_);
  return choices;
}

void ScenePanels::add(const QString& section, const std::vector<Index>& selected,
                      const QString& name) {
  if (!editor_) return;
  emit about_to_change();
  SceneChange add = addition_to(section.toStdString());
  const Json vertices = as_selection(selected);
  add.select = editor_->usual_selection(add.place.section, vertices);
  if (!name.isEmpty()) add.path = {name.toStdString()};
  const std::string refusal = editor_->change(add);
  tell(refusal);
  if (!refusal.empty()) return;
  addition_ = {add.place.section, names_of(add.place.section)};
  if (!vertices.is_null() && add.select != vertices) {
    emit refused(
        tr("The selected vertices are not all those of any triangle of the surface or tetrahedron, "
           "so the new "
           "entry acts on %1. Its selection can be changed in the inspector.")
            .arg(add.select.contains("all") ? tr("the whole body") : tr("the whole surface")));
  }
}

std::vector<std::string> ScenePanels::names_of(const std::string& section) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < entry_count(editor_->scene(), section); ++i) {
    names.push_back(name_of_entry(editor_->scene(), {section, i}));
  }
  return names;
}

// The new entry is the last one, unless the list is in the order of its names.
void ScenePanels::choose_addition() {
  if (!addition_) return;
  const std::vector<std::string> names = names_of(addition_->section);
  if (names.size() <= addition_->names.size()) return;
  const auto differ =
      std::mismatch(addition_->names.begin(), addition_->names.end(), names.begin());
  tree_->choose({addition_->section, static_cast<std::size_t>(differ.second - names.begin())});
  addition_.reset();
}

QString ScenePanels::change(const FieldForm::Path& path, const Json& value,
                            const InputStage& stage) {
  if (!editor_ || !shown_) return {};
  SceneChange change{SceneChange::Kind::kSet, *shown_, path, value};
  change.select = editor_->usual_selection(shown_->section, as_selection(selected_));
  // The run is set up again at the end of a drag only.
  if (stage.goes_on && editor_->sets_up_again(change).value_or(false)) return {};
  emit about_to_change();
  changed_ = path;
  return from_utf8(editor_->change(std::move(change), stage.continues_previous));
}

void ScenePanels::update(const Snapshot& snapshot, const std::vector<Index>& selected) {
  if (!editor_) return;
  const bool has_changed = editor_->update();
  const bool other_selection = selected != std::exchange(selected_, selected);
  tree_->show_scene(*editor_);
  choose_addition();
  if (has_changed || other_selection || tree_->chosen() != shown_) show_entry();
  if (const std::optional<std::string> refusal = simulation_->take_refusal()) {
    addition_.reset();
    form_->show_refusal(changed_, from_utf8(*refusal));
    emit refused(from_utf8(*refusal));
  }
  show_limit(snapshot.stable_step);
}

void ScenePanels::choose(const EntryPlace& place) {
  tree_->choose(place);
}

void ScenePanels::show_entry() {
  if (!editor_) return;
  const std::optional<EntryPlace> place = tree_->chosen();
  if (place != std::exchange(shown_, place)) {
    changed_.clear();
    form_->forget_refusals();
  }
  const QTreeWidgetItem* item = tree_->currentItem();
  const QTreeWidgetItem* group = item != nullptr ? item->parent() : nullptr;
  QString title = item == nullptr ? QString() : item->text(0);
  if (group != nullptr) title = QStringLiteral("%1 · %2").arg(group->text(0), title);
  title_->setText(title);
  form_->set_choices(choices());
  form_->show_fields(shown_ ? editor_->fields(*shown_) : std::vector<Field>());
  QString lines;
  if (shown_) {
    for (const auto& [name, value] : facts_of(*shown_, simulation_->settings())) {
      lines += (lines.isEmpty() ? "" : "\n") + from_utf8(name) + " = " + from_utf8(value);
    }
  }
  facts_->setText(lines);
  facts_->setVisible(!lines.isEmpty());
  limit_row_->setVisible(shown_ && is_time(*shown_));
}

void ScenePanels::show_limit(double stable_step) {
  stable_step_ = stable_step;
  if (!shown_ || !is_time(*shown_)) return;
  const TimeSettings time = simulation_->settings().time;
  const bool known = stable_step > 0.0 && std::isfinite(stable_step);
  const bool exceeded = known && time.step > stable_step;
  const bool matters = !is_implicit(time.integrator);
  QString limit = known ? from_utf8(with_unit(stable_step, "s")) : tr("none");
  if (exceeded) limit += matters ? tr(", exceeded") : tr(", not needed");
  limit_->setText(limit);
  limit_->setStyleSheet(exceeded && matters ? QStringLiteral("color: #b00000; font-weight: bold;")
                                            : QString());
  half_limit_->setEnabled(known);
}

}  // namespace tetraction::viewer
