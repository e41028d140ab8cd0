// A row of a study as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// null if the number is not finite.
nlohmann::ordered_json json_number(double value);

nlohmann::ordered_json study_row_json(const StudyRow& row);

/// The same row again; nothing if it is not a whole one, or that of a run that was stopped.
std::optional<StudyRow> study_row_from_json(const nlohmann::json& json);

/// What became of an extrapolated reference.
nlohmann::ordered_json extrapolation_json(const ReferenceExtrapolation& extrapolation);

/// The same again. Throws nlohmann::json::exception if the members are not there, or of another kind.
ReferenceExtrapolation extrapolation_from_json(const nlohmann::json& json);

}  // namespace tetraction
