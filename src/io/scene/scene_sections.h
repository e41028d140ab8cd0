// The tables of a scene, each read into its settings.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/toml/toml_table.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The selection under `select` of a table: exactly one kind of selection, or the name of another.
Selection read_selection(const TomlTable& parent);
/// The selection in the table under a key that contains the kind of selection directly.
Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table);

/// [selection.NAME], in the order of the names.
std::vector<NamedSelection> read_named_selections(const TomlTable& root);

/// `folder` is where the scene lies: the paths of a mesh file and of initial fields are relative to
/// it.
MeshSettings read_mesh_settings(const TomlTable& root, const std::string& folder);

FixSettings read_fix(const TomlTable& table);
ConstraintSettings read_constraint(const TomlTable& table);
/// The keys that a load of this kind may have.
const TableKeys& load_keys(LoadKind kind);
ForceSettings read_load(const TomlTable& table, LoadKind kind);
/// Reads [[amplitude]], with the files that they name. `folder` is where the scene lies.
std::vector<AmplitudeSettings> read_amplitudes(const TomlTable& root, const std::string& folder);
ProbeSettings read_probe(const TomlTable& table);
MomentumSettings read_momentum(const TomlTable& table);
ShiftSettings read_shift(const TomlTable& table);
InitialSettings read_initial(const TomlTable& root, const std::string& folder);
/// Reads [damping] into `scene`, whose materials must have been read before: `ratio` becomes mass
/// damping and viscosity.
void read_damping(const TomlTable& root, Scene& scene);

/// Reads all sections of a document except the events.
using SectionReader = std::function<Scene(const TomlDocument&)>;
/// Reads [[event]] into `scene`, whose other sections must have been read before.
void read_events(const TomlDocument& document, const TomlTable& root,
                 const SectionReader& read_sections, Scene& scene);

}  // namespace tetraction
