#include "study_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/quoting.h"
#include "io/study/study_fields.h"
#include "io/study/study_grid.h"
#include "io/study/study_names.h"
#include "io/study/study_row_json.h"
#include "study_members.h"

namespace tetraction {
namespace {

using DiffJson = nlohmann::ordered_json;

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
constexpr double kSameStep = 1e-9;  // relative difference of equal steps

bool is_same_run(const StudyRow& a, const StudyRow& b) {
  return a.variant == b.variant && a.integrator == b.integrator && a.solver == b.solver &&
         a.settings == b.settings && std::abs(a.step - b.step) <= kSameStep * a.step;
}

std::string rule_of(const StudyRow& row) {
  return to_string(row.integrator) + (row.settings.empty() ? "" : ", " + row.settings);
}

// The members whose differences are shown: all but the wall time, of which it is the ratio.
std::vector<const StudyField*> compared_fields(bool has_probe) {
  std::vector<const StudyField*> fields = shown_fields(kInDiff);
  std::erase_if(fields, [&](const StudyField* field) {
    return field->member == StudyField::Member(&StudyRow::wall_seconds) ||
           (!has_probe && field->member == StudyField::Member(&StudyRow::probe_error));
  });
  return fields;
}

// The differences of the reference from itself, which are zero, are no errors.
double value_of(const StudyField& field, const StudyRow& row) {
  const DiffJson value = field_value(field, row);
  const bool is_known = value.is_number() && !(row.is_reference && field.is_in(kIsError));
  return is_known ? value.get<double>() : kNotKnown;
}

double change_of(const StudyField& field, const StudyRow& a, const StudyRow& b) {
  return value_of(field, b) - value_of(field, a);
}

double wall_ratio(const StudyRow& a, const StudyRow& b) {
  const bool counts = !a.shares_machine && !b.shares_machine;
  return counts && a.wall_seconds > 0.0 && b.wall_seconds > 0.0 ? b.wall_seconds / a.wall_seconds
                                                                : kNotKnown;
}

DiffJson json_key(const StudyRow& row) {
  return {{"variant", row.variant},
          {"integrator", to_string(row.integrator)},
          {"step", row.step},
          {"solver", row.solver},
          {"settings", row.settings}};
}

DiffJson json_values(const StudyRow& row) {
  DiffJson json{{"status", to_string(row.status)}};
  for (const StudyField* field : shown_fields(kInDiff)) {
    json[field->name] = json_number(value_of(*field, row));
  }
  return json;
}

}  // namespace

StudyDiff::Side::Side(const std::string& name)
    : path(name),
      study(read_stored_study(name)),
      error(error_word(study.result)),
      reference(reference_name(study.result)) {
  const StudyResult& result = study.result;
  if (result.rows.empty()) StudyMembers(path, "").fail("\"runs\" is empty");
  bool is_interrupted = result.is_interrupted;
  for (const StudyRow& row : result.rows) {
    is_interrupted = is_interrupted || row.status == RunStatus::kCancelled;
    const bool is_asked = row.role == StudyRole::kRun || row.role == StudyRole::kVariant;
    if (is_asked) rows.push_back(&row);
  }
  if (is_interrupted) refuse_incomplete_study(path, "it was interrupted");
}

StudyDiff::StudyDiff(const std::string& a, const std::string& b) : a_(a), b_(b) {
  b_.only = b_.rows;
  for (const StudyRow* row : a_.rows) {
    const auto same = std::find_if(b_.only.begin(), b_.only.end(), [&](const StudyRow* other) {
      return is_same_run(*row, *other);
    });
    if (same == b_.only.end()) {
      a_.only.push_back(row);
    } else {
      pairs_.push_back({row, *same});
      b_.only.erase(same);
    }
  }
}

bool StudyDiff::has_one_machine() const {
  const auto is_first = [&](const StudyRow& row) {
    const StudyRow& first = *pairs_.front().a;
    return row.processor == first.processor && row.threads == first.threads;
  };
  return std::all_of(pairs_.begin(), pairs_.end(),
                     [&](const Pair& pair) { return is_first(*pair.a) && is_first(*pair.b); });
}

std::vector<std::string> StudyDiff::notes() const {
  if (pairs_.empty()) {
    return {"No run of A has the variant, integrator, step and solver of a run of B."};
  }
  std::vector<std::string> notes;
  const auto note = [&](const std::string& a, const std::string& b, const char* sentence) {
    if (a != b) notes.push_back(fmt::format(fmt::runtime(sentence), excerpt(a), excerpt(b)));
  };
  note(a_.reference, b_.reference,
       "The studies have different references, {} and {}. Their errors differ by as much as these "
       "references do.");
  note(a_.study.scene, b_.study.scene, "The scenes have different names, \"{}\" and \"{}\".");
  for (const std::string& difference : differences_of_scenes()) notes.push_back(difference);
  note(a_.error, b_.error,
       "The orders of A are those of the error \"{}\", and those of B of \"{}\".");
  note(a_.study.provenance.version, b_.study.provenance.version,
       "The studies were made by the versions {} and {}.");
  if (!has_one_machine()) {
    notes.emplace_back(
        "The runs were made on different machines or with different numbers of threads: the ratios "
        "of the wall times are not those of the program alone.");
  }
  if (std::any_of(pairs_.begin(), pairs_.end(), [](const Pair& pair) {
        return pair.a->shares_machine || pair.b->shares_machine;
      })) {
    notes.emplace_back(
        "Runs that shared the cores of their machine with others have no ratio of wall times. Make "
        "the study with --jobs 1 to measure them.");
  }
  return notes;
}

// What the runs compute, as far as the studies tell.
std::vector<std::string> StudyDiff::differences_of_scenes() const {
  std::vector<std::string> differences;
  const StudyResult& a = a_.study.result;
  const StudyResult& b = b_.study.result;
  if (a.end != b.end) {
    differences.push_back(
        fmt::format("The scenes end at different times, {} s and {} s.", a.end, b.end));
  }
  if (!a_.study.plan || !b_.study.plan) return differences;
  const RunDigests& own = a_.study.plan->digests;
  const RunDigests& its = b_.study.plan->digests;
  bool has_other_mesh = false;
  bool has_other_scene = false;
  // Both have as many digests as variants, of which there is at least one without a name.
  const auto name = [](const StudyResult& result, std::size_t i) {
    return i < result.variants.size() ? result.variants[i].name : std::string();
  };
  for (std::size_t i = 0; i < own.scenes().size(); ++i) {
    for (std::size_t k = 0; k < its.scenes().size(); ++k) {
      if (name(a, i) != name(b, k)) continue;
      has_other_mesh = has_other_mesh || own.meshes()[i] != its.meshes()[k];
      has_other_scene = has_other_scene || own.scenes()[i] != its.scenes()[k];
    }
  }
  if (has_other_mesh) differences.emplace_back("The meshes differ.");
  if (has_other_scene && a.end == b.end) {
    differences.emplace_back(
        "The scenes, or files that they read, differ in other keys than [output]: equal runs "
        "compute different motions.");
  }
  return differences;
}

std::string StudyDiff::head(char letter, const Side& side) {
  const std::string& date = side.study.provenance.date;
  const double error = side.study.result.reference_error;
  return fmt::format(
      "{}: {}{}, reference {}{}\n", letter, printable(side.path),
      date.empty() ? "" : ", " + excerpt(date), excerpt(side.reference),
      std::isfinite(error) ? fmt::format(", whose own error is estimated at {:.2e}", error) : "");
}

std::string StudyDiff::only_in(char letter, const Side& side) {
  std::string text = side.only.empty() ? "" : fmt::format("\nonly in {}:\n", letter);
  for (const StudyRow* row : side.only) {
    text += fmt::format("  {:<16}{:<8}{:>10.4g}{}\n", excerpt(rule_of(*row)),
                        row->solver.empty() ? "-" : excerpt(row->solver), row->step,
                        row->variant.empty() ? "" : "  " + excerpt(row->variant));
  }
  return text;
}

std::string StudyDiff::table() const {
  const std::vector<const StudyField*> fields =
      compared_fields(a_.error == b_.error && !a_.study.result.error_probe.empty());
  StudyGrid grid;
  for (const char* name : {"integrator", "solver"}) grid.column(name, true);
  for (const char* name : {"step [s]", "status", "wall A[s]", "wall B/A"}) grid.column(name);
  for (const StudyField* field : fields) {
    for (const char* which : {" A", " B"}) grid.column(field->heading + std::string(which));
    grid.column("B - A");
  }
  std::vector<double> largest(fields.size(), kNotKnown);  // changes
  std::string variant;
  for (const auto& [a, b] : pairs_) {
    if (a->variant != variant) grid.line(excerpt(a->variant) + ":");
    variant = a->variant;
    grid.row();
    grid.text(rule_of(*a));
    grid.text(a->solver);
    grid.number(a->step, "{:.4g}");
    grid.text(a->status == b->status ? to_string(a->status)
                                     : to_string(a->status) + ", " + to_string(b->status));
    grid.number(a->wall_seconds, "{:.3g}");
    grid.number(wall_ratio(*a, *b), "{:.3g}");
    for (std::size_t i = 0; i < fields.size(); ++i) {
      for (const StudyRow* row : {a, b}) grid.number(value_of(*fields[i], *row), "{:.2e}");
      const double change = change_of(*fields[i], *a, *b);
      grid.number(change, "{:+.2e}");
      largest[i] = std::fmax(largest[i], std::abs(change));
    }
  }
  std::string text = head('A', a_) + head('B', b_);
  if (!grid.is_empty()) text += '\n' + grid.terminal();
  text += only_in('A', a_) + only_in('B', b_);
  text += fmt::format("\n{} of {} runs of A and of {} runs of B match.", pairs_.size(),
                      a_.rows.size(), b_.rows.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!std::isfinite(largest[i])) continue;
    text += fmt::format(" The largest change of {} is {:.2e}.", fields[i]->heading, largest[i]);
  }
  for (const std::string& note : notes()) text += '\n' + note;
  return text + '\n';
}

std::string StudyDiff::json() const {
  DiffJson json;
  for (const auto& [key, side] : {std::pair{"a", &a_}, std::pair{"b", &b_}}) {
    json[key] = {{"path", side->path},
                 {"version", side->study.provenance.version},
                 {"command", side->study.provenance.command},
                 {"date", side->study.provenance.date},
                 {"scene", side->study.scene},
                 {"error", side->error},
                 {"reference", side->reference},
                 {"reference_error", json_number(side->study.result.reference_error)}};
  }
  json["notes"] = notes();
  json["runs"] = DiffJson::array();
  for (const auto& [a, b] : pairs_) {
    DiffJson entry = json_key(*a);
    entry["a"] = json_values(*a);
    entry["b"] = json_values(*b);
    entry["wall_ratio"] = json_number(wall_ratio(*a, *b));
    for (const StudyField* field : compared_fields(true)) {
      entry[std::string(field->name) + "_change"] = json_number(change_of(*field, *a, *b));
    }
    json["runs"].push_back(std::move(entry));
  }
  for (const auto& [key, side] : {std::pair{"only_in_a", &a_}, std::pair{"only_in_b", &b_}}) {
    json[key] = DiffJson::array();
    for (const StudyRow* row : side->only) json[key].push_back(json_key(*row));
  }
  return json.dump(2, ' ', false, DiffJson::error_handler_t::replace) + "\n";
}

}  // namespace tetraction
