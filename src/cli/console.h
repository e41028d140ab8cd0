// What the program says: results on standard output, everything else on standard error.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace tetraction {

/// To be called first of all. A pipe that nobody reads and a file that grows beyond the limit of the
/// shell become errors of writing instead of the end of the program, and a stream that was closed stays unusable: without this the first file that
/// is opened would take its place and receive what is printed.
void prepare_streams();

/// Writes to standard output. Never throws; what is lost is known to lost_results().
void write_result(std::string_view text);
template <class... Args>
void print_result(fmt::format_string<Args...> format, Args&&... args) {
  write_result(fmt::format(format, std::forward<Args>(args)...));
}

/// Flushes standard output. The system's reason if anything that was printed did not arrive, else
/// empty.
std::string lost_results();

/// Writes to standard error as it is. Never throws: where nobody listens there is nobody to tell.
void print_progress(std::string_view text);

/// "tetraction: …" on standard error, in the same way.
void print_message(std::string_view text);
/// "tetraction: note: …"
void print_note(std::string_view text);
/// "tetraction: warning: …"
void print_warning(std::string_view text);

}  // namespace tetraction
