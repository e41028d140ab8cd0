#include "study_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/quoting.h"
#include "io/stored_study/study_members.h"
#include "io/text/foreign_json.h"
#include "study_fields.h"
#include "study_grid.h"
#include "study_row_json.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;
using SortedJson = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr double kNoChange = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kWall = "wall_seconds";
constexpr double kSameStep = 1e-9;  // relative difference of equal steps

std::string text_of(const SortedJson& json, const char* key) {
  const SortedJson& value = member_of(json, key);
  return value.is_string() ? value.get<std::string>() : std::string();
}

double number_in(const SortedJson& json, const char* key) {
  return number_or(member_of(json, key), kNoChange);
}

StudyDiffRow row_of(const SortedJson& run, const StudyMembers& read) {
  StudyDiffRow row;
  row.variant = read.text("variant");
  row.integrator = read.text("integrator");
  if (row.integrator.empty()) read.fail("\"integrator\" is empty");
  row.step = read.number("step");
  if (!(row.step > 0.0)) read.fail("\"step\" is not a positive number");
  row.solver = read.text("solver");
  for (const StudyField& field : study_fields()) {
    const std::vector<std::string> words = field_words(field);
    if (!words.empty()) read.word(field.name, words);
  }
  row.status = read.text("status");
  for (const StudyField* field : shown_fields(kInDiff)) {
    const double value = read.number(field->name);
    // The differences of the reference from itself, which are zero, are no errors.
    row.numbers[field->name] = value == 0.0 && field->is_in(kIsError) ? kNoChange : value;
  }
  // Older versions do not write these.
  row.settings = text_of(run, "settings");
  row.processor = text_of(run, "processor");
  row.shares_machine = text_of(run, "timing") == "shared";
  const double threads = number_in(run, "threads");
  row.threads = threads > 0.0 && threads < 1e6 ? static_cast<int>(threads) : 0;
  return row;
}

std::string reference_text(const SortedJson& reference, bool has_probe, const StudyMembers& read) {
  const std::string rule = read.text("integrator");
  const double step = read.number("step");
  if (!(step > 0.0)) read.fail("\"step\" is not a positive number");
  std::string text = fmt::format("{} at {:.4g} s", rule, step);
  const auto is_true = [](const SortedJson& json, const char* key) {
    return json.contains(key) && json[key] == SortedJson(true);
  };
  if (!reference.contains("extrapolation")) return text;
  const SortedJson& extrapolation = reference["extrapolation"];
  if (!extrapolation.is_object()) read.fail("\"extrapolation\" is not a table");
  const bool is_extrapolated =
      is_true(extrapolation, "valid") && (!has_probe || is_true(extrapolation, "probe_valid"));
  return is_extrapolated ? "Richardson extrapolation of " + text : text;
}

std::string rule_of(const StudyDiffRow& row) {
  return row.integrator + (row.settings.empty() ? "" : ", " + row.settings);
}

bool is_same_run(const StudyDiffRow& a, const StudyDiffRow& b) {
  return a.variant == b.variant && a.integrator == b.integrator && a.solver == b.solver &&
         a.settings == b.settings && std::abs(a.step - b.step) <= kSameStep * a.step;
}

// The members whose differences are shown: all but the wall time, of which it is the ratio.
std::vector<const StudyField*> compared_fields(bool has_probe) {
  std::vector<const StudyField*> fields = shown_fields(kInDiff);
  std::erase_if(fields, [&](const StudyField* field) {
    const std::string_view name = field->name;
    return name == kWall || (!has_probe && name == "probe_error");
  });
  return fields;
}

// NaN if one of the two is not known.
double change(const StudyDiffPair& pair, const StudyField& field) {
  return pair.b.numbers.at(field.name) - pair.a.numbers.at(field.name);
}

// NaN if a run shared the cores with others.
double wall_ratio(const StudyDiffPair& pair) {
  const double a = pair.a.numbers.at(kWall);
  const double b = pair.b.numbers.at(kWall);
  const bool counts = !pair.a.shares_machine && !pair.b.shares_machine;
  return counts && a > 0.0 && b > 0.0 ? b / a : kNoChange;
}

// Whether all these rows were made by one machine with one number of threads.
bool have_same_machine(const StudyDiff& diff) {
  if (diff.pairs.empty()) return true;
  const StudyDiffRow& first = diff.pairs.front().a;
  return std::all_of(diff.pairs.begin(), diff.pairs.end(), [&](const StudyDiffPair& pair) {
    return pair.a.processor == first.processor && pair.b.processor == first.processor &&
           pair.a.threads == first.threads && pair.b.threads == first.threads;
  });
}

std::vector<std::string> notes_of(const StudyDiff& diff) {
  std::vector<std::string> notes;
  if (diff.pairs.empty()) {
    notes.emplace_back("No run of A has the variant, integrator, step and solver of a run of B.");
    return notes;
  }
  if (diff.a.reference != diff.b.reference) {
    notes.push_back(fmt::format(
        "The studies have different references, {} and {}. Their errors differ by as much as "
        "these references do.",
        excerpt(diff.a.reference), excerpt(diff.b.reference)));
  }
  if (diff.a.scene != diff.b.scene) {
    notes.push_back(fmt::format("The scenes have different names, {} and {}.",
                                in_quotes(diff.a.scene), in_quotes(diff.b.scene)));
  }
  if (diff.a.error != diff.b.error) {
    notes.push_back(fmt::format("The orders of A are those of the error {}, and those of B of {}.",
                                in_quotes(diff.a.error), in_quotes(diff.b.error)));
  }
  if (diff.a.version != diff.b.version) {
    notes.push_back(fmt::format("The studies were made by the versions {} and {}.",
                                excerpt(diff.a.version), excerpt(diff.b.version)));
  }
  if (!have_same_machine(diff)) {
    notes.emplace_back(
        "The runs were made on different machines or with different numbers of threads: the ratios "
        "of the wall times are not those of the program alone.");
  }
  if (std::any_of(diff.pairs.begin(), diff.pairs.end(), [](const StudyDiffPair& pair) {
        return pair.a.shares_machine || pair.b.shares_machine;
      })) {
    notes.emplace_back(
        "Runs that shared the cores of their machine with others have no ratio of wall times. Make "
        "the study with --jobs 1 to measure them.");
  }
  return notes;
}

std::string head_of(char letter, const StudyFile& study) {
  std::string text = fmt::format("{}: {}", letter, printable(study.path));
  if (!study.date.empty()) text += ", " + excerpt(study.date);
  text += ", reference " + excerpt(study.reference);
  if (std::isfinite(study.reference_error)) {
    text += fmt::format(", whose own error is estimated at {:.2e}", study.reference_error);
  }
  return text + "\n";
}

std::string rows_only_in(char letter, const std::vector<StudyDiffRow>& rows) {
  if (rows.empty()) return {};
  std::string text = fmt::format("\nonly in {}:\n", letter);
  for (const StudyDiffRow& row : rows) {
    text += fmt::format("  {:<16}{:<8}{:>10.4g}{}\n", excerpt(rule_of(row)),
                        row.solver.empty() ? "-" : excerpt(row.solver), row.step,
                        row.variant.empty() ? "" : "  " + excerpt(row.variant));
  }
  return text;
}

// The largest magnitude of a change over the pairs, as a sentence. Empty if there is none.
std::string largest_change(const StudyDiff& diff, const char* name, const char* shown) {
  double largest = kNoChange;
  for (const StudyDiffPair& pair : diff.pairs) {
    largest = std::fmax(largest, std::abs(pair.b.numbers.at(name) - pair.a.numbers.at(name)));
  }
  return std::isfinite(largest)
             ? fmt::format(" The largest change of {} is {:.2e}.", shown, largest)
             : "";
}

OrderedJson json_key(const StudyDiffRow& row) {
  return {{"variant", row.variant},
          {"integrator", row.integrator},
          {"step", row.step},
          {"solver", row.solver},
          {"settings", row.settings}};
}

OrderedJson json_values(const StudyDiffRow& row) {
  OrderedJson json{{"status", row.status}};
  for (const auto& [name, value] : row.numbers) json[name] = json_number(value);
  return json;
}

OrderedJson json_study(const StudyFile& study) {
  return {{"path", study.path},           {"version", study.version},
          {"command", study.command},     {"date", study.date},
          {"scene", study.scene},         {"error", study.error},
          {"reference", study.reference}, {"reference_error", json_number(study.reference_error)}};
}

}  // namespace

StudyFile read_study_file(const std::string& path) {
  const StudyText text = read_study_text(path);
  const std::string& file = text.path;
  const SortedJson& json = text.json;
  const StudyMembers read(file, "", "", &json);
  StudyFile study;
  study.path = path;
  study.version = text_of(json, "version");
  study.command = text_of(json, "command");
  study.date = text_of(json, "date");
  study.scene = read.text("scene");
  study.error = read.text("error");
  const SortedJson& reference = read.member("reference");
  study.reference = reference_text(reference, study.error.rfind("probe.", 0) == 0,
                                   StudyMembers(file, "in \"reference\", ", "", &reference));
  study.reference_error = number_in(reference, "estimated_error");
  if (json["runs"].empty()) read.fail("\"runs\" is empty");
  std::size_t entry = 0;
  bool has_stopped_runs = false;
  for (const SortedJson& run : json["runs"]) {
    StudyDiffRow row = row_of(
        run, StudyMembers(file, fmt::format("in entry {} of \"runs\", ", ++entry), "", &run));
    has_stopped_runs = has_stopped_runs || row.status == to_string(RunStatus::kCancelled);
    // Nobody asked for runs that only serve as a reference.
    const bool is_asked = run["role"] != to_string(StudyRole::kReference) &&
                          run["role"] != to_string(StudyRole::kTrial);
    if (is_asked) study.rows.push_back(std::move(row));
  }
  if (has_stopped_runs ||
      (json.contains("interrupted") && json["interrupted"] == SortedJson(true))) {
    refuse_incomplete_study(path, "it was interrupted");
  }
  return study;
}

StudyDiff diff_studies(StudyFile a, StudyFile b) {
  StudyDiff diff;
  diff.a = std::move(a);
  diff.b = std::move(b);
  std::vector<bool> is_taken(diff.b.rows.size(), false);
  for (const StudyDiffRow& row : diff.a.rows) {
    std::size_t i = 0;
    while (i < is_taken.size() && (is_taken[i] || !is_same_run(row, diff.b.rows[i]))) ++i;
    if (i == is_taken.size()) {
      diff.only_in_a.push_back(row);
    } else {
      is_taken[i] = true;
      diff.pairs.push_back({row, diff.b.rows[i]});
    }
  }
  for (std::size_t i = 0; i < is_taken.size(); ++i) {
    if (!is_taken[i]) diff.only_in_b.push_back(diff.b.rows[i]);
  }
  diff.notes = notes_of(diff);
  return diff;
}

std::string study_diff_table(const StudyDiff& diff) {
  const bool has_probe = diff.a.error == diff.b.error && diff.a.error.rfind("probe.", 0) == 0;
  const std::vector<const StudyField*> fields = compared_fields(has_probe);
  StudyGrid grid;
  for (const char* head : {"integrator", "solver"}) grid.column(head, true);
  for (const char* head : {"step [s]", "status", "wall A[s]", "wall B/A"}) grid.column(head);
  for (const StudyField* field : fields) {
    for (const char* which : {" A", " B"}) grid.column(field->heading + std::string(which));
    grid.column("B - A");
  }
  for (std::size_t i = 0; i < diff.pairs.size(); ++i) {
    const auto& [a, b] = diff.pairs[i];
    if (!a.variant.empty() && (i == 0 || diff.pairs[i - 1].a.variant != a.variant)) {
      grid.line(excerpt(a.variant) + ":");
    }
    grid.row();
    grid.text(rule_of(a));
    grid.text(a.solver);
    grid.number(a.step, "{:.4g}");
    grid.text(a.status == b.status ? a.status : a.status + ", " + b.status);
    grid.number(a.numbers.at(kWall), "{:.3g}");
    grid.number(wall_ratio(diff.pairs[i]), "{:.3g}");
    for (const StudyField* field : fields) {
      grid.number(a.numbers.at(field->name), "{:.2e}");
      grid.number(b.numbers.at(field->name), "{:.2e}");
      grid.number(change(diff.pairs[i], *field), "{:+.2e}");
    }
  }
  std::string text = head_of('A', diff.a) + head_of('B', diff.b);
  if (!grid.is_empty()) text += '\n' + grid.terminal();
  text += rows_only_in('A', diff.only_in_a) + rows_only_in('B', diff.only_in_b);
  text += fmt::format("\n{} of {} runs of A and of {} runs of B match.", diff.pairs.size(),
                      diff.a.rows.size(), diff.b.rows.size());
  text += largest_change(diff, "position_error", "pos.error") +
          largest_change(diff, "max_relative_energy_drift", "the energy error") + '\n';
  for (const std::string& note : diff.notes) text += note + '\n';
  return text;
}

std::string study_diff_json(const StudyDiff& diff) {
  OrderedJson json;
  json["a"] = json_study(diff.a);
  json["b"] = json_study(diff.b);
  json["notes"] = diff.notes;
  json["runs"] = OrderedJson::array();
  for (const StudyDiffPair& pair : diff.pairs) {
    OrderedJson entry = json_key(pair.a);
    entry["a"] = json_values(pair.a);
    entry["b"] = json_values(pair.b);
    entry["wall_ratio"] = json_number(wall_ratio(pair));
    for (const StudyField* field : compared_fields(true)) {
      entry[std::string(field->name) + "_change"] = json_number(change(pair, *field));
    }
    json["runs"].push_back(std::move(entry));
  }
  for (const auto& [key, rows] :
       {std::pair{"only_in_a", &diff.only_in_a}, std::pair{"only_in_b", &diff.only_in_b}}) {
    json[key] = OrderedJson::array();
    for (const StudyDiffRow& row : *rows) json[key].push_back(json_key(row));
  }
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace tetraction
