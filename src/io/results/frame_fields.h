// The fields of a session's present state that a frame has.
#pragma once

#include <string>
#include <vector>

#include "tetraction/io/frame_writer.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// The present state with the fields of `names`, as OutputSettings::fields has them.
Frame make_frame(const Session& session, const std::vector<std::string>& names);

}  // namespace tetraction
