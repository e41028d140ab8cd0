// The handling of files that a recorder of results cannot write.
#pragma once

#include <functional>
#include <optional>

#include "tetraction/core/error.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/mesh/mesh_part.h"
#include "tetraction/simulation/session.h"

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

/// How the run ended, for summary.json. `stop_code` may be empty; it gives the exit code of a run that was
/// stopped.
RunEnd end_of(const Session& session, const std::optional<OutputError>& failure,
              const std::function<int()>& stop_code);

/// If a process has a failure, all have that of the first such process afterwards. Collective.
void share(const MeshPart& part, std::optional<OutputError>& failure);

/// As share(). Throws the failure in all processes if there is one.
void throw_together(const MeshPart& part, std::optional<OutputError> failure);

}  // namespace tetraction
