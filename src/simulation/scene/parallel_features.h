// Refuses scenes with features that runs in several processes lack.
#pragma once

#include "tetraction/simulation/session.h"

namespace tetraction {

/// Throws InputError, which names the feature and what to do, if the scene or one of its events needs
/// something that a body in parts (TetMesh::part) does not have.
void refuse_what_parts_lack(const Scene& scene, Analysis analysis);

/// Throws InputError unless the scene is for the engine of one process.
void require_local_engine(const Scene& scene);

}  // namespace tetraction
