// The elements at which a step failed, as a file of their own.
#pragma once

#include <string>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// The name of the file in the directory of a run.
constexpr const char* kFailedElementsFile = "failed_elements.vtu";

/// Writes the elements of session.failure() with J, numbers, displacements and forces. The failure
/// must not be null. Of a body in parts, process 0 writes those of all processes; the function is collective then.
/// Throws OutputError.
void write_failed_elements(const Session& session, const std::string& path);

}  // namespace tetraction
