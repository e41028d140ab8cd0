// Values as TOML text, and values of TOML documents.
#pragma once

#include <toml++/toml.h>

#include <nlohmann/json.hpp>
#include <string>

#include "simulation/scene/setting_keys.h"

namespace tetraction {

/// The value of a document. A date is binary.
Json to_json(const toml::node& node);

/// The shortest text that reads back as the same number, never as a whole one.
std::string toml_number(double value);
std::string toml_text(const std::string& text);
/// A name as a key of TOML, in quotes where it needs them.
std::string toml_key(const std::string& name);
/// A value that is not null, on one line: { KEY = VALUE, … } for an object.
std::string toml_value(const Json& value);

}  // namespace tetraction
