// Version 1 of the Gmsh format: $NOD and $ELM, without a header.
#pragma once

#include "gmsh_builder.h"
#include "io/text/text_scanner.h"

namespace tetraction {

/// Reads the rest of a file whose first section, $NOD, has been read. Throws FileError.
void read_gmsh1(TextScanner& in, GmshBuilder& mesh);

}  // namespace tetraction
