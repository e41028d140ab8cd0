// Whether a limit on the address space leaves enough of it.
#pragma once

namespace tetraction {

/// To be called at the start. OpenBLAS needs a buffer for each of its threads, for which it asks
/// again and again, without end, if the system has none left (`ulimit -v`). If the limit is too small
/// for them, prints one message and ends the program with exit code 1.
void require_address_space();

}  // namespace tetraction
