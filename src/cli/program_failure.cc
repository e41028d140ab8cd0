#include "program_failure.h"

#include <fmt/format.h>

#include <exception>
#include <new>

#include "tetraction/core/error.h"
#include "tetraction/io/key_tables.h"

namespace tetraction {

ProgramFailure present_failure() {
  try {
    throw;
  } catch (const InputError& error) {
    const std::string page = documentation_of(error.what());
    return {kWrongInput,
            page.empty() ? error.what() : fmt::format("{} See {}.", error.what(), page)};
  } catch (const NumericalError& error) {
    return {kNumericalFailure, error.what()};
  } catch (const FileError& error) {
    return {kBadFile, error.what()};
  } catch (const OutputError& error) {
    return {kCannotWrite, error.what()};
  } catch (const std::bad_alloc&) {
    return {kNumericalFailure,
            "out of memory: the mesh is too large for this machine and this integrator. The "
            "explicit integrators need the least."};
  } catch (const std::exception& error) {
    return {kNumericalFailure, fmt::format("unexpected failure: {}", error.what())};
  }
}

}  // namespace tetraction
