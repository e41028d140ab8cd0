// How far the run goes from picture to picture, and how fast.
#include <QComboBox>
#include <QElapsedTimer>
#include <QSpinBox>
#include <set>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Speed : public WindowTest {
 protected:
  void choose_speed(double speed) {
    auto* choice = find<QComboBox>("speed");
    choice->setCurrentIndex(choice->findData(speed));
  }
  // The steps at which the window had something to draw, in a second of running.
  std::set<Index> drawn_steps() {
    std::set<Index> steps;
    press_key(Qt::Key_Space);
    EXPECT_TRUE(wait_for([&] { return state().running; }));
    QElapsedTimer time;
    time.start();
    while (time.elapsed() < 1000 || steps.size() < 4) {
      wait(2);
      if (state().running) steps.insert(state().step);
      if (time.elapsed() > 20000) break;
    }
    press_and_settle(Qt::Key_Space);
    return steps;
  }
};

TEST_F(Speed, StepsAPicture) {
  show(quiet_beam());
  choose_speed(0.5);
  auto* steps = find<QSpinBox>("steps_per_picture");
  steps->setFocus();
  steps->selectAll();
  QTest::keyClicks(steps, QStringLiteral("7"));
  QTest::keyClick(steps, Qt::Key_Return);
  std::set<Index> drawn = drawn_steps();
  ASSERT_GE(drawn.size(), 4U);
  // The first picture may still show the start of the run.
  const Index first = *drawn.rbegin() % 7;
  drawn.erase(drawn.begin());
  for (const Index step : drawn) EXPECT_EQ(step % 7, first) << step;

  steps->setFocus();
  QTest::keyClick(steps, Qt::Key_PageDown);  // ten less: 1
  EXPECT_EQ(steps->value(), 1);
  std::set<Index> remainders;
  for (const Index step : drawn_steps()) remainders.insert(step % 7);
  EXPECT_GT(remainders.size(), 3U);
}

TEST_F(Speed, LimitOfTheRealTimeFactor) {
  show(quiet_beam());
  // A slow machine reaches these limits, too.
  for (const double limit : {0.05, 0.1}) {
    choose_speed(limit);
    const double begin = state().time;
    QElapsedTimer time;
    time.start();
    press_key(Qt::Key_Space);
    wait(1500);
    const double simulated = state().time - begin;
    const double wall = 1e-3 * static_cast<double>(time.elapsed());
    EXPECT_GT(simulated, 0.5 * limit * wall);
    EXPECT_LT(simulated, 1.5 * limit * wall);
    press_and_settle(Qt::Key_Space);
  }
}

}  // namespace
}  // namespace tetraction::viewer
