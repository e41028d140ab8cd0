// Turns PETSc's error codes into exceptions.
#pragma once

#include <fmt/format.h>
#include <petscsys.h>

#include "tetraction/core/error.h"

namespace tetraction::petsc {

/// Throws NumericalError if a call of PETSc has failed.
inline void check(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw NumericalError(
      fmt::format("PETSc: {} failed ({}).", what, text == nullptr ? "unknown error" : text));
}

}  // namespace tetraction::petsc
