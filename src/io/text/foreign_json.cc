#include "foreign_json.h"

#include <cstdint>
#include <limits>

namespace tetraction {
namespace {

using Json = nlohmann::json;

const Json& no_value() {
  static const Json none;
  return none;
}

}  // namespace

const Json& member_of(const Json& json, const char* key) {
  if (!json.is_object()) return no_value();
  const auto found = json.find(key);
  return found == json.end() ? no_value() : *found;
}

const Json& entry_of(const Json& json, std::size_t i) {
  return json.is_array() && i < json.size() ? json[i] : no_value();
}

double number_or(const Json& json, double other) {
  return json.is_number() ? json.get<double>() : other;
}

Index index_or(const Json& json, Index other) {
  if (!json.is_number_integer()) return other;
  if (json.is_number_unsigned() &&
      json.get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<Index>::max())) {
    return other;
  }
  return json.get<Index>();
}

}  // namespace tetraction
