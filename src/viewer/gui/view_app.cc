#include "view_app.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QApplication>
#include <QSurfaceFormat>
#include <QTimer>
#include <cstdio>
#include <cstdlib>

#include "main_window.h"

namespace tetraction::viewer {
namespace {

constexpr int kWrongInput = 2;  // exit code, as documented

// A display that is named but cannot be opened ends the program inside of Qt, which would abort it.
void end_without_display(QtMsgType type, const QMessageLogContext&, const QString& message) {
  if (type != QtFatalMsg) return;
  std::fprintf(
      stderr,
      "tetraction: view: no window can be opened (%s). Check DISPLAY, or use tetraction run "
      "and look at frames.pvd in ParaView.\n",
      message.section(QLatin1Char('\n'), 0, 0).toLocal8Bit().constData());
  std::_Exit(kWrongInput);
}

}  // namespace

std::string display_problem() {
  // Without a display Qt ends the program; so look before it does.
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return {};
  }
  return "view: there is no display to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is "
         "set). Run it on a desktop or with ssh -X, or use tetraction run and look at frames.pvd "
         "in "
         "ParaView.";
}

void set_up_application() {
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);  // edges are smoothed by a filter, which is cheap without a graphics card
  format.setSwapInterval(0);  // two views in one window must not wait for each other
  QSurfaceFormat::setDefaultFormat(format);
  // Only the widgets that ask for it have a window of their own (make_vtk_widget).
  QCoreApplication::setAttribute(Qt::AA_DontCreateNativeWidgetSiblings);
  QCoreApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QCoreApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
  QCoreApplication::setOrganizationName(QStringLiteral("tetraction"));
  QCoreApplication::setApplicationName(QStringLiteral("tetraction"));
}

int run_viewer(const std::string& path) {
  set_up_application();
  int argc = 1;
  char name[] = "tetraction";
  char* argv[] = {name, nullptr};
  const QtMessageHandler usual = qInstallMessageHandler(end_without_display);
  QApplication app(argc, argv);
  qInstallMessageHandler(usual);
  MainWindow window;
  window.show();
  // Behind the first picture of the empty window: a large mesh takes its time to read.
  QTimer::singleShot(0, &window, [&] {
    if (path.empty()) {
      window.show_document(first_scene());
      window.simulation()->run();
    } else {
      window.open(QString::fromLocal8Bit(path.c_str()));
    }
  });
  return QApplication::exec();
}

}  // namespace tetraction::viewer
