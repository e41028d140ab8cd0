#include "part_errors.h"

#include <string>

namespace tetraction {

void share(const MeshPart& part, std::optional<OutputError>& failure) {
  const auto first = static_cast<int>(least_of_parts(&part, failure ? part.rank() : part.count()));
  if (first == part.count()) return;
  std::string text = failure ? failure->what() : "";
  part.broadcast(text, first);
  failure = OutputError(text);
}

void throw_together(const MeshPart& part, std::optional<OutputError> failure) {
  share(part, failure);
  if (failure) throw OutputError(*failure);
}

}  // namespace tetraction
