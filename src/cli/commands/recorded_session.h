// Commands that compute one session of a scene and write its results.
#pragma once

#include <CLI/App.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// The arguments of the command line.
struct SessionArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  bool quiet = false;
  bool json = false;
  bool has_checkpoints = false;  ///< whether the command keeps checkpoints
  bool resume = false;           ///< go on with the run in the output directory
  bool force = false;            ///< go on although scene or mesh have changed
  bool may_be_parallel = false;  ///< whether the command works in several processes
};

/// Adds the options of the arguments, which must live as long as the command.
void add_session_options(CLI::App& command, SessionArguments& arguments);

/// Prints the table at the end of a session whose results are in this directory.
using OutcomePrinter = std::function<void(const Session&, const std::string& directory)>;

/// Makes the session of a scene.
using SessionMaker = std::function<std::unique_ptr<Session>(const Scene&, TetMesh)>;

/// Prints the warnings and messages of a session after its run. The first `told` warnings have been printed.
void print_remarks(const Session& session, std::size_t told);

/// Reads the scene, computes the session to its end, writes its results and prints warnings and
/// messages. `label` is what the progress bar says. Returns the exit code.
int run_recorded(const SessionArguments& arguments, const SessionMaker& make_session,
                 const char* label, const OutcomePrinter& print_outcome);

}  // namespace tetraction
