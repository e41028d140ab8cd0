#include "tetraction/core/enum_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {

void refuse_name(const std::string& name, const char* noun, const std::vector<const char*>& known) {
  throw InputError(
      fmt::format("{} is not {}; there are {}.", in_quotes(name), noun, fmt::join(known, ", ")));
}

}  // namespace tetraction
