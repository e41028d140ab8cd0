#include "study_drawing.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "cli/child_program.h"
#include "cli/interrupt_guard.h"
#include "io/text/output_file.h"
#include "plot_study_script.h"

namespace tetraction {
namespace {

// Exit codes of study_plots/program.py.
constexpr int kDefect = 1;
constexpr int kUnusable = 2;
constexpr int kUnwritable = 4;

}  // namespace

DrawnPlots draw_plots(const std::string& directory, const StudyDrawing& drawing) {
  // Debian's own python3 first: another one on the PATH does not have Debian's matplotlib.
  const char* python = std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  // Isolated: else a csv.py or json.py in the working folder would run in place of Python's own.
  std::vector<std::string> command{python, "-I", "-c", kPlotStudyScript};
  command.push_back("--width=" + std::to_string(drawing.width));
  if (!drawing.title.empty()) command.push_back("--title=" + drawing.title);
  if (!drawing.style.empty()) command.push_back("--style=" + drawing.style);
  const std::string failures = directory + "/.failed-plots";
  remove_output(failures);
  command.push_back("--failures=" + failures);
  command.insert(command.end(), {"--", directory});
  const int code = run_child_program(command);
  std::string names = read_output(failures);
  remove_output(failures);
  if (code != 0 && InterruptGuard::interrupted())
    return {"their drawing was interrupted", false, true};
  if (!names.empty()) {
    for (auto at = names.find('\n'); at != std::string::npos; at = names.find('\n', at)) {
      names.replace(at, 1, ", ");
    }
    if (code == kUnwritable) {
      return {fmt::format("some of their files cannot be written ({})", names), true};
    }
    return {fmt::format("the script failed on some of them ({})", names)};
  }
  switch (code) {
    case 0:
      return {};
    case kDefect:
      return {"the script failed, as told above"};
    case kUnusable:
      return {"the style file or the study cannot be used, as told above"};
    case kUnwritable:
      return {"their files cannot be written, as told above", true};
    default:
      return {"python3 and python3-matplotlib are not installed"};
  }
}

}  // namespace tetraction
