#include "sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

#define TETRACTION_CALL_SECTION(name) name##_section(),
const std::vector<SceneSection>& all_sections() {
  static const std::vector<SceneSection> all{TETRACTION_DOCUMENTED_SECTIONS(
      TETRACTION_CALL_SECTION) TETRACTION_OTHER_SECTIONS(TETRACTION_CALL_SECTION)};
  return all;
}
#undef TETRACTION_CALL_SECTION

#define TETRACTION_COUNT_SECTION(name) +1
constexpr std::size_t kDocumented = TETRACTION_DOCUMENTED_SECTIONS(TETRACTION_COUNT_SECTION);
#undef TETRACTION_COUNT_SECTION

// The only settings of their kind.
template <class Base, class S>
ScenePart part(S Base::*member) {
  return {&section_of<S>(), false,
          [member](const Scene& scene) { return std::vector<const void*>{&(scene.*member)}; },
          [member](Scene& scene) -> void* { return &(scene.*member); }};
}

template <class Base, class S>
ScenePart list(std::vector<S> Base::*member) {
  return {&section_of<S>(), true,
          [member](const Scene& scene) {
            std::vector<const void*> entries;
            for (const S& entry : scene.*member) entries.push_back(&entry);
            return entries;
          },
          [member](Scene& scene) -> void* { return &(scene.*member).emplace_back(); }};
}

// The loads of one kind, with that kind.
ScenePart loads(LoadKind kind) {
  return {&section_of(kind), true,
          [kind](const Scene& scene) {
            std::vector<const void*> entries;
            for (const ForceSettings& load : scene.list(kind)) entries.push_back(&load);
            return entries;
          },
          [kind](Scene& scene) -> void* {
            scene.list(kind).emplace_back().kind = kind;
            return &scene.list(kind).back();
          }};
}

}  // namespace

std::span<const SceneSection> documented_sections() {
  return {all_sections().data(), kDocumented};
}

const SceneSection* find_section(std::string_view name) {
  for (const SceneSection& section : all_sections()) {
    if (name == section.name) return &section;
  }
  return nullptr;
}

const SceneSection& section_of(std::type_index type) {
  const auto found =
      std::find_if(all_sections().begin(), all_sections().end(),
                   [&](const SceneSection& section) { return section.type == type; });
  assert(found != all_sections().end());
  return *found;
}

const SceneSection& section_of(LoadKind kind) {
  return *find_section(name_of(kind));
}

const std::vector<ScenePart>& scene_parts() {
  static const std::vector<ScenePart> parts = [] {
    const auto constant = [](ScenePart part) {
      part.may_change = false;
      return part;
    };
    std::vector<ScenePart> all{constant(part(&Scene::mesh)), part(&Scene::material),
                               list(&Scene::material_region)};
    std::apply([&](auto... member) { (all.push_back(part(member)), ...); },
               ChangeableSections::members());
    all.push_back(list(&Scene::fix));
    all.push_back(list(&Scene::constraint));
    all.push_back(list(&Scene::obstacle));
    for (const LoadKind kind : values_of<LoadKind>()) all.push_back(loads(kind));
    for (const ScenePart& later :
         {part(&Scene::contact), list(&Scene::amplitude), part(&Scene::initial),
          part(&Scene::output), list(&Scene::probe)}) {
      all.push_back(constant(later));
    }
    return all;
  }();
  return parts;
}

Json default_of(std::span<const std::string> key) {
  for (const ScenePart& part : scene_parts()) {
    const std::size_t place =
        part.is_list ? 2 : 1;  // of the key, after the section and the number of the entry
    if (key.size() != place + 1 || key.front() != part.section->name) continue;
    const SceneKey* found = part.section->find(key[place]);
    return found != nullptr ? found->value->json(part.section->defaults.get()) : Json();
  }
  return {};
}

void put_sections(const ChangeableSections& sections, MechanicalSystem& system,
                  const std::vector<AmplitudeSettings>& amplitudes) {
  const auto put = [&](const auto& settings) {
    const SceneSection& section = section_of(typeid(settings));
    if (section.put_into) section.put_into(&settings, system, amplitudes);
  };
  std::apply([&](auto... member) { (put(sections.*member), ...); }, ChangeableSections::members());
}

Json settings_json(const SceneSection& section, const void* settings) {
  Json json = section.beside ? settings_json(section.beside(),
                                             section.settings_beside(const_cast<void*>(settings)))
                             : Json::object();
  for (const SceneKey& key : section.keys) {
    if (!key.is_used(settings) || !key.is_written(settings)) continue;
    Json value = key.value->json(settings);
    if (value.is_null()) continue;
    if (key.info.in_echo == Written::kUnlessDefault &&
        value == key.value->json(section.defaults.get())) {
      continue;
    }
    json[key.info.name] = std::move(value);
  }
  return json;
}

Json selection_json(const Selection& selection) {
  if (const auto* named = std::get_if<SelectNamed>(&selection)) return named->name;
  return settings_json(section_of<Selection>(), &selection);
}

void check_settings(const SceneSection& section, const void* settings) {
  for (const SceneKey& key : section.keys) {
    if (!key.is_used(settings)) continue;
    key.value->check(settings, key.info.range, fmt::format("{}.{}", section.name, key.info.name));
  }
  for (const SectionRule& rule : section.rules) {
    const std::string conflict = rule.conflict(settings);
    if (conflict.empty()) continue;
    throw InputError(rule.keys.empty()
                         ? fmt::format("{} {}", section.name, conflict)
                         : fmt::format("{}.{} {}", section.name, rule.keys.back(), conflict));
  }
}

void check_settings(const ForceSettings& load) {
  check_settings(section_of(load.kind), &load);
}

void check_selection(const Selection& selection) {
  const auto* nearest = std::get_if<SelectNearest>(&selection);
  if (nearest != nullptr && !nearest->point.allFinite()) {
    throw InputError("The point of a selection must be finite, in m.");
  }
  check_settings(section_of<Selection>(), &selection);
  const auto check_parts = [](const std::vector<SelectionPart>& parts) {
    for (const SelectionPart& part : parts) check_selection(part.selection);
  };
  if (const auto* set = std::get_if<SelectSet>(&selection)) check_parts(set->of);
  if (const auto* named = std::get_if<SelectNamed>(&selection)) check_parts(named->of);
}

const char* event_key(const SceneSection& section) {
  const char* dot = std::strrchr(section.name, '.');
  return dot != nullptr ? dot + 1 : section.name;
}

const SceneKey* SceneSection::find(std::string_view key) const {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const SceneKey& k) { return key == k.info.name; });
  return found != keys.end() ? &*found : nullptr;
}

void Refusal::operator()(const std::string& message) const {
  throw InputError(where() + " " + message);
}

void SettingValue::read(const Json&, const NumberRange&, const Refusal&, void*) const {}
void SettingValue::read_table(const TableReader&, void*) const {}
Selection* SettingValue::selection(void*) const {
  return nullptr;
}
void SettingValue::check(const void*, const NumberRange&, const std::string&) const {}
bool SettingValue::copy(const void*, void*) const {
  return false;
}
const void* SettingValue::member(const void*) const {
  return nullptr;
}

}  // namespace tetraction
