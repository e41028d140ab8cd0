// The viewer's window under load: pictures a second, stalls, time to the first picture, and kept states that
// are drawn while the slider moves.
//
//     xvfb-run -s "-screen 0 1400x900x24" window --seconds 10 --cells 24,12,12
//     xvfb-run -s "-screen 0 1400x900x24" window --scene examples/scenes/serpentine_spring.toml
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <QApplication>
#include <QElapsedTimer>
#include <QSettings>
#include <QTimer>
#include <QtTest/QTest>
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "report.h"
#include "tetraction/core/parallel.h"
#include "tetraction/mesh/generate.h"
#include "timing.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/transport/transport_bar.h"
#include "viewer/gui/window/documents.h"
#include "viewer/gui/window/main_window.h"
#include "viewer/gui/window/view_app.h"

namespace {

using namespace tetraction;
using benchmarks::now;

/// Seconds that this thread had a processor.
double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

viewer::Document beam(const std::array<int, 3>& cells, Integrator integrator, double step) {
  viewer::Document document = viewer::first_scene();
  const Vector3 size(1.2, 0.3, 0.3);
  document.scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, size, cells};
  document.scene.time.integrator = integrator;
  document.scene.time.step = step;
  document.mesh = generate_box(size, cells);
  return document;
}

/// Runs for `seconds` and tells what the window did.
void measure(viewer::MainWindow& window, const std::string& name, double seconds,
             benchmarks::Report& report) {
  window.simulation()->run();
  QTest::qWait(1000);
  QTimer tick;
  QElapsedTimer since_tick;
  qint64 longest = 0;
  QObject::connect(&tick, &QTimer::timeout,
                   [&] { longest = std::max(longest, since_tick.restart()); });
  since_tick.start();
  tick.start(5);
  const auto pictures = window.body_view()->picture_count();
  const Index steps = window.simulation()->snapshot()->step;
  const double cpu = thread_seconds();
  const double start = now();
  QTest::qWait(static_cast<int>(1000 * seconds));
  const double passed = now() - start;
  const auto drawn = static_cast<double>(window.body_view()->picture_count() - pictures);
  const double made = static_cast<double>(window.simulation()->snapshot()->step - steps);
  report.row({name, window.simulation()->mesh().tetrahedron_count(), drawn / passed,
              1e3 * (thread_seconds() - cpu) / drawn, made / passed, static_cast<double>(longest)});
  window.simulation()->pause();
  window.simulation()->wait_until_idle(60.0);
}

/// The states that are drawn in a second while the slider moves to and fro over the run.
void measure_scrubbing(viewer::MainWindow& window, double seconds) {
  viewer::Simulation& simulation = *window.simulation();
  const std::vector<double> times = simulation.kept_times();
  const auto shown = [&] { return window.body_view()->state()->generation; };
  const double start = now();
  int drawn = 0;
  while (now() - start < seconds) {
    const std::uint64_t before = shown();
    window.transport()->go_to(times[(37 * static_cast<std::size_t>(drawn)) % times.size()]);
    while (shown() == before && now() - start < seconds) QTest::qWait(1);
    ++drawn;
  }
  fmt::print("Scrubbing {} kept states: {:.1f} drawn a second\n", times.size(),
             drawn / (now() - start));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The viewer's window under load");
  double seconds = 10.0;
  std::array<int, 3> cells{24, 12, 12};
  std::string scene;
  app.add_option("--seconds", seconds, "of each measurement");
  app.add_option("--cells", cells, "of the beam; six tetrahedra each")->delimiter(',');
  int threads = 0;
  app.add_option("--threads", threads, "of the solver; 0: all cores but one, as the program does");
  app.add_option("--scene", scene, "measured instead of the beam");
  CLI11_PARSE(app, argc, argv);

  set_thread_count(threads > 0 ? threads : std::max(1, thread_count() - 1));
  const double start = now();
  viewer::set_up_application();
  int qt_argc = 1;
  QApplication qt(qt_argc, argv);
  QCoreApplication::setApplicationName(QStringLiteral("tetraction-benchmark"));
  QSettings().clear();
  benchmarks::Report report;
  viewer::MainWindow window;
  window.resize(1400, 900);
  window.show();
  if (!scene.empty()) {
    window.open(QString::fromStdString(scene));
  } else {
    window.show_document(beam(cells, Integrator::kExplicit, 1e-5));
  }
  while (window.opening() && now() - start < 60.0) QTest::qWait(2);
  window.body_view()->render();
  QTest::qWait(1);  // composes it
  fmt::print("Start to first picture: {:.2f} s\n", now() - start);

  report.table("The window under load",
               {{"rule", 16},
                {"tetrahedra", 10},
                {"pictures/s", 10},
                {"CPU ms a picture", 16},
                {"steps/s", 8},
                {"longest stall ms", 16}},
               {"CPU: of the window's own thread; the solver has its own"});
  if (!scene.empty()) {
    measure(window, "of the scene", seconds, report);
    return 0;
  }
  measure(window, "explicit", seconds, report);
  measure_scrubbing(window, seconds);
  window.show_document(beam(cells, Integrator::kBackwardEuler, 5e-3));
  measure(window, "backward-euler", seconds, report);
  return 0;
}
