// The handling of files that a recorder of results cannot write.
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

// The following functions are collective for a part, and change nothing for a whole mesh (null).

/// If a process has a failure, all have that of the first such process afterwards.
void share(const MeshPart* part, std::optional<OutputError>& failure);

/// As share(). Throws the failure in all processes if there is one.
void throw_together(const MeshPart* part, std::optional<OutputError> failure);

/// Whether this process writes the files that there are once.
inline bool is_first(const MeshPart* part) {
  return part == nullptr || part->rank() == 0;
}

/// Does the work. If a process cannot write, all throw its OutputError. What the work asks other processes comes before
/// anything that can fail.
template <class Work>
void write_together(const MeshPart* part, const Work& work) {
  std::optional<OutputError> failure;
  attempt(failure, work);
  throw_together(part, failure);
}

/// The same for work of process 0.
template <class Work>
void write_once(const MeshPart* part, const Work& work) {
  write_together(part, [&] {
    if (is_first(part)) work();
  });
}

}  // namespace tetraction
