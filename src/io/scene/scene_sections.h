// The tables of a scene, each read into its settings.
#pragma once

#include <functional>
#include <string>

#include "io/toml/toml_table.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The vertices that `select` of a table names; exactly one kind of selection.
Selection read_selection(const TomlTable& parent);
/// The selection in the table under a key that contains the kind of selection directly.
Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table);

/// `folder` is where the scene lies: a mesh file's path is relative to it.
MeshSettings read_mesh_settings(const TomlTable& root, const std::string& folder);

FixSettings read_fix(const TomlTable& table);
ConstraintSettings read_constraint(const TomlTable& table);
ForceSettings read_force(const TomlTable& table);
ProbeSettings read_probe(const TomlTable& table);
MomentumSettings read_momentum(const TomlTable& table);
ShiftSettings read_shift(const TomlTable& table);
InitialSettings read_initial(const TomlTable& root);

/// Reads all sections of a document except the events.
using SectionReader = std::function<Scene(const TomlDocument&)>;
/// Reads [[event]] into `scene`, whose other sections must have been read before.
void read_events(const TomlDocument& document, const TomlTable& root,
                 const SectionReader& read_sections, Scene& scene);

}  // namespace tetraction
