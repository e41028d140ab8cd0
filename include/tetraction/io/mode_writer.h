// Writes normal modes as files: modes.csv, shapes for ParaView, summary.json.
#pragma once

#include <string>

#include "tetraction/solver/normal_modes.h"

namespace tetraction {

/// Writes below a directory, which must exist, for the modes about positions q:
///
/// - `modes.csv`: one row for each mode;
/// - `mode_NN.vtu`: the shape of mode NN on the whole mesh, with the largest displacement 1;
/// - `mode_NN.pvd`: one period of the mode in 24 pictures of the surface, from files in `swing`.
///
/// Removes the files of earlier modes. Throws OutputError.
void write_modes(const MechanicalSystem& system, const Vector& q, const NormalModes& modes,
                 const std::string& directory);

/// Removes what write_modes() wrote into a directory. Throws OutputError.
void remove_modes(const std::string& directory);

/// The text of summary.json about the modes: version, mesh, mass, the modes, the scene. `echo` is that of
/// the scene (Scene::echo), in which the output directory is replaced by the one that was used.
std::string modes_summary_json(const MechanicalSystem& system, const NormalModes& modes,
                               const std::string& echo, const std::string& directory,
                               double seconds);

/// The share of a mode in the moved mass along x, y and z, from 0 to 1. 0 where no mass can move.
Vector3 mass_fractions(const NormalMode& mode, const NormalModes& modes);

/// The frequency with a sign, Hz: negative for unstable modes, the usual sign of imaginary
/// frequencies.
double signed_frequency(const NormalMode& mode);

}  // namespace tetraction
