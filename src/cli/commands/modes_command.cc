// tetraction modes: natural frequencies and mode shapes of the body of a scene.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "io/results/directory_lock.h"
#include "io/results/result_folders.h"
#include "simulation/facts/free_motions.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mode_writer.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/text_file.h"
#include "tetraction/simulation/scene_modes.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

struct ModesArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  Index count = 10;
  bool loaded = false;  // --static
  bool quiet = false;
  bool json = false;
};

void print_modes(const NormalModes& modes, bool damped) {
  print_result("{:>4}  {:>14}  {:>12}  {:>9}{:>9}{:>9}{}  {}\n", "mode", "frequency [Hz]",
               "period [s]", "mass x", "mass y", "mass z",
               damped ? fmt::format("{:>12}", "damping") : "", "kind");
  for (std::size_t i = 0; i < modes.modes.size(); ++i) {
    const NormalMode& mode = modes.modes[i];
    const Vector3 part = mass_fractions(mode, modes);
    std::string frequency = "-";
    std::string period = "-";
    if (is_free_of_strain(mode.kind)) frequency = "0";
    if (mode.kind == ModeKind::kUnstable) frequency = fmt::format("{:.7g} i", mode.frequency());
    if (is_vibration(mode.kind)) {
      frequency = fmt::format("{:.7g}", mode.frequency());
      period = fmt::format("{:.5g}", 1.0 / mode.frequency());
    }
    std::string damping;
    if (damped) {
      damping = fmt::format(
          "{:>12}", is_vibration(mode.kind) ? fmt::format("{:.4g}", mode.damping_ratio) : "-");
    }
    const std::string growth =
        mode.growth_rate > 0.0 ? fmt::format(", grows by {:.4g} 1/s", mode.growth_rate) : "";
    print_result("{:>4}  {:>14}  {:>12}  {:>9.4f}{:>9.4f}{:>9.4f}{}  {}{}\n", i + 1, frequency,
                 period, part.x(), part.y(), part.z(), damping, to_string(mode.kind), growth);
  }
  print_result("mass: the effective modal mass as a fraction of the mass that can move{}\n",
               damped ? "; damping: the part of the critical damping that each mode has" : "");
}

int compute_modes(const ModesArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = read_scene(arguments.scene, arguments.overrides);
  const std::string directory = output_directory(scene, arguments.out, arguments.overrides);
  check_folder_of_modes(scene, directory);
  std::vector<std::string> unused;
  TetMesh mesh = read_scene_mesh(scene, unused);
  if (!arguments.quiet) {
    if (const std::string remarks = mesh_remarks(mesh, unused); !remarks.empty()) {
      print_note(remarks);
    }
  }
  make_output_directory(directory);
  const DirectoryLock lock(directory);
  const std::unique_ptr<MechanicalSystem> system = make_system(scene, std::move(mesh));
  const PositionsOfModes at = positions_of_modes(scene, *system, arguments.loaded, arguments.count);
  if (const std::string warning = locking_warning(*system); !warning.empty()) {
    print_warning(warning);
  }
  if (const std::string warning = mechanism_warning(find_free_motions(*system)); !warning.empty()) {
    print_warning(warning);
  }
  if (!at.found) {
    print_message("there is no equilibrium about which the body could vibrate: " + at.message);
    return 1;
  }
  if (!at.message.empty()) print_note(at.message);
  const NormalModes modes = normal_modes(*system, at.position, at.options);
  if (const std::string warning = round_off_warning(modes); !warning.empty()) {
    print_warning(warning);
  }
  write_modes(*system, at.position, modes, directory);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const std::string summary =
      modes_summary_json(*system, modes, scene.echo, directory, taken.count());
  write_text_file(directory + "/summary.json", summary);

  if (arguments.json) {
    write_json_result(summary);
  } else if (!arguments.quiet) {
    print_modes(modes, system->is_dissipative());
    if (static_cast<Index>(modes.modes.size()) < arguments.count) {
      print_result("the body has no more than these {} modes\n", modes.modes.size());
    }
    print_result("results: {0}/modes.csv, {0}/mode_*.vtu, {0}/mode_*.pvd, {0}/summary.json\n",
                 directory);
  }
  return 0;
}

}  // namespace

void add_modes_command(CLI::App& app, int& exit_code) {
  constexpr Index kMost = 1000;
  auto arguments = std::make_shared<ModesArguments>();
  CLI::App* command = app.add_subcommand(
      "modes", "Find natural frequencies and mode shapes of the body of a scene");
  command->add_option("scene", arguments->scene, "Scene file (TOML)")->required();
  command->add_option("-n,--count", arguments->count, "Number of modes (default: 10)")
      ->check(CLI::Range(Index{1}, kMost));
  command->add_flag("--static", arguments->loaded,
                    "About the equilibrium under the loads at t = 0, not about the body at rest");
  command->add_option("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  command->add_option("--set", arguments->overrides, "KEY=VALUE: overrides a scene key")
      ->take_all()
      ->allow_extra_args(false);
  command->add_flag("--quiet", arguments->quiet, "Only warnings and errors");
  command->add_flag("--json", arguments->json, "Print summary.json to stdout");
  command->callback([arguments, &exit_code] { exit_code = compute_modes(*arguments); });
}

}  // namespace tetraction
