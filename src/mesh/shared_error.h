// Errors in the input that one part of a body finds and all parts report.
#pragma once

#include <string>

#include "tetraction/core/error.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

/// An InputError that all parts of a body throw together, at the same place.
class SharedInputError : public InputError {
 public:
  using InputError::InputError;
};

/// Calls work(), which must call nothing collective. If it throws an InputError in one part of a body or in
/// several, all parts throw a SharedInputError with the message of the first of them. `part` is null for a
/// whole body, of which errors pass unchanged. Collective.
template <class Work>
void do_in_all_parts(const MeshPart* part, const Work& work) {
  if (part == nullptr) {
    work();
    return;
  }
  std::string reason;
  bool has_failed = false;
  try {
    work();
  } catch (const InputError& error) {
    reason = error.what();
    has_failed = true;
  }
  if (take_from_first(part, has_failed, reason)) throw SharedInputError(reason);
}

}  // namespace tetraction
