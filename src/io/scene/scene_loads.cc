// [[amplitude]], the loads, [initial]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/quoting.h"
#include "io/text/csv_table.h"
#include "key_reader.h"
#include "scene_sections.h"
#include "tetraction/core/error.h"

namespace tetraction {

MomentumSettings read_momentum(const TomlTable& table) {
  MomentumSettings momentum;
  momentum.where = table.where();
  momentum.select = read_selection(table);
  read_keys(table, momentum);
  return momentum;
}

ShiftSettings read_shift(const TomlTable& table) {
  ShiftSettings shift;
  shift.where = table.where();
  read_keys(table, shift);
  return shift;
}

namespace {

template <class Settings>
ForceSettings read_kind(const TomlTable& table) {
  Settings load;
  load.where = table.where();
  load.select = read_selection(table);
  if (load.kind == LoadKind::kForce && !table.has("total")) {
    table.require(
        "vector",
        "the force on each selected vertex, [fx, fy, fz] in N; or give total, their sum.");
  }
  if (load.kind == LoadKind::kBodyForce && !table.has("acceleration")) {
    table.require("vector",
                  "the force for each volume, [fx, fy, fz] in N/m³; or give acceleration.");
  }
  read_keys(table, load);
  return load;
}

}  // namespace

const TableKeys& load_keys(LoadKind kind) {
  ForceSettings load;
  load.kind = kind;
  return visit_load(load, []<class Settings>(const Settings&) -> const TableKeys& {
    return table_keys<Settings>();
  });
}

ForceSettings read_load(const TomlTable& table, LoadKind kind) {
  ForceSettings load;
  load.kind = kind;
  return visit_load(
      load, [&table]<class Settings>(const Settings&) { return read_kind<Settings>(table); });
}

AmplitudeSettings read_amplitude(const TomlTable& table, const std::string& folder) {
  AmplitudeSettings amplitude;
  amplitude.where = table.where();
  read_keys(table, amplitude);
  const NameList kinds{"points", "file", "sine", "smooth_step"};
  std::string_view kind;
  for (const std::string_view candidate : kinds) {
    if (!table.has(candidate)) continue;
    if (!kind.empty()) {
      table.refuse(candidate,
                   fmt::format("is one key too many: {} is given as well. Give one of {}.", kind,
                               listing(kinds)));
    }
    kind = candidate;
  }
  if (kind.empty()) table.refuse_table(fmt::format("needs one of {}.", listing(kinds)));
  if (kind == "points") {
    table.read("points", amplitude.points);
  } else if (kind == "file") {
    amplitude.kind = AmplitudeKind::kFile;
    table.read("file", amplitude.file);
    const std::filesystem::path path(amplitude.file);
    if (path.is_relative()) amplitude.file = (std::filesystem::path(folder) / path).string();
    for (const CsvTable::Row& row : read_csv(amplitude.file).rows) {
      if (row.values.size() != 2) {
        throw FileError(
            fmt::format("{}:{}: an amplitude has two columns, time in s and factor; this "
                        "line has {}.",
                        amplitude.file, row.line, row.values.size()));
      }
      if (!amplitude.points.empty() && !(row.values[0] > amplitude.points.back().first)) {
        throw FileError(fmt::format("{}:{}: the times must increase, but {} s comes after {} s.",
                                    amplitude.file, row.line, row.values[0],
                                    amplitude.points.back().first));
      }
      if (!amplitude.points.empty() &&
          !std::isfinite(row.values[1] - amplitude.points.back().second)) {
        throw FileError(fmt::format(
            "{}:{}: neighbouring values may differ by up to 1.8e308, but {} comes after {}.",
            amplitude.file, row.line, row.values[1], amplitude.points.back().second));
      }
      amplitude.points.emplace_back(row.values[0], row.values[1]);
    }
  } else if (kind == "sine") {
    amplitude.kind = AmplitudeKind::kSine;
    const TomlTable sine = table.table("sine", {{"frequency", "phase", "offset"}});
    sine.require("frequency", "the frequency in Hz.");
    sine.read("frequency", amplitude.frequency, kNotNegative);
    sine.read("phase", amplitude.phase);
    sine.read("offset", amplitude.offset);
  } else {
    amplitude.kind = AmplitudeKind::kSmoothStep;
    const TomlTable step = table.table("smooth_step", {{"from", "until"}});
    step.require("from", "when the factor begins to grow, in s.");
    step.require("until", "when the factor has become 1, in s.");
    step.read("from", amplitude.from);
    step.read("until", amplitude.until);
  }
  make_amplitude(amplitude);  // throws if the values contradict each other
  return amplitude;
}

std::vector<AmplitudeSettings> read_amplitudes(const TomlTable& root, const std::string& folder) {
  std::vector<AmplitudeSettings> amplitudes;
  for (const TomlTable& table : root.tables("amplitude", table_keys<AmplitudeSettings>())) {
    amplitudes.push_back(read_amplitude(table, folder));
    for (std::size_t i = 0; i + 1 < amplitudes.size(); ++i) {
      if (amplitudes[i].name != amplitudes.back().name) continue;
      table.refuse("name", fmt::format("= {} is the name of another amplitude already.",
                                       in_quotes(amplitudes[i].name)));
    }
  }
  return amplitudes;
}

std::string read_array_name(const TomlTable& parent, std::string_view key) {
  static const TableKeys keys{{"array"}};
  const TomlTable table = parent.table(key, keys);
  table.require("array", "give the name of a cell array of the mesh file.");
  std::string name;
  table.read("array", name);
  return name;
}

FieldSettings read_field(const TomlTable& parent, std::string_view key) {
  static const TableKeys keys{{"file", "formula"}};
  const TomlTable table = parent.table(key, keys);
  if (table.has("file") == table.has("formula")) {
    parent.refuse(
        key,
        "must have either file = \"…\" or formula = [\"…\", \"…\", \"…\"], which gives x, y "
        "and z.");
  }
  FieldSettings field;
  field.where = table.where(table.has("file") ? "file" : "formula");
  table.read("file", field.file);
  if (!table.has("formula")) return field;
  std::vector<std::string> formula;
  table.read("formula", formula);
  if (formula.size() != 3 || std::find(formula.begin(), formula.end(), "") != formula.end()) {
    table.refuse("formula", "must have three texts that are not empty: one each for x, y and z.");
  }
  std::move(formula.begin(), formula.end(), field.formula.begin());
  return field;
}

InitialSettings read_initial(const TomlTable& root, const std::string& folder) {
  InitialSettings initial;
  if (!root.has("initial")) return initial;
  const TomlTable table = root.table("initial", table_keys<InitialSettings>());
  read_keys(table, initial);
  for (const char* key : {"stretch", "displacement", "displacement_array"}) {
    if (table.has(key)) initial.places.emplace(key, table.place(key));
  }
  for (FieldSettings* field : {&initial.displacement_field, &initial.velocity_field}) {
    if (field->file.empty()) continue;
    field->file = (std::filesystem::path(folder) / field->file).lexically_normal().string();
  }
  for (const TomlTable& entry : table.tables("momentum", table_keys<MomentumSettings>())) {
    initial.momentum.push_back(read_momentum(entry));
  }
  return initial;
}

}  // namespace tetraction
