#include "study_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "io/text/foreign_json.h"
#include "study_grid.h"
#include "study_names.h"
#include "study_row_json.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using Row = StudyRow;

double step_over_limit(const Row& row) {
  return row.step / row.stable_step;
}

constexpr unsigned kFiles = kInCsv | kInJson;
constexpr unsigned kTables = kInTable | kOnPage;
constexpr unsigned kError = kFiles | kTables | kInDiff | kIsError;

const std::array kFields{
    StudyField{"integrator", &Row::integrator, kFiles | kTables, 2, "integrator"},
    StudyField{"step", &Row::step, kFiles | kTables, 4, "step [s]", "{:.4g}"},
    StudyField{"step_over_stable_step", &step_over_limit, kInJson | kDerived | kTables, 5,
               "h/h_crit", "{:.3g}"},
    StudyField{"status", &Row::status, kFiles | kTables, 6, "status"},
    StudyField{"message", &Row::message, kInJson | kOnPage, 19, "message"},
    StudyField{"directory", &Row::directory, kInJson},
    StudyField{"steps", &Row::steps, kFiles | kTables, 8, "steps"},
    StudyField{"wall_seconds", &Row::wall_seconds, kFiles | kTables | kInDiff, 9, "wall [s]",
               "{:.3g}"},
    StudyField{"first_seconds", &Row::first_seconds, kInJson},
    StudyField{"processor_seconds", &Row::processor_seconds, kFiles | kOnPage, 10, "processor [s]",
               "{:.3g}"},
    StudyField{"seconds_per_simulated_second", &Row::seconds_per_simulated_second, kFiles},
    StudyField{"iterations_per_step", &Row::iterations_per_step, kFiles | kTables, 11, "iter/st",
               "{:.2f}"},
    StudyField{"max_relative_energy_drift", &Row::max_relative_energy_drift,
               kFiles | kTables | kInDiff, 12, "energy", "{:.1e}"},
    StudyField{"linear_momentum_drift", &Row::linear_momentum_drift, kFiles | kTables, 13,
               "lin.mom.", "{:.1e}"},
    StudyField{"angular_momentum_drift", &Row::angular_momentum_drift, kFiles | kTables, 14,
               "ang.mom.", "{:.1e}"},
    StudyField{"angular_momentum_drift_allowed", &Row::angular_momentum_drift_allowed, kFiles},
    StudyField{"position_error", &Row::position_error, kError, 15, "pos.error", "{:.2e}"},
    StudyField{"position_error_rms", &Row::position_error_rms, kError, 16, "pos.rms", "{:.2e}"},
    StudyField{"observed_order", &Row::observed_order, kFiles | kDerived | kTables, 18, "order",
               "{:.2f}"},
    StudyField{"stable_step", &Row::stable_step, kFiles},
    StudyField{"variant", &Row::variant, kFiles | kOnPage, 1, "variant"},
    StudyField{"role", &Row::role, kFiles | kOnPage, 7, "role"},
    StudyField{"solver", &Row::solver, kFiles | kTables, 3, "solver"},
    StudyField{"compares_solver", &Row::compares_solver, kInJson},
    StudyField{"probe_error", &Row::probe_error, kError, 17, "probe.err", "{:.2e}"},
    StudyField{"probe_value", &Row::probe_value, kFiles | kTables, 17, "value", "{:.6g}"},
    StudyField{"date", &Row::date, kFiles},
    StudyField{"processor", &Row::processor, kFiles},
    StudyField{"cores", &Row::cores, kFiles},
    StudyField{"threads", &Row::threads, kFiles},
    StudyField{"settings", &Row::settings, kFiles | kTables, 3, "settings"},
    StudyField{"repeats", &Row::repeats, kFiles},
    StudyField{"time_scatter", &Row::time_scatter, kFiles},
    StudyField{"version", {}, kInCsv},
    StudyField{"command", {}, kInCsv},
    StudyField{"reference", {}, kInCsv},
    StudyField{"reference_error", {}, kInCsv},
    StudyField{"timing", StudyField::Timing{&Row::shares_machine}, kFiles}};

constexpr std::array kStatuses{RunStatus::kFinished, RunStatus::kUnstable, RunStatus::kNotConverged,
                               RunStatus::kCancelled};

// A whole number that is not negative.
template <class Integer>
Integer count_of(const nlohmann::json& value) {
  const Index count = index_or(value, -1);
  if (count < 0 || count > Index{std::numeric_limits<Integer>::max()}) {
    throw InputError("no count");
  }
  return static_cast<Integer>(count);
}

// Takes a value for a member of each type.
struct FieldReader {
  const nlohmann::json& json;
  Row& row;

  void operator()(std::monostate) const {}
  void operator()(double (*)(const Row&)) const {}
  void operator()(double Row::*member) const {
    const bool is_limit = member == &Row::stable_step;
    const double absent = is_limit ? std::numeric_limits<double>::infinity()
                                   : std::numeric_limits<double>::quiet_NaN();
    row.*member = json.is_null() ? absent : json.get<double>();
  }
  void operator()(Index Row::*member) const { row.*member = count_of<Index>(json); }
  void operator()(int Row::*member) const { row.*member = count_of<int>(json); }
  void operator()(bool Row::*member) const { row.*member = json.get<bool>(); }
  void operator()(std::string Row::*member) const { row.*member = json.get<std::string>(); }
  void operator()(Integrator Row::*member) const {
    row.*member = integrator_from_string(json.get<std::string>());
  }
  void operator()(RunStatus Row::*member) const {
    row.*member = status_from_string(json.get<std::string>());
  }
  void operator()(StudyRole Row::*member) const {
    row.*member = from_string<StudyRole>(json.get<std::string>());
  }
  void operator()(StudyField::Timing timing) const {
    const auto word = json.get<std::string>();
    if (word != "alone" && word != "shared") throw InputError(word);
    row.*timing.is_shared = word == "shared";
  }
};

struct FieldWriter {
  const Row& row;

  nlohmann::ordered_json operator()(std::monostate) const { return nullptr; }
  nlohmann::ordered_json operator()(double (*value)(const Row&)) const {
    return json_number(value(row));
  }
  nlohmann::ordered_json operator()(StudyField::Timing timing) const {
    return row.*timing.is_shared ? "shared" : "alone";
  }
  template <class Value>
  nlohmann::ordered_json operator()(Value Row::*member) const {
    if constexpr (std::is_same_v<Value, double>) {
      return json_number(row.*member);
    } else if constexpr (std::is_enum_v<Value>) {
      return to_string(row.*member);
    } else {
      return row.*member;
    }
  }
};

}  // namespace

bool StudyField::is_number() const {
  return std::holds_alternative<double Row::*>(member) ||
         std::holds_alternative<Index Row::*>(member) ||
         std::holds_alternative<int Row::*>(member) ||
         std::holds_alternative<double (*)(const Row&)>(member);
}

std::span<const StudyField> study_fields() {
  return kFields;
}

std::vector<const StudyField*> shown_fields(StudyPlace place) {
  std::vector<const StudyField*> fields;
  for (const StudyField& field : kFields) {
    if (field.is_in(place)) fields.push_back(&field);
  }
  std::stable_sort(fields.begin(), fields.end(),
                   [](const StudyField* a, const StudyField* b) { return a->rank < b->rank; });
  return fields;
}

std::string heading_of(const StudyField& field, const StudyResult& result) {
  const bool is_value = field.member == StudyField::Member(&Row::probe_value);
  return is_value ? value_heading(result) : field.heading;
}

nlohmann::ordered_json field_value(const StudyField& field, const StudyRow& row) {
  return std::visit(FieldWriter{row}, field.member);
}

void read_field(const StudyField& field, const nlohmann::json& value, StudyRow& row) {
  std::visit(FieldReader{value, row}, field.member);
}

void add_field(StudyGrid& grid, const StudyField& field, const StudyRow& row) {
  const nlohmann::ordered_json value = field_value(field, row);
  if (value.is_string()) return grid.text(value.get<std::string>());
  const bool is_error = field.is_in(kIsError);
  if (is_error && row.is_reference) {
    return grid.text(field.member == StudyField::Member(&Row::position_error) ? "reference" : "");
  }
  // Explicit steps solve nothing.
  const bool is_absent =
      value.is_null() || (field.member == StudyField::Member(&Row::iterations_per_step) &&
                          !is_implicit(row.integrator));
  const bool is_shared_time =
      row.shares_machine && field.member == StudyField::Member(&Row::wall_seconds);
  if (value.is_number_integer()) {
    return grid.number(static_cast<double>(value.get<Index>()), "{:.0f}");
  }
  grid.number(is_absent ? std::nan("") : value.get<double>(), field.format,
              is_shared_time ? "*" : "");
}

RunStatus status_from_string(const std::string& word) {
  for (const RunStatus status : kStatuses) {
    if (to_string(status) == word) return status;
  }
  throw InputError(word);
}

std::vector<std::string> field_words(const StudyField& field) {
  std::vector<std::string> words;
  if (std::holds_alternative<RunStatus Row::*>(field.member)) {
    for (const RunStatus status : kStatuses) words.push_back(to_string(status));
  } else if (std::holds_alternative<StudyRole Row::*>(field.member)) {
    for (const char* word : names_of<StudyRole>()) words.emplace_back(word);
  }
  return words;
}

}  // namespace tetraction
