// The bar below the picture, the slider over the time, and the charts above it.
#include <QAbstractButton>
#include <QCheckBox>
#include <QElapsedTimer>
#include <QFile>
#include <QProcess>
#include <QStandardPaths>
#include <QTemporaryDir>
#include <QToolTip>
#include <cmath>
#include <cstdio>

#include "pictures.h"
#include "viewer/gui/transport/transport_bar.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

// Another list of folders in which programs are found, while it lives.
class SearchPath {
 public:
  explicit SearchPath(const QByteArray& path) { qputenv("PATH", path); }
  ~SearchPath() { qputenv("PATH", before_); }
  SearchPath(const SearchPath&) = delete;
  SearchPath& operator=(const SearchPath&) = delete;

 private:
  const QByteArray before_ = qgetenv("PATH");
};

// Makes a shell script in the folder that is found as ffmpeg.
SearchPath stand_in_for_ffmpeg(const QTemporaryDir& folder, const char* script) {
  QFile program(folder.filePath(QStringLiteral("ffmpeg")));
  EXPECT_TRUE(program.open(QIODevice::WriteOnly));
  program.write("#!/bin/sh\n");
  program.write(script);
  program.setPermissions(QFile::ReadOwner | QFile::WriteOwner | QFile::ExeOwner);
  return SearchPath(folder.path().toLocal8Bit() + ":" + qgetenv("PATH"));
}

class Transport : public WindowTest {
 protected:
  Timeline* timeline() { return window_->transport()->timeline(); }
  const Snapshot& shown() { return *window_->body_view()->state(); }
  // A click on the slider.
  void click_at(double time) {
    QTest::mouseClick(timeline(), Qt::LeftButton, Qt::NoModifier,
                      QPoint(timeline()->place_of(time), timeline()->height() / 2));
    settle();
    wait(200);
  }
};

TEST_F(Transport, TheSliderGoesBackInALiveRunAndTheRunContinuesThere) {
  show(falling_beam());
  run_to(0.4);
  wait(200);
  const Index last = state().step;
  EXPECT_FALSE(find<QAbstractButton>("continue_here")->isVisible());
  click_at(0.2);
  EXPECT_TRUE(shown().earlier);
  EXPECT_NEAR(shown().time, 0.2, 0.02);
  EXPECT_NEAR(timeline()->time(), shown().time, 0.005);
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(last) + 1);
  keep_picture("transport_earlier");
  const Index step = shown().step;
  press_and_settle(Qt::Key_B);
  EXPECT_EQ(shown().step, step - 1);
  QTest::mouseClick(find<QAbstractButton>("continue_here"), Qt::LeftButton);
  settle();
  wait(200);
  EXPECT_FALSE(shown().earlier);
  EXPECT_EQ(state().step, step - 1);
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(step));
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(state().step, last);
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(last) + 1);
  // The right end is the present state.
  click_at(0.1);
  EXPECT_TRUE(shown().earlier);
  QTest::keyClick(timeline(), Qt::Key_End);
  settle();
  EXPECT_FALSE(shown().earlier);
  // Run goes on from what is shown.
  click_at(0.1);
  press_key(Qt::Key_Space);
  ASSERT_TRUE(wait_for([&] { return state().running && state().step < last; }));
  press_and_settle(Qt::Key_Space);
}

TEST_F(Transport, TheTimeIsShownWithItsUnit) {
  show(falling_beam());
  run_to(0.1);
  wait(200);
  const QString text = find<QLabel>("time")->text();
  EXPECT_TRUE(text.endsWith(QStringLiteral(" s"))) << text.toStdString();
  EXPECT_NEAR(text.section(QLatin1Char(' '), 0, 0).toDouble(), state().time, 1e-4);
  EXPECT_GT(find<QLabel>("time")->fontMetrics().height(), 1.3 * window_->fontMetrics().height());
}

TEST_F(Transport, AClickOnTheChartOfALiveRunGoesThere) {
  show(falling_beam());
  run_to(0.4);
  QWidget* chart = window_->chart()->canvas();
  const auto [left, right] = window_->chart()->axis_ends();
  QTest::mouseClick(chart, Qt::LeftButton, Qt::NoModifier,
                    QPoint((left + right) / 2, chart->height() / 2));
  settle();
  EXPECT_TRUE(shown().earlier);
  EXPECT_NEAR(shown().time, 0.5 * shown().newest, 0.02 * shown().newest + 0.005);
}

TEST_F(Transport, TheSliderIsAboveTheAxisOfTheChart) {
  show(falling_beam());
  run_to(0.3);
  wait(400);
  const auto [left, right] = window_->chart()->axis_ends();
  const auto at = [](const QWidget* widget, int x) {
    return widget->mapToGlobal(QPoint(x, 0)).x();
  };
  const auto ranges = window_->chart()->axis_ranges();
  EXPECT_NEAR(at(timeline(), timeline()->place_of(ranges[0])), at(window_->chart()->canvas(), left),
              2);
  EXPECT_NEAR(at(timeline(), timeline()->place_of(ranges[1])),
              at(window_->chart()->canvas(), right), 2);
}

TEST_F(Transport, TheEnergyErrorHasAChartWithALogarithmicScaleAndValuesUnderTheMouse) {
  show(falling_beam());
  run_to(0.4);
  window_->chart()->show_kind(2);
  wait(200);
  double largest = 0.0;
  for (const HistoryRow& row : window_->chart()->rows()) {
    largest = std::max(largest, std::abs(row.energy_error));
  }
  auto ranges = window_->chart()->axis_ranges();
  EXPECT_LT(ranges[3], 1.5 * largest + 1e-11) << "a scale of its own";
  click("logarithmic");
  wait(200);
  ranges = window_->chart()->axis_ranges();
  if (largest > 0.0) {
    EXPECT_NEAR(ranges[3], std::log10(largest), 1.5);
  }
  keep_picture("chart_logarithmic");
  QWidget* chart = window_->chart()->canvas();
  QTest::mouseMove(chart, QPoint(chart->width() / 2, chart->height() / 2));
  EXPECT_TRUE(
      wait_for([] { return QToolTip::text().contains(QStringLiteral("Energy error: ")); }, 3000));
}

// The window draws kept states of 20,000 tetrahedra one after another while the slider moves.
TEST_F(Transport, ScrubbingTwentyThousandTetrahedra) {
  Document document = quiet_beam();
  document.scene.mesh.generate =
      GeneratorSettings{GeneratorKind::kBox, {1.0, 1.0, 1.0}, {15, 15, 15}};
  document.scene.time.integrator = Integrator::kVerlet;
  document.scene.time.step = 1e-4;
  document.scene.environment.kind = EnvironmentKind::kGravity;
  document.mesh = mesh_of(document.scene);
  show(std::move(document));
  run_to(0.01);
  QElapsedTimer time;
  time.start();
  constexpr int kShown = 40;
  std::uint64_t last = shown().generation;
  for (int i = 0; i < kShown; ++i) {
    window_->transport()->go_to(1e-4 * ((37 * i) % 97));
    while (shown().generation == last && time.elapsed() < 60000) wait(1);
    last = shown().generation;
    ASSERT_TRUE(shown().earlier);
  }
  const double rate = 1000.0 * kShown / static_cast<double>(time.elapsed());
  RecordProperty("drawn_per_second", static_cast<int>(rate));
  std::printf("%.0f kept states drawn a second\n", rate);
  EXPECT_GT(rate, 5.0);
}

// A stand-in for ffmpeg that counts the bytes of the pictures.
TEST_F(Transport, AFilmGetsPicturesOfTheChosenSize) {
  QTemporaryDir folder;
  const SearchPath path = stand_in_for_ffmpeg(
      folder, "for film; do :; done\necho \"$@\" > \"$film\"\nwc -c >> \"$film\"\n");
  show(falling_beam());
  const QString film = folder.filePath(QStringLiteral("film.webm"));
  window_->record_pictures(film, QSize(1280, 720));
  EXPECT_TRUE(find<QLabel>("recording_sign")->text().contains(QStringLiteral("film")));
  window_->simulation()->run();
  // Who asks for the snapshot takes it from the window.
  ASSERT_TRUE(wait_for([&] { return shown().time > 0.3; }));
  window_->simulation()->pause();
  settle();
  window_->stop_recording();
  EXPECT_TRUE(message().isEmpty()) << message().toStdString();
  QFile made(film);
  ASSERT_TRUE(made.open(QIODevice::ReadOnly));
  const QList<QByteArray> lines = made.readAll().split('\n');
  EXPECT_TRUE(lines.front().contains("1280x720")) << lines.front().toStdString();
  EXPECT_TRUE(lines.front().contains("libvpx"));
  const long long pictures = lines[1].trimmed().toLongLong() / (3LL * 1280 * 720);
  EXPECT_EQ(lines[1].trimmed().toLongLong() % (3LL * 1280 * 720), 0);
  EXPECT_NEAR(static_cast<double>(pictures), std::floor(state().time / 0.04) + 1, 1);
  // A picture of a larger size is drawn in it, not only stretched.
  const QSize large(2 * window_->body_view()->canvas()->width(), 100);
  const QImage image = window_->body_view()->picture(large);
  EXPECT_GE(image.width(), large.width());
  QDir().mkpath(QStringLiteral(TETRACTION_SCREENSHOTS));
  image.save(QStringLiteral(TETRACTION_SCREENSHOTS "/film_picture.png"));
  window_->body_view()->picture().save(QStringLiteral(TETRACTION_SCREENSHOTS "/view_picture.png"));
}

// What the program itself makes, as ffprobe sees it.
TEST_F(Transport, FfmpegMakesFilmsOfTheSizeWithAllPictures) {
  if (QStandardPaths::findExecutable(QStringLiteral("ffprobe")).isEmpty()) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  QTemporaryDir folder;
  for (const char* name : {"film.webm", "film.mp4"}) {
    show(falling_beam());
    const QString film = folder.filePath(QLatin1String(name));
    window_->record_pictures(film, QSize(640, 360));
    window_->simulation()->run();
    ASSERT_TRUE(wait_for([&] { return shown().time > 0.3; }));
    window_->simulation()->pause();
    settle();
    window_->stop_recording();
    EXPECT_TRUE(message().isEmpty()) << message().toStdString();
    const QString told = window_->statusBar()->currentMessage();
    QProcess probe;
    probe.start(QStringLiteral("ffprobe"),
                {"-v", "error", "-count_frames", "-select_streams", "v", "-show_entries",
                 "stream=width,height,nb_read_frames,r_frame_rate", "-of", "csv=p=0", film});
    ASSERT_TRUE(probe.waitForFinished(60000));
    const QList<QByteArray> found = probe.readAllStandardOutput().trimmed().split(',');
    ASSERT_EQ(found.size(), 4) << name;
    EXPECT_EQ(found[0], "640");
    EXPECT_EQ(found[1], "360");
    EXPECT_EQ(found[2], "25/1");
    EXPECT_NEAR(found[3].toDouble(), std::floor(state().time / 0.04) + 1, 1);
    EXPECT_TRUE(told.startsWith(QString::fromLatin1(found[3]) + ' ')) << told.toStdString();
  }
}

// An ffmpeg that neither reads nor ends does not hold the window for long.
TEST_F(Transport, AnFfmpegThatHangsIsKilled) {
  QTemporaryDir folder;
  const SearchPath path = stand_in_for_ffmpeg(folder, "exec sleep 1000\n");
  show(quiet_beam());
  window_->record_pictures(folder.filePath(QStringLiteral("film.webm")));
  EXPECT_TRUE(find<QLabel>("recording_sign")->isVisible());
  QElapsedTimer time;
  time.start();
  window_->stop_recording();
  EXPECT_LT(time.elapsed(), 30'000);
  expect_told(QStringLiteral("ffmpeg could not make the film"));
  EXPECT_FALSE(find<QLabel>("recording_sign")->isVisible());
}

TEST_F(Transport, WithoutFfmpegAFilmIsRefused) {
  const SearchPath path("");
  show(quiet_beam());
  window_->record_pictures(QStringLiteral("/tmp/film.mp4"));
  expect_told(QStringLiteral("ffmpeg"));
  EXPECT_FALSE(find<QLabel>("recording_sign")->isVisible());
}

}  // namespace
}  // namespace tetraction::viewer
