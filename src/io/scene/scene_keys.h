// Turns the settings of a scene into keys with TOML values, which the reader reads back.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A key of a table with its value as TOML text. Keys of a `select` stand for themselves, dotted:
/// "select.plane.axis".
struct SceneKey {
  std::string name;
  std::string value;
  std::string unit{};  ///< for a comment
};
using SceneKeys = std::vector<SceneKey>;

/// The shortest text that reads back as the same number, never as a whole one.
std::string toml_number(double value);
std::string toml_text(const std::string& text);
std::string toml_list(const Vector3& value);
std::string toml_list(const std::vector<std::int64_t>& values);
std::string toml_list(const std::vector<Vector3>& values);

/// All keys whose value is not the default, and those that a section requires. Throws InputError
/// for settings that a scene file cannot express.
SceneKeys keys_of(const MaterialSettings& material);
SceneKeys keys_of(const MeshSettings& mesh);  ///< without file and generate
SceneKeys keys_of(const TimeSettings& time);
SceneKeys keys_of(const SolverSettings& solver);
SceneKeys keys_of(const Damping& damping);
SceneKeys keys_of(const EnvironmentSettings& environment);
SceneKeys keys_of(const OutputSettings& output);
/// The keys of these settings without `select` and without inner tables.
SceneKeys keys_of(const InitialSettings& initial);
SceneKeys keys_of(const FixSettings& fix);
SceneKeys keys_of(const ConstraintSettings& constraint);
SceneKeys keys_of(const ForceSettings& force);
SceneKeys keys_of(const MomentumSettings& momentum);
SceneKeys keys_of(const ShiftSettings& shift);
/// "vertices", "plane.axis", …
SceneKeys keys_of(const Selection& selection);

/// { plane = { axis = "x", at = 0.0 } }
std::string inline_selection(const Selection& selection);
/// { KEY = VALUE, … }, after an optional select.
std::string inline_table(const SceneKeys& keys, const Selection* select = nullptr);

}  // namespace tetraction
