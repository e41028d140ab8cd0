// The meaning of an exception for the program.
#pragma once

#include <string>

namespace tetraction {

// Exit codes, as documented in docs/outputs.md.
inline constexpr int kNumericalFailure = 1;
inline constexpr int kWrongInput = 2;
inline constexpr int kBadFile = 3;
inline constexpr int kCannotWrite = 4;

/// How the program ends.
struct ProgramFailure {
  int code = 0;  ///< the exit code
  std::string message;
};

/// The failure of the exception that is being handled. Call it in a catch block.
ProgramFailure present_failure();

}  // namespace tetraction
