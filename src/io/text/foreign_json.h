// JSON of files that anybody may have written or changed.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

using ForeignJson = nlohmann::json;

/// Nested deeper than this, JSON is no result of this program. Functions that call themselves for each level, as those
/// that compare and print JSON do, need memory of the stack for each.
inline constexpr int kMostJsonLevels = 100;

/// The value of the text. Discarded (is_discarded(), and neither object nor array) if the text is no JSON, is nested too
/// deep, or has a member twice, so that it would be ambiguous. Throws nothing but std::bad_alloc.
template <class Json = ForeignJson>
Json parse_foreign_json(const std::string& text) {
  bool is_refused = false;
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto keep = [&](int level, typename Json::parse_event_t event, const Json& value) {
    using Event = typename Json::parse_event_t;
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    const bool is_twice = event == Event::key && !keys.back().insert(value).second;
    is_refused = is_refused || level > kMostJsonLevels || is_twice;
    return !is_refused;
  };
  Json json = Json::parse(text, keep, false);
  if (is_refused) return Json(Json::value_t::discarded);
  return json;
}

/// A member of an object. Null if there is none, or if `json` is no object.
const ForeignJson& member_of(const ForeignJson& json, const char* key);
/// An entry of an array. Null if there is none, or if `json` is no array.
const ForeignJson& entry_of(const ForeignJson& json, std::size_t i);

/// The value if it is a number, otherwise `other`.
double number_or(const ForeignJson& json, double other);
/// The value if it is a whole number that Index can hold, otherwise `other`.
Index index_or(const ForeignJson& json, Index other);

}  // namespace tetraction
