#include "foreign_json.h"

#include <cstdint>
#include <limits>

namespace tetraction {
namespace {

const ForeignJson& no_value() {
  static const ForeignJson none;
  return none;
}

}  // namespace

const ForeignJson& member_of(const ForeignJson& json, const char* key) {
  if (!json.is_object()) return no_value();
  const auto found = json.find(key);
  return found == json.end() ? no_value() : *found;
}

const ForeignJson& entry_of(const ForeignJson& json, std::size_t i) {
  return json.is_array() && i < json.size() ? json[i] : no_value();
}

double number_or(const ForeignJson& json, double other) {
  return json.is_number() ? json.get<double>() : other;
}

Index index_or(const ForeignJson& json, Index other) {
  if (!json.is_number_integer()) return other;
  if (json.is_number_unsigned() &&
      json.get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<Index>::max())) {
    return other;
  }
  return json.get<Index>();
}

}  // namespace tetraction
