// The tables of a scene, each read into its settings.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"
#include "toml_table.h"

namespace tetraction {

/// The vertices that `select` of a table names; exactly one kind of selection.
Selection read_selection(const TomlTable& parent);

/// `folder` is where the scene lies: a mesh file's path is relative to it.
MeshSettings read_mesh_settings(const TomlTable& root, const std::string& folder);

FixSettings read_fix(const TomlTable& table);
ForceSettings read_force(const TomlTable& table);
InitialSettings read_initial(const TomlTable& root);

/// The keys of [[fix]], [[force]].
const TableKeys& fix_keys();
const TableKeys& force_keys();

}  // namespace tetraction
