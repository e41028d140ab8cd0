// Commands that compute one session of a scene and write its results.
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "resume.h"
#include "tetraction/io/run_recorder.h"
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

/// The inputs of a session.
struct SessionInputs {
  Scene scene;
  std::string directory;            ///< of the results
  TetMesh mesh;                     ///< empty unless it was read
  std::vector<std::string> unused;  ///< parts of the file of the mesh
  double mesh_time = 0.0;           ///< that its reading took, s
};

/// Chooses the directory of the results, and, if this process reads the mesh, checks the directory and reads it.
SessionInputs session_inputs(const SessionArguments& arguments, Scene scene, bool reads_mesh);

/// Prints what was changed or left out in the inputs unless the command is quiet.
void print_input_remarks(const SessionArguments& arguments, const SessionInputs& inputs);

/// The differences between runs of one process and of several.
struct RunControl {
  Observer& interrupt;             ///< ends the run after a signal
  std::function<int()> stop_code;  ///< the exit code of such a run
  PointFinder find_resume_point;
};

/// Computes the session to its end, from a checkpoint if the arguments say so, writes its results and prints warnings,
/// messages and the outcome. The recorder's directory is locked. `label` is what the progress bar says. Returns the
/// exit code. All processes of a body in parts call it together.
int record_session(Session& session, RunRecorder& recorder, const SessionArguments& arguments,
                   const SessionInputs& inputs, const RunControl& control, const char* label,
                   const OutcomePrinter& print_outcome);

/// Reads the scene and records its session, in several processes if it was started so. Returns the exit code.
int run_recorded(const SessionArguments& arguments, const SessionMaker& make_session,
                 const char* label, const OutcomePrinter& print_outcome);

}  // namespace tetraction
