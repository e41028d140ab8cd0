#include "run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/fingerprint.h"
#include "core/quoting.h"
#include "core/spelling.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// "solver" and "tolerance" of "solver.tolerance".
std::pair<std::string, std::string> section_and_key(const std::string& key) {
  const std::size_t dot = std::min(key.find('.'), key.size());
  return {key.substr(0, dot), key.substr(std::min(dot + 1, key.size()))};
}

std::string option(const StudyRule& rule) {
  return "--rule " + in_quotes(to_string(rule));
}

// A number, true or a word.
Json value_of(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json(text) : value;
}

// Keys that belong to a section together may contradict each other.
void refuse_conflicts(const StudyRule& rule, const SceneSection& section, const void* settings) {
  for (const SectionRule& condition : section.rules) {
    const std::string conflict = condition.conflict(settings);
    if (conflict.empty()) continue;
    throw InputError(
        fmt::format("{}: {}.{} {}", option(rule), section.name, condition.keys.back(), conflict));
  }
}

// Sets the keys of a rule as the scene reader does, with the same descriptions of keys.
void put_settings(const StudyRule& rule, Scene& scene) {
  const auto part = [&](const std::string& section) -> void* {
    if (section == "solver") return &scene.solver;
    return &scene.time;
  };
  for (const VariedValue& setting : rule.settings) {
    const auto [name, own] = section_and_key(setting.key);
    const SceneKey& key = *find_section(name)->find(own);
    key.value->read(value_of(setting.value), key.info.range,
                    Refusal{[&] { return fmt::format("{}: {}", option(rule), setting.key); }},
                    part(name));
  }
  Json echo = Json::parse(scene.echo, nullptr, false);
  for (const char* name : {"time", "solver"}) {
    const SceneSection& section = *find_section(name);
    refuse_conflicts(rule, section, part(name));
    if (echo.is_object()) echo[name] = settings_json(section, part(name));
  }
  for (const VariedValue& setting : rule.settings) {
    const auto [name, own] = section_and_key(setting.key);
    if (find_section(name)->find(own)->is_used(part(name))) continue;
    throw InputError(fmt::format("{}: {} has no effect with the other settings. Leave it out.",
                                 option(rule), setting.key));
  }
  if (echo.is_object()) scene.echo = echo.dump(2, ' ', false, Json::error_handler_t::replace);
}

// "adapt" instead of "time.adapt", or a whole section.
void refuse_keys_without_section(const StudyRule& rule) {
  for (const std::string section : {"time", "solver"}) {
    for (const VariedValue& setting : rule.settings) {
      if (setting.key != section) continue;
      throw InputError(fmt::format(
          "{}: {} is a section. Give its keys one by one, as in --rule {}:{}, and with commas "
          "between them if there are several.",
          option(rule), section, to_string(rule.integrator),
          section == "time" ? "time.retry=3" : "solver.tolerance=1e-6"));
    }
  }
  for (const VariedValue& setting : rule.settings) {
    std::string sections;
    std::string keys;
    for (const std::string section : {"time", "solver"}) {
      if (find_section(section)->find(setting.key) == nullptr) continue;
      sections += (sections.empty() ? "[" : " and of [") + section + "]";
      keys += (keys.empty() ? "" : " or ") + section + "." + setting.key;
    }
    if (keys.empty()) continue;
    throw InputError(
        fmt::format("{}: {} is a key of {}. Write {}.", option(rule), setting.key, sections, keys));
  }
}

}  // namespace

void check_settings_of(const StudyRule& rule) {
  constexpr std::array kOfStudy{"time.integrator", "time.step", "time.end", "solver.engine"};
  refuse_keys_without_section(rule);
  for (const VariedValue& setting : rule.settings) {
    const auto [name, own] = section_and_key(setting.key);
    const bool is_of_study =
        std::find(kOfStudy.begin(), kOfStudy.end(), setting.key) != kOfStudy.end();
    if ((name != "solver" && name != "time") || is_of_study) {
      throw InputError(
          fmt::format("{}: a rule has settings of [solver] and [time] only, without "
                      "time.integrator, time.step, "
                      "time.end and solver.engine. To compare scenes that differ in another key, "
                      "vary it: --vary "
                      "{}=VALUE,VALUE.",
                      option(rule), setting.key));
    }
    const SceneSection& section = *find_section(name);
    if (section.find(own) == nullptr) {
      NameList keys;
      for (const SceneKey& key : section.keys) keys.emplace_back(key.info.name);
      throw InputError(fmt::format("{}: {} is no key of [{}]: {}", option(rule), in_quotes(own),
                                   name, advice(own, keys)));
    }
    if (name == "solver" && !is_implicit(rule.integrator)) {
      throw InputError(fmt::format(
          "{}: {} is explicit and solves no equations, so that {} has no effect. Take an implicit "
          "rule, such as midpoint.",
          option(rule), to_string(rule.integrator), setting.key));
    }
    if (setting.key == "solver.kind" && needs_root_finder(rule.integrator)) {
      throw InputError(fmt::format("{}: {} needs newton. Leave solver.kind out.", option(rule),
                                   to_string(rule.integrator)));
    }
    if (std::count_if(rule.settings.begin(), rule.settings.end(),
                      [&](const VariedValue& other) { return other.key == setting.key; }) > 1) {
      throw InputError(fmt::format("{}: {} is there twice.", option(rule), setting.key));
    }
  }
}

bool is_same_rule(const StudyRule& a, const StudyRule& b) {
  return a.integrator == b.integrator &&
         std::equal(a.settings.begin(), a.settings.end(), b.settings.begin(), b.settings.end(),
                    [](const VariedValue& x, const VariedValue& y) {
                      return x.key == y.key && value_of(x.value) == value_of(y.value);
                    });
}

Scene scene_of(const StudyPlan& plan, const PlannedRun& run) {
  Scene scene = plan.variants[run.variant].scene;
  scene.time.integrator = run.integrator;
  scene.time.step = run.step;
  scene.time.automatic = false;
  if (!run.settings.empty()) put_settings(run.rule(), scene);
  if (!run.solver.empty() && run.solver != scene.solver.kind) {
    scene.solver.kind = run.solver;
    scene.solver.linear = LinearSolver::kAuto;  // another solver has other linear solvers
  }
  return scene;
}

std::string folder_name(const std::string& name) {
  constexpr std::size_t kLongest = 100;
  std::string folder;
  for (const char c : name) {
    const bool is_safe = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                         (c >= '0' && c <= '9') || c == '.' || c == '=' || c == '+' || c == '-' ||
                         c == '_';
    if (is_safe) {
      folder += c;
    } else if (!folder.empty() && folder.back() != '_') {
      folder += '_';
    }
  }
  if (folder.size() > kLongest) folder.resize(kLongest);
  while (!folder.empty() && folder.back() == '_') folder.pop_back();
  // Neither hidden nor like an option.
  if (folder.empty() || folder.front() == '.' || folder.front() == '-') folder.insert(0, 1, '_');
  return folder;
}

std::string folder_name(const StudyRule& rule) {
  std::string text;
  for (const VariedValue& setting : rule.settings) {
    text += fmt::format("{}{}={}", text.empty() ? "" : "_", setting.key, setting.value);
  }
  const std::string folder = folder_name(text);
  if (folder == text) return folder;
  // Other texts may have the same safe letters.
  Fingerprint number;
  number.add(text);
  return fmt::format("{}_{:08x}", folder, number.value() >> 32U);
}

}  // namespace tetraction
