#include "toml_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetraction {

Json to_json(const toml::node& node) {
  if (const auto* table = node.as_table()) {
    Json json = Json::object();
    for (const auto& [key, value] : *table) json[std::string(key.str())] = to_json(value);
    return json;
  }
  if (const auto* array = node.as_array()) {
    Json json = Json::array();
    for (const toml::node& entry : *array) json.push_back(to_json(entry));
    return json;
  }
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get();
  if (const auto* integer = node.as_integer()) return integer->get();
  if (const auto* number = node.as_floating_point()) return number->get();
  return Json::binary({});
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  // "3" would be read as an integer, and "-0" would lose its sign.
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

std::string toml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string toml_key(const std::string& name) {
  const bool is_bare = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
  return is_bare ? name : toml_text(name);
}

std::string toml_value(const Json& value) {
  std::string text;
  if (value.is_object()) {
    for (const auto& [key, entry] : value.items()) {
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", toml_key(key), toml_value(entry));
    }
    return text.empty() ? "{}" : "{ " + text + " }";
  }
  if (value.is_array()) {
    for (const Json& entry : value) text += (text.empty() ? "" : ", ") + toml_value(entry);
    return "[" + text + "]";
  }
  if (value.is_string()) return toml_text(value.get<std::string>());
  if (value.is_number_float()) return toml_number(value.get<double>());
  if (value.is_binary()) return "1970-01-01";  // a date, which no key takes
  return value.dump();
}

}  // namespace tetraction
