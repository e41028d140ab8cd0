#include "study_row_json.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "io/text/foreign_json.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

double number_of(const nlohmann::json& json, const char* key, double absent) {
  return json.at(key).is_null() ? absent : json.at(key).get<double>();
}

// A whole number that is not negative. Throws InputError for anything else.
template <class Integer>
Integer count_of(const nlohmann::json& json, const char* key) {
  const Index value = index_or(json.at(key), -1);
  if (value < 0 || value > Index{std::numeric_limits<Integer>::max()}) throw InputError(key);
  return static_cast<Integer>(value);
}

template <class Value, std::size_t N>
Value named(const std::string& name, const std::array<Value, N>& values) {
  for (const Value value : values) {
    if (to_string(value) == name) return value;
  }
  throw InputError(name);
}

}  // namespace

// JSON has no infinity and no NaN: absent numbers are null.
nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) return value;
  return nullptr;
}

nlohmann::ordered_json study_row_json(const StudyRow& row) {
  return {{"integrator", to_string(row.integrator)},
          {"step", row.step},
          {"solver", row.solver},
          {"compares_solver", row.compares_solver},
          {"variant", row.variant},
          {"role", to_string(row.role)},
          {"stable_step", json_number(row.stable_step)},
          {"step_over_stable_step", json_number(row.step / row.stable_step)},
          {"status", to_string(row.status)},
          {"message", row.message},
          {"directory", row.directory},
          {"steps", row.steps},
          {"wall_seconds", row.wall_seconds},
          {"processor_seconds", json_number(row.processor_seconds)},
          {"seconds_per_simulated_second", json_number(row.seconds_per_simulated_second)},
          {"iterations_per_step", row.iterations_per_step},
          {"max_relative_energy_drift", json_number(row.max_relative_energy_drift)},
          {"linear_momentum_drift", json_number(row.linear_momentum_drift)},
          {"angular_momentum_drift", json_number(row.angular_momentum_drift)},
          {"angular_momentum_drift_allowed", json_number(row.angular_momentum_drift_allowed)},
          {"position_error", json_number(row.position_error)},
          {"position_error_rms", json_number(row.position_error_rms)},
          {"observed_order", json_number(row.observed_order)},
          {"probe_error", json_number(row.probe_error)},
          {"date", row.date},
          {"processor", row.processor},
          {"cores", row.cores},
          {"threads", row.threads},
          {"timing", row.shares_machine ? "shared" : "alone"}};
}

std::optional<StudyRow> study_row_from_json(const nlohmann::json& json) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto get = [&](const char* key) { return number_of(json, key, kNone); };
  StudyRow row;
  try {
    row.integrator = integrator_from_string(json.at("integrator").get<std::string>());
    row.step = json.at("step").get<double>();
    row.solver = json.at("solver").get<std::string>();
    row.compares_solver = json.at("compares_solver").get<bool>();
    row.variant = json.at("variant").get<std::string>();
    row.role = named(json.at("role").get<std::string>(),
                     std::array{StudyRole::kRun, StudyRole::kReference, StudyRole::kVariant});
    row.stable_step = number_of(json, "stable_step", std::numeric_limits<double>::infinity());
    row.status =
        named(json.at("status").get<std::string>(),
              std::array{RunStatus::kFinished, RunStatus::kUnstable, RunStatus::kNotConverged});
    row.message = json.at("message").get<std::string>();
    row.directory = json.at("directory").get<std::string>();
    row.steps = count_of<Index>(json, "steps");
    row.wall_seconds = get("wall_seconds");
    row.processor_seconds = get("processor_seconds");
    row.seconds_per_simulated_second = get("seconds_per_simulated_second");
    row.iterations_per_step = get("iterations_per_step");
    row.max_relative_energy_drift = get("max_relative_energy_drift");
    row.linear_momentum_drift = get("linear_momentum_drift");
    row.angular_momentum_drift = get("angular_momentum_drift");
    row.angular_momentum_drift_allowed = get("angular_momentum_drift_allowed");
    row.position_error = get("position_error");
    row.position_error_rms = get("position_error_rms");
    row.probe_error = get("probe_error");
    row.date = json.at("date").get<std::string>();
    row.processor = json.at("processor").get<std::string>();
    row.cores = count_of<int>(json, "cores");
    row.threads = count_of<int>(json, "threads");
    const auto timing = json.at("timing").get<std::string>();
    if (timing != "alone" && timing != "shared") return {};
    row.shares_machine = timing == "shared";
  } catch (const nlohmann::json::exception&) {
    return {};
  } catch (const InputError&) {  // an unknown word, or a number that is none
    return {};
  }
  row.observed_order = kNone;  // depends on the other runs
  return row;
}

nlohmann::ordered_json extrapolation_json(const ReferenceExtrapolation& extrapolation) {
  return {{"step", extrapolation.step},
          {"valid", extrapolation.is_valid},
          {"reason", extrapolation.reason},
          {"exact", extrapolation.is_exact},
          {"probe_valid", extrapolation.probe_is_valid},
          {"probe_reason", extrapolation.probe_reason},
          {"probe_exact", extrapolation.probe_is_exact},
          {"order_at_end", json_number(extrapolation.order_at_end)},
          {"order_over_time", json_number(extrapolation.order_over_time)},
          {"order_of_probe", json_number(extrapolation.order_of_probe)},
          {"estimated_error_at_end", json_number(extrapolation.error_at_end)},
          {"estimated_error_over_time", json_number(extrapolation.error_over_time)},
          {"estimated_error_of_probe", json_number(extrapolation.error_of_probe)},
          {"finest_error_at_end", json_number(extrapolation.finest_error_at_end)}};
}

}  // namespace tetraction
