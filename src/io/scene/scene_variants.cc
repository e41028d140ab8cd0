#include "scene_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/quoting.h"
#include "simulation/study/run_scene.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// More are a mistake, and would take very long.
constexpr std::size_t kMostVariants = 1000;

// One --vary.
struct Varied {
  std::string text;
  std::string key;
  std::vector<std::string> values;
};

// Keys that a study sets itself or has once for all variants. To vary them would change nothing.
void check_varied_key(const std::string& text, const std::string& key) {
  for (const char* own : {"time", "time.integrator", "time.step", "time.end", "output"}) {
    const bool is_part = std::string(own) == "output" && key.rfind("output.", 0) == 0;
    if (key != own && !is_part) continue;
    throw InputError(fmt::format(
        "--vary {}: a study has one end time and one output directory, and sets integrators and "
        "steps itself. Vary another key, or make two studies.",
        text));
  }
}

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

// Cuts a list of values at its commas. Those of arrays, tables and strings belong to a value.
std::vector<std::string> split_values(const std::string& text, const std::string& values) {
  std::vector<std::string> parts(1);
  std::string closing;  // of the brackets and braces that are open
  char quote = '\0';
  for (std::size_t i = 0; i < values.size(); ++i) {
    const char c = values[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
      if (c == '\\' && quote == '"' && i + 1 < values.size()) parts.back() += values[i++];
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      closing += c == '[' ? ']' : '}';
    } else if (!closing.empty() && c == closing.back()) {
      closing.pop_back();
    } else if (c == ',' && closing.empty()) {
      parts.emplace_back();
      continue;
    }
    parts.back() += values[i];
  }
  if (quote != '\0' || !closing.empty()) {
    throw InputError(fmt::format("--vary {}: {} is missing at the end.", text,
                                 quote != '\0' ? quote : closing.back()));
  }
  for (std::string& part : parts) part = trimmed(part);
  return parts;
}

Varied read_varied(const std::string& text) {
  const auto equals = text.find('=');
  Varied varied{text, trimmed(text.substr(0, equals)), {}};
  if (equals != std::string::npos) varied.values = split_values(text, text.substr(equals + 1));
  const bool has_empty = std::any_of(varied.values.begin(), varied.values.end(),
                                     [](const std::string& value) { return value.empty(); });
  if (varied.key.empty() || varied.values.empty() || has_empty) {
    throw InputError(fmt::format(
        "--vary {}: write KEY=VALUE,VALUE…, for instance --vary fix.0.mode=exact,penalty.", text));
  }
  check_varied_key(text, varied.key);
  for (std::size_t i = 0; i < varied.values.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (varied.values[i] != varied.values[j]) continue;
      throw InputError(fmt::format("--vary {}: {} is there twice.", text, varied.values[i]));
    }
  }
  return varied;
}

// The last parts of a key that tell it from the other ones: "density" for material.density.
std::string short_key(const std::string& key, const std::vector<VariedValue>& values) {
  for (auto dot = key.rfind('.'); dot != std::string::npos && dot > 0;
       dot = key.rfind('.', dot - 1)) {
    const std::string part = key.substr(dot);
    const auto ends_so = [&](const VariedValue& other) {
      return ("." + other.key).ends_with(part);
    };
    const bool is_number = part.size() > 1 && part[1] >= '0' && part[1] <= '9';
    if (!is_number && std::count_if(values.begin(), values.end(), ends_so) == 1) {
      return part.substr(1);
    }
  }
  return key;
}

StudyVariant read_variant(const ReadScene& read, const std::vector<std::string>& overrides,
                          const std::vector<VariedValue>& values) {
  StudyVariant variant;
  variant.values = values;
  std::vector<std::string> all = overrides;
  for (const VariedValue& varied : values) {
    all.push_back(fmt::format("{}={}", varied.key, varied.value));
    variant.name += values.size() == 1 ? varied.value
                                       : fmt::format("{}{}={}", variant.name.empty() ? "" : ", ",
                                                     short_key(varied.key, values), varied.value);
  }
  variant.name = printable(variant.name);
  variant.folder = folder_name(variant.name);
  try {
    variant.scene = read(all);
  } catch (const InputError& error) {
    // The reader knows all overrides as those of --set.
    std::string message = error.what();
    for (std::size_t i = overrides.size(); i < all.size(); ++i) {
      const std::string known = "--set " + excerpt(all[i]);
      for (auto at = message.find(known); at != std::string::npos; at = message.find(known, at)) {
        const std::string own = "--vary " + excerpt(all[i]);
        message.replace(at, known.size(), own);
        at += own.size();
      }
    }
    throw InputError(in_variant(variant, message));
  }
  return variant;
}

// Two spellings of one value, such as 900 and 9e2, make the same scene.
void check_that_scenes_differ(const std::vector<StudyVariant>& variants) {
  std::map<std::string, const StudyVariant*> known;
  for (const StudyVariant& variant : variants) {
    if (variant.scene.echo.empty()) continue;
    const auto [other, is_new] = known.emplace(variant.scene.echo, &variant);
    if (is_new) continue;
    throw InputError(
        fmt::format("--vary: the values {} and {} make the same scene. Leave one of them out.",
                    in_quotes(other->second->name), in_quotes(variant.name)));
  }
}

}  // namespace

std::vector<StudyVariant> read_variants(const ReadScene& read,
                                        const std::vector<std::string>& overrides,
                                        const std::vector<std::string>& texts) {
  std::vector<Varied> all;
  for (const std::string& text : texts) {
    all.push_back(read_varied(text));
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      if (all[i].key != all.back().key) continue;
      throw InputError(
          fmt::format("--vary {}: the key {} is varied twice. Write all its values in one --vary.",
                      text, all.back().key));
    }
  }
  if (all.empty()) return {};
  std::vector<std::vector<VariedValue>> combinations(1);
  for (const Varied& varied : all) {
    if (combinations.size() * varied.values.size() > kMostVariants) {
      throw InputError(
          fmt::format("The values of --vary have more than {} combinations. Give fewer values.",
                      kMostVariants));
    }
    std::vector<std::vector<VariedValue>> longer;
    for (const std::vector<VariedValue>& combination : combinations) {
      for (const std::string& value : varied.values) {
        longer.push_back(combination);
        longer.back().push_back({varied.key, value});
      }
    }
    combinations = std::move(longer);
  }
  std::vector<StudyVariant> variants;
  for (const std::vector<VariedValue>& combination : combinations) {
    StudyVariant variant = read_variant(read, overrides, combination);
    // Different values may have the same safe letters.
    const std::string folder = variant.folder;
    const auto is_taken = [&](const StudyVariant& other) { return other.folder == variant.folder; };
    for (int i = 2; std::any_of(variants.begin(), variants.end(), is_taken); ++i) {
      variant.folder = fmt::format("{}_{}", folder, i);
    }
    variants.push_back(std::move(variant));
  }
  check_that_scenes_differ(variants);
  return variants;
}

std::string in_variant(const StudyVariant& variant, const std::string& message) {
  std::vector<std::string> options;
  bool is_named = false;
  for (const VariedValue& varied : variant.values) {
    options.push_back("--vary " + excerpt(fmt::format("{}={}", varied.key, varied.value)));
    is_named = is_named || message.rfind(options.back(), 0) == 0;
  }
  if (is_named && options.size() == 1) return message;
  return fmt::format("{}: {}", fmt::join(options, " "), message);
}

std::shared_ptr<const TetMesh> read_variant_meshes(std::vector<StudyVariant>& variants,
                                                   const ReadMesh& read) {
  std::map<std::string, std::shared_ptr<const TetMesh>> known;
  for (StudyVariant& variant : variants) {
    const auto echo = nlohmann::json::parse(variant.scene.echo, nullptr, false);
    std::string inputs;
    for (const char* section : {"mesh", "initial"}) {
      if (echo.is_object() && echo.contains(section)) {
        inputs += echo[section].dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      }
      inputs += '\n';
    }
    std::shared_ptr<const TetMesh>& mesh = known[inputs];
    try {
      if (!mesh) mesh = std::make_shared<const TetMesh>(read(variant.scene));
    } catch (const InputError& error) {
      throw InputError(in_variant(variant, error.what()));
    } catch (const FileError& error) {
      throw FileError(in_variant(variant, error.what()));
    }
    variant.mesh = mesh;
  }
  return variants.front().mesh;
}

}  // namespace tetraction
