// A minute of a person who does anything: with a fixed seed, clicks, keys, sliders, numbers and the
// mouse in the view, while the body moves. Nothing may crash or leave a state that is no
// number; and what was done must replay to the same state.
#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <QAbstractSlider>
#include <QComboBox>
#include <QMouseEvent>
#include <QPushButton>
#include <QSpinBox>
#include <QTabBar>
#include <QTimer>
#include <QToolButton>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "tetraction/io/scene_writer.h"
#include "tetraction/simulation/session.h"
#include "viewer/history_log.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

// Watches the window's event loop from another thread. Since the last beat it adds up the processor time that the
// window's thread has used, and the short sleeps of its own in which that thread has waited for something to
// happen. The thread's time without a processor, which depends on what else the machine does, does not count.
class StallWatch {
 public:
  StallWatch() : state_file_(fmt::format("/proc/self/task/{}/stat", gettid())) {
    pthread_getcpuclockid(pthread_self(), &clock_);
    used_ = used_seconds();
    thread_ = std::thread([this] { watch(); });
    QObject::connect(&beat_, &QTimer::timeout, [this] { since_beat_us_ = 0; });
    beat_.start(1);
  }
  ~StallWatch() {
    stop_ = true;
    thread_.join();
  }
  int longest_ms() const { return longest_us_ / 1000; }

 private:
  static constexpr int kTick_ms = 5;
  void watch() {
    while (!stop_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kTick_ms));
      const double used = used_seconds();
      const double worked = 1e6 * (used - std::exchange(used_, used));
      const int counted = is_runnable() ? static_cast<int>(worked) : 1000 * kTick_ms;
      longest_us_ = std::max<int>(longest_us_, since_beat_us_ += counted);
    }
  }

  // Of processor time, by the window's thread.
  double used_seconds() const {
    timespec t{};
    clock_gettime(clock_, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  // Running or waiting for a processor, rather than for something that is to happen.
  bool is_runnable() const {
    std::string stat;
    std::getline(std::ifstream(state_file_), stat);
    const std::size_t name_end = stat.rfind(')');  // "4711 (name) R 1 …"
    return name_end != std::string::npos && stat.substr(name_end, 3) == ") R";
  }

  std::string state_file_;
  clockid_t clock_{};
  double used_ = 0.0;
  std::atomic<bool> stop_{false};
  std::atomic<int> since_beat_us_{0};
  std::atomic<int> longest_us_{0};
  QTimer beat_;
  std::thread thread_;
};

class RandomEdits : public WindowTest {
 protected:
  // The same numbers with every standard library.
  int random(int below) { return static_cast<int>(numbers_() % static_cast<unsigned>(below)); }
  double random_number() { return static_cast<double>(numbers_()) / 4294967295.0; }

  // Dialogs would wait for an answer; these and what ends the program or writes files are left out.
  static bool is_safe(const QString& text) {
    return !text.contains(QChar(0x2026)) && !text.contains(QStringLiteral("Quit")) &&
           !text.contains(QStringLiteral("Keys"));
  }

  template <class Widget>
  std::vector<Widget*> visible() {
    std::vector<Widget*> found;
    for (Widget* widget : window_->findChildren<Widget*>()) {
      if (widget->isVisible() && widget->isEnabled()) found.push_back(widget);
    }
    return found;
  }
  template <class Widget>
  Widget* any() {
    const std::vector<Widget*> all = visible<Widget>();
    return all.empty() ? nullptr
                       : all[static_cast<std::size_t>(random(static_cast<int>(all.size())))];
  }
  QPoint place_in(const QWidget* widget) {
    return {random(std::max(1, widget->width())), random(std::max(1, widget->height()))};
  }

  void use_the_mouse(QWidget* canvas) {
    constexpr Qt::MouseButton kButtons[] = {Qt::LeftButton, Qt::LeftButton, Qt::LeftButton,
                                            Qt::MiddleButton, Qt::RightButton};
    constexpr Qt::KeyboardModifiers kModifiers[] = {Qt::NoModifier, Qt::NoModifier,
                                                    Qt::ShiftModifier, Qt::ControlModifier};
    const Qt::MouseButton button = kButtons[random(5)];
    const Qt::KeyboardModifiers modifiers = kModifiers[random(4)];
    const QPoint from = place_in(canvas);
    QTest::mousePress(canvas, button, modifiers, from);
    for (int i = random(6); i > 0; --i) {
      move(canvas, button, modifiers, from + QPoint(random(80) - 40, random(80) - 40));
      QTest::qWait(random(20));
    }
    QTest::mouseRelease(canvas, button, modifiers, place_in(canvas));
  }
  // QTest::mouseMove() tells of no button.
  static void move(QWidget* canvas, Qt::MouseButton button, Qt::KeyboardModifiers modifiers,
                   const QPoint& to) {
    QMouseEvent event(QEvent::MouseMove, to, canvas->mapToGlobal(to), button, button, modifiers);
    QCoreApplication::sendEvent(canvas, &event);
  }
  void grab_a_vertex() {
    trigger(random(3) == 0 ? "tool_3" : (random(2) == 0 ? "tool_4" : "tool_5"));
    QWidget* canvas = window_->body_view()->canvas();
    const Index vertex = random(static_cast<int>(window_->simulation()->mesh().vertex_count()));
    const QPoint from = place_of(vertex);
    if (!canvas->rect().contains(from)) return;
    QTest::mousePress(canvas, Qt::LeftButton, Qt::NoModifier, from);
    const QPoint way(random(60) - 30, random(60) - 30);
    for (int i = 1; i <= 6; ++i) {
      move(canvas, Qt::LeftButton, Qt::NoModifier, from + way * i / 6);
      QTest::qWait(random(30));
    }
    QTest::mouseRelease(canvas, Qt::LeftButton, Qt::NoModifier, from + way);
  }

  void use_a_panel() {
    switch (random(6)) {
      case 0:
        if (auto* slider = any<QAbstractSlider>()) {
          slider->setValue(slider->minimum() + random(slider->maximum() - slider->minimum() + 1));
        }
        return;
      case 1:
        if (auto* field = any<NumberField>()) {
          field->setFocus();
          field->selectAll();
          const double value = (random_number() - 0.2) * std::pow(10.0, random(9) - 3);
          QTest::keyClicks(
              field, random(12) == 0 ? QStringLiteral("1e-x") : QString::number(value, 'g', 4));
          QTest::keyClick(field, random(4) == 0 ? Qt::Key_Escape : Qt::Key_Return);
        }
        return;
      case 2:
        if (auto* list = any<QComboBox>()) {
          list->setFocus();
          for (int i = random(3); i >= 0; --i) {
            QTest::keyClick(list, random(2) == 0 ? Qt::Key_Down : Qt::Key_Up);
          }
        }
        return;
      case 3:
        if (auto* box = any<QSpinBox>()) box->setValue(1 + random(20));
        return;
      case 4:
        if (random(2) == 0) {
          if (auto* tabs = any<QTabBar>()) tabs->setCurrentIndex(random(tabs->count()));
        } else {
          // Not the mesh, whose cells could become too many for the machine.
          constexpr const char* kSections[] = {"material",    "time",   "solver", "damping",
                                               "environment", "output", "initial"};
          window_->scene_panels()->choose({kSections[random(7)], 0});
        }
        return;
      default:
        if (auto* button = any<QAbstractButton>()) {
          const QString text = button->text();
          // Nameless buttons close and loosen the panels.
          if (!text.isEmpty() && is_safe(text)) button->click();
        }
        return;
    }
  }

  void press_a_key() {
    constexpr int kKeys[] = {Qt::Key_Space, Qt::Key_S, Qt::Key_F, Qt::Key_U,    Qt::Key_X,
                             Qt::Key_Y,     Qt::Key_Z, Qt::Key_1, Qt::Key_2,    Qt::Key_Home,
                             Qt::Key_3,     Qt::Key_4, Qt::Key_5, Qt::Key_Space};
    press_key(kKeys[random(14)]);
  }

  void do_anything() {
    switch (random(10)) {
      case 0:
      case 1:
      case 2:
      case 3:
        return use_a_panel();
      case 4:
        return press_a_key();
      case 5:
        return use_the_mouse(window_->body_view()->canvas());
      case 6:
        return grab_a_vertex();
      case 7:
        return use_the_mouse(window_->chart()->canvas());
      case 8:
        return window_->simulation()->undo();
      default:
        return random(2) == 0 ? window_->simulation()->redo() : window_->simulation()->run();
    }
  }

  // After a blow-up, as a person does: back to the last good state, with nothing that pulls, and when
  // that does not help, back to the start.
  void calm_down() {
    Simulation& simulation = *window_->simulation();
    if (actions_ - last_blow_up_ < 20) {
      simulation.reset();
    } else {
      simulation.go_back();
      simulation.edit(SetTime{{Integrator::kBackwardEuler, 5e-3, false, 1000.0}}, "calm: steps");
      simulation.edit(SetDamping{{0.0, 5.0, 50.0}}, "calm: damping");
      simulation.edit(SetEnvironment{}, "calm: no environment");
    }
    last_blow_up_ = actions_;
    simulation.run();
  }

  // The recording of all this is a scene that goes the same way, to the last bit.
  void expect_replay(const TetMesh& mesh, bool complete) {
    const Scene recorded = window_->simulation()->recorded_scene();
    const std::string path =
        QDir::temp().filePath(QStringLiteral("tetraction_random_edits.toml")).toStdString();
    write_scene(recorded, path);  // to look at, should it not
    const std::vector<HistoryRow> rows = window_->simulation()->history(0);
    Session session(recorded, mesh);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      do {  // a long history has not every step
        ASSERT_TRUE(session.step()) << session.message() << " See " << path;
      } while (session.state().step < rows[i].step);
      const HistoryRow row = history_row(session);
      ASSERT_TRUE(row.step == rows[i].step && row.time == rows[i].time &&
                  row.total == rows[i].total && row.linear_momentum == rows[i].linear_momentum)
          << "Another way from step " << row.step << ", " << row.time << " s on (total energy "
          << row.total << ", was " << rows[i].total << "): " << path << edits_around(row.time);
    }
    if (!complete) return;
    EXPECT_EQ(session.state().position, state().position);
    EXPECT_EQ(session.state().momentum, state().momentum);
  }
  std::string edits_around(double time) {
    std::string text;
    for (const EditMark& mark : window_->simulation()->marks()) {
      if (std::abs(mark.time - time) < 0.02) {
        text += "\n  " + std::to_string(mark.time) + " " + mark.what;
      }
    }
    return text;
  }

  int actions_ = 0;
  int last_blow_up_ = -1000;
  std::mt19937 numbers_{20061};
};

// TETRACTION_RANDOM_SECONDS and TETRACTION_RANDOM_SEED: for longer searches by hand.
TEST_F(RandomEdits, DoNotCrashAndReplay) {
  if (const char* seed = std::getenv("TETRACTION_RANDOM_SEED")) {
    numbers_.seed(static_cast<unsigned>(std::atoi(seed)));
  }
  const char* wanted = std::getenv("TETRACTION_RANDOM_SECONDS");
  const double seconds = wanted != nullptr ? std::atof(wanted) : 60.0;
  const Document document = quiet_beam();
  show(document);
  show_entry("material");
  window_->simulation()->set_speed_limit(1.0);
  window_->simulation()->run();
  int longest = 0;
  int blow_ups = 0;
  {
    const StallWatch watch;
    QElapsedTimer clock;
    clock.start();
    while (static_cast<double>(clock.elapsed()) < 1000.0 * seconds) {
      do_anything();
      ++actions_;
      QTest::qWait(random(30));
      ASSERT_TRUE(window_->isVisible());
      ASSERT_TRUE(state().position.allFinite() && state().momentum.allFinite());
      if (state().status != RunStatus::kRunning) {
        ++blow_ups;
        calm_down();
      }
    }
    longest = watch.longest_ms();
  }
  std::printf("%d actions, %d runs that failed, longest stall %d ms, time %g s\n", actions_,
              blow_ups, longest, state().time);
  // An edit is in force at the next step: so that the last ones count, one more, if it goes well.
  window_->simulation()->pause();
  window_->simulation()->step();
  // With the numbers that were typed, such as that of iterations, it may take longer than anybody waits.
  const bool is_made = window_->simulation()->wait_until_idle(20.0);
  if (is_made) settle();
  const bool complete = is_made && state().status == RunStatus::kRunning;
  if (is_made && !complete) {
    window_->simulation()->go_back();
    settle();
  }
  keep_picture("random_edits");
  expect_replay(window_->simulation()->mesh(), complete);
}

}  // namespace
}  // namespace tetraction::viewer
