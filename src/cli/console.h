// Output of the program: results go to standard output, everything else to standard error.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace tetraction {

/// To be called before anything else. After this, a pipe that nobody reads, or a file that grows
/// beyond the shell's limit, causes an error of writing instead of the end of the program. A
/// standard stream that is closed stays unusable. Otherwise the first file that is opened would
/// take its place and receive the printed text.
void prepare_streams();

/// Writes text for people to standard output: printable() (core/quoting.h), because it may name files and quote foreign
/// results. Never throws; lost_results() reports text that could not be written.
void write_result(std::string_view text);
/// The same for JSON.
void write_json_result(std::string_view text);
template <class... Args>
void print_result(fmt::format_string<Args...> format, Args&&... args) {
  write_result(fmt::format(format, std::forward<Args>(args)...));
}

/// Flushes standard output. Returns the system's reason if anything that was printed could not be
/// written, otherwise an empty text.
std::string lost_results();

/// Writes the text to standard error. Never throws, because an error could not be reported
/// anywhere.
void print_progress(std::string_view text);

/// Lets this process print nothing, or print again: of several processes of a run only one speaks.
void set_silent(bool silent);

/// "tetraction: …" on standard error, in the same way.
void print_message(std::string_view text);
/// "tetraction: note: …"
void print_note(std::string_view text);
/// "tetraction: warning: …"
void print_warning(std::string_view text);

}  // namespace tetraction
