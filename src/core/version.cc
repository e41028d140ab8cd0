#include "tetraction/core/version.h"

namespace tetraction {

std::string version() {
  return TETRACTION_VERSION;
}

}  // namespace tetraction
