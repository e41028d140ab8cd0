// Options of the command line that lack their value.
#pragma once

#include <CLI/App.hpp>

namespace tetraction {

/// Throws InputError if an option that takes a value has none: if nothing follows "--out=", or if the
/// word behind "--out" begins like an option. CLI11 would take that word as the value. A number may
/// have a minus, and any text may follow a sign of equality (--out=-x).
void require_values(const CLI::App& app, int argc, const char* const* argv);

}  // namespace tetraction
