// Checkpoints of a body in parts, in the form that one process has.
#pragma once

#include "tetraction/io/checkpoint_file.h"
#include "tetraction/mesh/mesh_part.h"
#include "tetraction/simulation/checkpoint.h"

namespace tetraction {

/// On process 0 the checkpoint of the whole body, as one process would have made it, from those of its parts;
/// process 0 needs memory for the state of the whole body. The results of other processes are without meaning. Collective.
Checkpoint collected(const MeshPart& part, const Checkpoint& own);

/// The checkpoint of this part out of that of the whole body, which process 0 has read
/// (checkpoint_from_bytes()); elsewhere `whole` is not read. Collective.
StoredCheckpoint scattered(const MeshPart& part, StoredCheckpoint whole);

}  // namespace tetraction
