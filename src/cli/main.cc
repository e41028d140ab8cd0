// The program: command line in, exit code out. The only place that prints and exits.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "commands.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/version.h"

namespace {

// Exit codes, as documented in README.md.
constexpr int kNumericalFailure = 1;
constexpr int kWrongInput = 2;
constexpr int kBadFile = 3;
constexpr int kCannotWrite = 4;

int report(int code, const char* what) {
  fmt::print(stderr, "tetraction: {}\n", what);
  return code;
}

std::string version_text() {
  const tetraction::BlasInfo blas = tetraction::blas_info();
  return fmt::format("tetraction {}\nBLAS: {}{}{}", tetraction::version(), blas.library,
                     blas.core.empty() ? "" : ", core ", blas.core);
}

int run_program(int argc, char** argv) {
  CLI::App app{
      "Moves hyperelastic tetrahedral solids through time with the Hamilton-Pontryagin "
      "variational integrator, explicit or implicit.",
      "tetraction"};
  app.set_version_flag("--version", version_text);
  app.require_subcommand(1);
  app.fallthrough();
  int threads = 0;
  app.add_option("--threads", threads, "Number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024));

  int exit_code = 0;
  tetraction::add_run_command(app, exit_code);
  tetraction::add_study_command(app, exit_code);
  tetraction::add_check_command(app, exit_code);
  tetraction::add_mesh_command(app, exit_code);
  tetraction::add_view_command(app, exit_code);
  app.parse_complete_callback([&] {
    if (threads > 0) tetraction::set_thread_count(threads);
  });

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForAllHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::ParseError& error) {
    return report(kWrongInput, fmt::format("{}\nSee tetraction --help.", error.what()).c_str());
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_program(argc, argv);
  } catch (const tetraction::InputError& error) {
    return report(kWrongInput, error.what());
  } catch (const tetraction::FileError& error) {
    return report(kBadFile, error.what());
  } catch (const tetraction::OutputError& error) {
    return report(kCannotWrite, error.what());
  } catch (const std::bad_alloc&) {
    return report(kNumericalFailure,
                  "out of memory: the mesh is too large for this machine and this integrator. The "
                  "explicit integrators need the least.");
  } catch (const std::exception& error) {
    return report(kNumericalFailure, fmt::format("unexpected failure: {}", error.what()).c_str());
  }
}
