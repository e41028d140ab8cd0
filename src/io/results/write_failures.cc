#include "write_failures.h"

#include <string>

namespace tetraction {

void share(const MeshPart* part, std::optional<OutputError>& failure) {
  std::string text = failure ? failure->what() : "";
  if (take_from_first(part, failure.has_value(), text)) failure = OutputError(text);
}

void throw_together(const MeshPart* part, std::optional<OutputError> failure) {
  share(part, failure);
  if (failure) throw OutputError(*failure);
}

}  // namespace tetraction
