#include "study_drawing.h"

#include <filesystem>
#include <vector>

#include "cli/child_program.h"
#include "plot_study_script.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Exit codes of plot_study.py.
constexpr int kDefect = 1;
constexpr int kUnusable = 2;
constexpr int kUnwritable = 4;

}  // namespace

std::string draw_plots(const std::string& directory, const StudyDrawing& drawing) {
  // Debian's own python3 first: another one on the PATH does not have Debian's matplotlib.
  const char* python = std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  // Isolated: else a csv.py or json.py in the working folder would run in place of Python's own.
  std::vector<std::string> command{python, "-I", "-c", kPlotStudyScript};
  command.push_back("--width=" + std::to_string(drawing.width));
  if (!drawing.title.empty()) command.push_back("--title=" + drawing.title);
  if (!drawing.style.empty()) command.push_back("--style=" + drawing.style);
  command.insert(command.end(), {"--", directory});
  switch (run_child_program(command)) {
    case 0:
      return {};
    case kDefect:
      return "the script failed on some of them, as told above";
    case kUnusable:
      return "the style file or the study cannot be used, as told above";
    case kUnwritable:
      throw OutputError(directory +
                        ": the plots cannot be written, as told above. Make room there, or choose "
                        "another directory with --out; the same command then draws them.");
    default:
      return "python3 and python3-matplotlib are not installed";
  }
}

}  // namespace tetraction
