#include "write_failures.h"

#include <string>

namespace tetraction {

RunEnd end_of(const Session& session, const std::optional<OutputError>& failure,
              const std::function<int()>& stop_code) {
  if (failure) return {"failed", 4, failure->what()};
  const bool is_stopped = session.status() == RunStatus::kCancelled && stop_code;
  return {to_string(session.status()), is_stopped ? stop_code() : exit_code(session.status()),
          session.message()};
}

void share(const MeshPart& part, std::optional<OutputError>& failure) {
  std::string text = failure ? failure->what() : "";
  if (take_from_first(&part, failure.has_value(), text)) failure = OutputError(text);
}

void throw_together(const MeshPart& part, std::optional<OutputError> failure) {
  share(part, failure);
  if (failure) throw OutputError(*failure);
}

}  // namespace tetraction
