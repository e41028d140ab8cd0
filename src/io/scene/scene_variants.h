// The variants of a scene that a study compares, which the option --vary gives.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// Reads the scene with these overrides (read_scene()).
using ReadScene = std::function<Scene(const std::vector<std::string>& overrides)>;
/// Reads the mesh of a scene.
using ReadMesh = std::function<TetMesh(const Scene& scene)>;

/// The scene with all combinations of the values that the texts KEY=V1,V2,… give, those of the first key
/// varying slowest. Commas inside of brackets, braces and quotes belong to a value. Without texts there
/// are no variants. The values are set after `overrides`. Throws InputError for a text that is malformed
/// or repeats a value, values that make the same scene, a key that is there twice or that a study sets
/// itself, and what `read` throws. Messages name the variant.
std::vector<StudyVariant> read_variants(const ReadScene& read,
                                        const std::vector<std::string>& overrides,
                                        const std::vector<std::string>& texts);

/// The message of an error with the options --vary that make the variant.
std::string in_variant(const StudyVariant& variant, const std::string& message);

/// Reads the mesh of each variant, of which there is at least one. Variants with the same [mesh] and [initial] share it. Returns that of
/// the first one.
std::shared_ptr<const TetMesh> read_variant_meshes(std::vector<StudyVariant>& variants,
                                                   const ReadMesh& read);

}  // namespace tetraction
