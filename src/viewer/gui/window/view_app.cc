#include "view_app.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QApplication>
#include <QSurfaceFormat>
#include <QTimer>
#include <chrono>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <future>
#include <utility>

#include "main_window.h"
#include "opened_file.h"
#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

constexpr int kWrongInput = 2;  // exit code, as documented
// Time for which the program waits for its file before it opens the window. Therefore no window opens
// for a broken file, and a small file is shown in the first picture.
constexpr std::chrono::milliseconds kWaitForFile(500);

// Ends the program with a message if Qt cannot open the display. Qt itself would abort the program.
void end_without_display(QtMsgType type, const QMessageLogContext&, const QString& message) {
  if (type != QtFatalMsg) return;
  std::fprintf(
      stderr,
      "tetraction: view: no window can be opened (%s). Check DISPLAY, or use tetraction run "
      "and look at frames.pvd in ParaView.\n",
      message.section(QLatin1Char('\n'), 0, 0).toLocal8Bit().constData());
  std::_Exit(kWrongInput);
}

// A message that says why no window can be opened and what to do. Empty if a window can be opened.
std::string display_problem() {
  // This check comes first, because Qt ends the program if there is no display.
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return {};
  }
  return "view: there is no display to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is "
         "set). Run it on a desktop or with ssh -X, or use tetraction run and look at frames.pvd "
         "in "
         "ParaView.";
}

// Throws InputError if the run of this file cannot be recorded in the folder.
void check_record(const std::string& path, const std::string& folder) {
  if (folder.empty()) return;
  if (!path.empty() && kind_of(path) == DocumentKind::kRun) {
    throw InputError("view: --record needs a scene or a mesh; " + path + " is a finished run.");
  }
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::path(folder) / "frames.pvd", error)) {
    throw InputError("view: --record: there is a run in " + folder +
                     " already, which would be lost. Give another folder.");
  }
}

}  // namespace

void set_up_application() {
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);       // a filter smooths the edges at low cost
  format.setSwapInterval(0);  // two views in one window must not wait for each other
  QSurfaceFormat::setDefaultFormat(format);
  // Only the widgets of class VtkWidget are native windows.
  QCoreApplication::setAttribute(Qt::AA_DontCreateNativeWidgetSiblings);
  QCoreApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QCoreApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
  QCoreApplication::setOrganizationName(QStringLiteral("tetraction"));
  QCoreApplication::setApplicationName(QStringLiteral("tetraction"));
}

int run_viewer(const std::string& path, std::optional<double> scale, const std::string& record,
               const std::function<bool()>& interrupted) {
  check_record(path, record);
  std::future<Opened> reading;
  if (!path.empty()) {
    reading = std::async(std::launch::async, open_file, path, scale);
    if (reading.wait_for(kWaitForFile) == std::future_status::ready) {
      std::promise<Opened> read;
      read.set_value(reading.get());  // throws if the file could not be read
      reading = read.get_future();
    }
  }
  if (const std::string problem = display_problem(); !problem.empty()) throw InputError(problem);
  set_up_application();
  int argc = 1;
  char name[] = "tetraction";
  char* argv[] = {name, nullptr};
  const QtMessageHandler usual = qInstallMessageHandler(end_without_display);
  QApplication app(argc, argv);
  std::setlocale(LC_NUMERIC, "C");  // files have a decimal point; Qt has taken the user's separator
  qInstallMessageHandler(usual);
  MainWindow window;
  window.record_from_start(QString::fromLocal8Bit(record.c_str()));
  window.show();
  QTimer signals_timer;
  QObject::connect(&signals_timer, &QTimer::timeout, &window, [&] {
    if (!interrupted()) return;
    // A dialog runs an event loop of its own, which must end first.
    if (QWidget* dialog = QApplication::activeModalWidget()) {
      dialog->close();
    } else {
      window.close_without_question();
      QApplication::quit();
    }
  });
  constexpr int kSignals_ms = 50;
  signals_timer.start(kSignals_ms);
  std::exception_ptr problem;
  QObject::connect(&window, &MainWindow::could_not_open, &app, [&](const std::exception_ptr& what) {
    problem = what;
    QApplication::quit();
  });
  // This is done after the first picture of the empty window, because reading a large mesh takes long.
  QTimer::singleShot(0, &window, [&] {
    if (path.empty()) {
      window.show_document(first_scene());
      window.simulation()->run();
      window.offer_unsaved_edits();
    } else {
      window.open_from_start(QString::fromLocal8Bit(path.c_str()), std::move(reading));
    }
  });
  const int exit_code = QApplication::exec();
  if (problem) std::rethrow_exception(problem);
  // All files are complete. The solver's thread cannot be ended otherwise.
  if (window.closed_within_step()) std::_Exit(exit_code);
  return exit_code;
}

}  // namespace tetraction::viewer
