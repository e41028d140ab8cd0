#include "study_row_json.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "study_fields.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using Extrapolation = ReferenceExtrapolation;

template <class Value, std::size_t N>
using Members = std::array<std::pair<const char*, Value Extrapolation::*>, N>;

constexpr Members<bool, 4> kFlags{{{"valid", &Extrapolation::is_valid},
                                   {"exact", &Extrapolation::is_exact},
                                   {"probe_valid", &Extrapolation::probe_is_valid},
                                   {"probe_exact", &Extrapolation::probe_is_exact}}};
constexpr Members<std::string, 2> kReasons{
    {{"reason", &Extrapolation::reason}, {"probe_reason", &Extrapolation::probe_reason}}};
constexpr Members<double, 7> kNumbers{
    {{"order_at_end", &Extrapolation::order_at_end},
     {"order_over_time", &Extrapolation::order_over_time},
     {"order_of_probe", &Extrapolation::order_of_probe},
     {"estimated_error_at_end", &Extrapolation::error_at_end},
     {"estimated_error_over_time", &Extrapolation::error_over_time},
     {"estimated_error_of_probe", &Extrapolation::error_of_probe},
     {"finest_error_at_end", &Extrapolation::finest_error_at_end}}};

}  // namespace

// JSON has no infinity and no NaN: absent numbers are null.
nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) return value;
  return nullptr;
}

nlohmann::ordered_json study_row_json(const StudyRow& row) {
  nlohmann::ordered_json json;
  for (const StudyField& field : study_fields()) {
    if (field.is_in(kInJson)) json[field.name] = field_value(field, row);
  }
  return json;
}

std::optional<StudyRow> study_row_from_json(const nlohmann::json& json) {
  StudyRow row;
  row.observed_order = std::numeric_limits<double>::quiet_NaN();  // depends on the other runs
  try {
    for (const StudyField& field : study_fields()) {
      if (field.is_in(kInJson) && !field.is_in(kDerived)) {
        read_field(field, json.at(field.name), row);
      }
    }
  } catch (const nlohmann::json::exception&) {
    return {};
  } catch (const InputError&) {  // an unknown word, or a number that is none
    return {};
  }
  if (row.status == RunStatus::kCancelled) return {};
  return row;
}

nlohmann::ordered_json extrapolation_json(const ReferenceExtrapolation& extrapolation) {
  nlohmann::ordered_json json{{"step", extrapolation.step}};
  for (const auto& [key, member] : kFlags) json[key] = extrapolation.*member;
  for (const auto& [key, member] : kReasons) json[key] = extrapolation.*member;
  for (const auto& [key, member] : kNumbers) json[key] = json_number(extrapolation.*member);
  return json;
}

ReferenceExtrapolation extrapolation_from_json(const nlohmann::json& json) {
  ReferenceExtrapolation extrapolation;
  extrapolation.step = json.at("step").get<double>();
  for (const auto& [key, member] : kFlags) extrapolation.*member = json.at(key).get<bool>();
  for (const auto& [key, member] : kReasons) {
    extrapolation.*member = json.at(key).get<std::string>();
  }
  for (const auto& [key, member] : kNumbers) {
    const nlohmann::json& value = json.at(key);
    extrapolation.*member =
        value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
  return extrapolation;
}

}  // namespace tetraction
