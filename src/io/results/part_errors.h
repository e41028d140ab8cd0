// Errors of writing that several processes have together.
#pragma once

#include <optional>

#include "tetraction/core/error.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

/// Does the work, and keeps its OutputError in `failure` if that has none.
template <class Work>
void attempt(std::optional<OutputError>& failure, const Work& work) {
  try {
    work();
  } catch (const OutputError& error) {
    if (!failure) failure = error;
  }
}

/// If a process has a failure, all have that of the first such process afterwards. Collective.
void share(const MeshPart& part, std::optional<OutputError>& failure);

/// As share(). Throws the failure in all processes if there is one.
void throw_together(const MeshPart& part, std::optional<OutputError> failure);

}  // namespace tetraction
