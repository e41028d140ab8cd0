// Writes [[event]].
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "written_keys.h"

namespace tetraction {
namespace {

// The order in which the reader makes the edits of one event: first those of `set`, by the names of
// the sections, then the others.
enum class Stage {
  kSet,
  kUnfix,
  kRemoveConstraint,
  kRemoveObstacle,
  kFix,
  kConstraint,
  kObstacle,
  kLoad,        // in the order of LoadKind
  kChangeState  // in the order of their kinds
};

// One [[event]] that is being written.
struct Block {
  // Place of the last edit in the reader's order.
  // The number is that of the kind for loads that are added and for changes of the state.
  using Place = std::tuple<Stage, std::string, std::optional<std::size_t>>;
  std::optional<Place> last;
  std::vector<std::string> unset;
  WrittenKeys set;
  WrittenKeys others;

  // Whether an edit with that place can follow.
  bool takes(const Place& place) const {
    if (!last || *last < place) return true;
    const Stage stage = std::get<0>(place);
    return *last == place && stage >= Stage::kFix;  // those may be lists
  }

  std::string text(double at, const std::string& note) const {
    std::string text = "\n";
    if (!note.empty()) {
      std::string line = note;  // a comment ends with its line
      std::replace_if(
          line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
      text += "# " + line + "\n";
    }
    text += "[[event]]\nat = " + toml_number(at) + "\n";
    if (!unset.empty()) {
      text += "unset = [";
      for (const std::string& key : unset) {
        text += (&key == &unset.front() ? "" : ", ") + toml_text(key);
      }
      text += "]\n";
    }
    if (!set.empty()) text += "set = " + inline_table(set) + "\n";
    for (auto first = others.begin(); first != others.end();) {
      const auto end = std::find_if(first, others.end(),
                                    [&](const WrittenKey& key) { return key.name != first->name; });
      std::string value = first->value;
      if (end - first > 1) {
        value = "[";
        for (auto entry = first; entry != end; ++entry) {
          value += (entry == first ? "\n  " : ",\n  ") + entry->value;
        }
        value += "\n]";
      }
      text += first->name + " = " + value + "\n";
      first = end;
    }
    return text;
  }
};

// Writes edits, and keeps track of the settings at that time, so that it knows which keys to
// remove.
class EventWriter {
 public:
  explicit EventWriter(const Scene& scene) : now_(scene) {}

  std::string text(const EventSettings& event) {
    text_.clear();
    event_ = &event;
    block_ = {};
    for (const Edit& edit : event.edits) std::visit(*this, edit);
    if (block_.last) text_ += block_.text(event.at, event.note);
    return text_;
  }

  void operator()(const SetMaterial& edit) {
    if (edit.region == 0) {
      begin({Stage::kSet, "material", {}});
      change("material", now_.material, edit.material);
      return;
    }
    const auto i = static_cast<std::size_t>(edit.region - 1);
    begin({Stage::kSet, "material_region", i});
    change(fmt::format("material_region.{}", i), now_.material_region.at(i).material,
           edit.material);
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) {
    const char* name = section_of<Section>().name;
    begin({Stage::kSet, name, {}});
    change(name, now_.section<Section>(), edit.settings);
  }
  void operator()(const SetForce& edit) {
    const LoadKind kind = edit.entry.kind;
    change_entry({Stage::kLoad, {}, static_cast<std::size_t>(kind)}, to_string(kind),
                 now_.list(kind), edit);
  }
  void operator()(const SetFix& edit) {
    change_entry({Stage::kFix, {}, {}}, "fix", now_.fix, edit);
  }
  void operator()(const SetConstraint& edit) {
    change_entry({Stage::kConstraint, {}, {}}, "constraint", now_.constraint, edit);
  }
  void operator()(const Unfix& edit) {
    begin({Stage::kUnfix, {}, {}});
    WrittenKeys keys;
    if (edit.fix) keys.push_back({"fix", std::to_string(*edit.fix)});
    block_.others.push_back({"unfix", inline_table(keys, &edit.select)});
  }
  void operator()(const RemoveConstraint& edit) {
    begin({Stage::kRemoveConstraint, {}, {}});
    block_.others.push_back({"remove_constraint", std::to_string(edit.index)});
  }
  void operator()(const SetObstacle& edit) {
    change_entry({Stage::kObstacle, {}, {}}, "obstacle", now_.obstacle, edit);
  }
  void operator()(const RemoveObstacle& edit) {
    begin({Stage::kRemoveObstacle, {}, {}});
    block_.others.push_back({"remove_obstacle", std::to_string(edit.index)});
  }
  template <class Change>
  void operator()(const ChangeState<Change>& edit) {
    begin({Stage::kChangeState, {}, Edit(edit).index()});
    block_.others.push_back({event_key(section_of<Change>()),
                             inline_table(keys_of(edit.change), selection_of(edit.change))});
  }

 private:
  void begin(const Block::Place& place) {
    if (!block_.takes(place)) {
      text_ += block_.text(event_->at, event_->note);
      block_ = {};
    }
    block_.last = place;
  }

  // All keys are written, even those that do not change, because an edit that changes nothing is
  // still an edit. The density is left out: it never changes, and an event may not set it.
  template <class Settings>
  void change(const std::string& section, Settings& now, const Settings& next) {
    const WrittenKeys keys = keys_of(next);
    for (const WrittenKey& old : keys_of(now)) {
      const bool stays = std::any_of(keys.begin(), keys.end(),
                                     [&](const WrittenKey& key) { return key.name == old.name; });
      if (!stays) block_.unset.push_back(section + "." + old.name);
    }
    for (const WrittenKey& key : keys) {
      if (key.name == "density") continue;
      block_.set.push_back({toml_text(section + "." + key.name), key.value});
    }
    now = next;
  }

  template <class Settings>
  static const Selection* selection_of(const Settings& settings) {
    return tetraction::selection_of(section_of<Settings>(), &settings);
  }

  // `added` is the place of an entry without an index.
  template <class Settings>
  void change_entry(const Block::Place& added, const std::string& list, std::vector<Settings>& now,
                    const SetEntry<Settings>& edit) {
    const Settings& next = edit.entry;
    if (!edit.index) {
      begin(added);
      block_.others.push_back({list, inline_table(keys_of(next), selection_of(next))});
      now.push_back(next);
      return;
    }
    begin({Stage::kSet, list, *edit.index});
    const std::string section = fmt::format("{}.{}", list, *edit.index);
    Settings& entry = now.at(*edit.index);
    const Selection* old_select = selection_of(entry);
    const Selection* select = selection_of(next);
    if (old_select != nullptr && (select == nullptr || *select != *old_select)) {
      block_.unset.push_back(section + ".select");
    }
    if (select != nullptr && (old_select == nullptr || *select != *old_select)) {
      for (const WrittenKey& key : selection_keys(section + ".select", *select)) {
        block_.set.push_back({toml_text(key.name), key.value});
      }
    }
    change(section, entry, next);
  }

  Scene now_;
  const EventSettings* event_ = nullptr;
  Block block_;
  std::string text_;
};

}  // namespace

std::string event_text(const Scene& scene) {
  EventWriter writer(scene);
  std::string text;
  for (const EventSettings& event : scene.event) text += writer.text(event);
  return text;
}

}  // namespace tetraction
