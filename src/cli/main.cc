// The program: command line in, exit code out. The only place that prints and exits.
#include <dlfcn.h>
#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/parallel_run.h"
#include "command_line.h"
#include "console.h"
#include "core/spelling.h"
#include "interrupt_guard.h"
#include "option_values.h"
#include "program_failure.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/version.h"
#include "tetraction/io/io_library_versions.h"

namespace {

// OpenBLAS's buffer for a thread (BUFFER_SIZE of its x86-64 and ARM builds).
constexpr std::size_t kBuffer = std::size_t{128} << 20;
// Libraries, stacks and a small scene.
constexpr std::size_t kProgram = std::size_t{250} << 20;

// Makes OpenBLAS allocate the buffer of this thread.
void use_blas_once() {
  using Product = void (*)(const char*, const char*, const int*, const int*, const int*,
                           const double*, const double*, const int*, const double*, const int*,
                           const double*, double*, const int*);
  auto* const product = reinterpret_cast<Product>(dlsym(RTLD_DEFAULT, "dgemm_"));
  if (product == nullptr) return;
  const int n = 64;
  const double one = 1.0;
  const std::vector<double> a(n * n, 1.0);
  std::vector<double> c(n * n, 0.0);
  product("N", "N", &n, &n, &n, &one, a.data(), &n, a.data(), &n, &one, c.data(), &n);
}

// OpenBLAS needs a buffer for each of its threads, for which it asks again and again, without end, if the system has none
// left (`ulimit -v`). If the limit is too small for them, prints one message and ends the program with exit code 1.
void require_address_space() {
  using GetThreads = int (*)();
  auto* const get_threads =
      reinterpret_cast<GetThreads>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  rlimit limit{};
  if (get_threads == nullptr || getrlimit(RLIMIT_AS, &limit) != 0) return;
  if (limit.rlim_cur == RLIM_INFINITY) return;
  const std::size_t needed = kProgram + static_cast<std::size_t>(get_threads()) * kBuffer;
  if (limit.rlim_cur >= needed) {
    use_blas_once();
    return;
  }
  tetraction::print_message(
      fmt::format("out of memory: the limit of the address space (ulimit -v) is {} MB, and the "
                  "program needs at least {} MB on this machine. Raise the limit, or set "
                  "OPENBLAS_NUM_THREADS=1, with which {} MB are enough.",
                  limit.rlim_cur >> 20, needed >> 20, (kProgram + kBuffer) >> 20));
  // The threads of OpenBLAS never end, and the usual exit would wait for them.
  _exit(1);
}

// Frames need the same large arrays again and again. By default the system takes back what is freed, and gives it anew
// page by page, which costs more than to compute what is in it.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 512 << 20);
#endif
}

int report(int code, std::string_view what) {
  tetraction::print_message(what);
  return code;
}

std::string version_text() {
  const tetraction::BlasInfo blas = tetraction::blas_info();
  std::string text = fmt::format("tetraction {}\nBLAS: {}{}{}\n", tetraction::version(),
                                 blas.library, blas.core.empty() ? "" : ", core ", blas.core);
  std::vector<tetraction::LibraryVersion> libraries = tetraction::core_library_versions();
  for (auto& library : tetraction::io_library_versions()) libraries.push_back(std::move(library));
  libraries.push_back({"CLI11", CLI11_VERSION});
#ifdef TETRACTION_QT_VERSION
  libraries.push_back({"Qt", TETRACTION_QT_VERSION});
#endif
  const char* separator = "Libraries: ";
  for (const auto& library : libraries) {
    text += fmt::format("{}{} {}", separator, library.name, library.version);
    separator = ", ";
  }
  return text;
}

// Help and version count as results and go to standard output.
int print_exit(const CLI::App& app, const CLI::Error& request) {
  std::ostringstream out;
  const int code = app.exit(request, out, out);
  tetraction::write_result(out.str());
  return code;
}

// "tetraction mesh", for instance: the words of the command line up to here that name commands.
std::string spoken_name(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent != nullptr ? spoken_name(*parent) + ' ' : "") + command.get_name();
}

int report(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const std::vector<const CLI::App*> choices =
      command->get_subcommands([](const CLI::App* choice) { return !choice->get_group().empty(); });
  const std::vector<std::string> rest = app.remaining(true);
  std::string text = error.what();
  if (command->get_require_subcommand_min() > 0 && !choices.empty() &&
      dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    std::vector<std::string> names;
    names.reserve(choices.size());
    for (const CLI::App* choice : choices) names.push_back(choice->get_name());
    const tetraction::NameList valid(names.begin(), names.end());
    const auto word = std::find_if(rest.begin(), rest.end(), [](const std::string& argument) {
      return argument.empty() || argument.front() != '-';
    });
    text = word == rest.end()
               ? fmt::format("{} needs a command: {}.", spoken_name(*command),
                             tetraction::listing(valid))
               : fmt::format("there is no command \"{} {}\": {}", spoken_name(*command), *word,
                             tetraction::advice(*word, valid));
  }
  const auto unknown = std::find_if(rest.begin(), rest.end(), [](const std::string& argument) {
    return argument.rfind("--", 0) == 0;
  });
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && unknown != rest.end()) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command->get_options()) {
      names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
    }
    const std::string option = unknown->substr(0, unknown->find('='));
    const std::string_view near =
        tetraction::nearest_name(option.substr(2), {names.begin(), names.end()});
    text = near == option.substr(2)
               ? fmt::format("{0} is an option of {1}: write it behind that, as in {1} {0}.",
                             option, spoken_name(*command))
               : fmt::format("{} has no option {}{}", spoken_name(*command), option,
                             near.empty() ? "." : fmt::format(": did you mean --{}?", near));
  }
  report(tetraction::kWrongInput, text);
  tetraction::print_progress(fmt::format("See {} --help.\n", spoken_name(*command)));
  return tetraction::kWrongInput;
}

int run_program(int argc, char** argv) {
  CLI::App app{
      "Simulates the dynamics of hyperelastic solids on tetrahedral meshes with variational "
      "integrators, and reports a complete balance of energy and momentum.",
      "tetraction"};
  app.set_version_flag("--version", version_text);
  app.require_subcommand(1);
  app.fallthrough();
  int threads = 0;
  const auto add_threads = [&threads](CLI::App& command) {
    command.add_option("--threads", threads, "Number of threads; 0: one per core")
        ->check(CLI::Range(0, 1024));
  };
  add_threads(app);

  int exit_code = 0;
  tetraction::add_new_command(app, exit_code);
  tetraction::add_run_command(app, exit_code);
  tetraction::add_static_command(app, exit_code);
  tetraction::add_modes_command(app, exit_code);
  tetraction::add_study_command(app, exit_code);
  tetraction::add_check_command(app, exit_code);
  tetraction::add_mesh_command(app, exit_code);
  tetraction::add_keys_command(app, exit_code);
  tetraction::add_view_command(app, exit_code);
  tetraction::add_document_command(app, exit_code);
  // Accepted by every command, and in the help of those that it matters to.
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() != "mesh") add_threads(*command);
  }
  app.parse_complete_callback([&] {
    tetraction::remember_threads(threads);
    if (threads > 0) tetraction::set_thread_count(threads);
    const std::string command = app.get_subcommands().front()->get_name();
    if (command != "run") tetraction::require_one_process(command);
  });

  tetraction::require_values(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return print_exit(app, help);
  } catch (const CLI::CallForAllHelp& help) {
    return print_exit(app, help);
  } catch (const CLI::CallForVersion& version) {
    return print_exit(app, version);
  } catch (const CLI::ParseError& error) {
    tetraction::let_first_process_speak();  // all have the same command line
    return report(app, error);
  }
  return exit_code;
}

int guarded(int argc, char** argv) {
  try {
    return run_program(argc, argv);
  } catch (...) {
    const tetraction::ProgramFailure failure = tetraction::present_failure();
    return report(failure.code, failure.message);
  }
}

}  // namespace

int main(int argc, char** argv) {
  tetraction::prepare_streams();
  keep_freed_memory();
  require_address_space();
  tetraction::watch_signals();
  tetraction::remember_command_line(argc, argv);
  const int code = guarded(argc, argv);
  const std::string reason = tetraction::lost_results();
  if (reason.empty()) return code;
  report(tetraction::kCannotWrite,
         fmt::format("the results cannot be written to standard output ({}).", reason));
  return code != 0 ? code : tetraction::kCannotWrite;
}
