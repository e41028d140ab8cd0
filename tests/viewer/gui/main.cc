// The tests of the window: one application for all of them, with settings of its own.
#include <gtest/gtest.h>

#include <QApplication>
#include <QDir>
#include <QSettings>
#include <QStandardPaths>
#include <algorithm>

#include "tetraction/core/parallel.h"
#include "viewer/gui/window/view_app.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  // gtest_discover_tests lists the cases while building, where no display is needed.
  if (testing::GTEST_FLAG(list_tests)) return RUN_ALL_TESTS();
  // As the program does: one core is the window's.
  tetraction::set_thread_count(std::max(1, tetraction::thread_count() - 1));
  tetraction::viewer::set_up_application();
  QSettings::setPath(
      QSettings::NativeFormat, QSettings::UserScope,
      qEnvironmentVariable(
          "TETRACTION_TEST_SETTINGS",  // of the test that has started this one
          QDir::temp().filePath(
              QStringLiteral("tetraction_gui_test_%1").arg(QCoreApplication::applicationPid()))));
  // Dialogs of the system, where there are any, cannot be found among the widgets.
  QCoreApplication::setAttribute(Qt::AA_DontUseNativeDialogs);
  QApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
