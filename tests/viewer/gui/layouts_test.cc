// The places of the parts of the window against a stored file, layouts/rectangles.json, at three sizes of the window.
// With TETRACTION_STORE_PICTURES set the file is written anew. If TETRACTION_LAYOUT_PICTURES is the name of a folder,
// pictures of the whole window are compared with those in it, or written to it.
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>

#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <cmath>
#include <cstdlib>

#include "viewer/gui/transport/transport_bar.h"
#include "viewer/gui/widgets/theme.h"
#include "viewer/gui/widgets/vtk_widget.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

bool stores() {
  return std::getenv("TETRACTION_STORE_PICTURES") != nullptr;
}

class Layouts : public WindowTest {
 protected:
  void TearDown() override {
    window_.reset();
    apply_theme(Theme::kAsDesktop);
  }

  QRect place_in_window(const QWidget* widget) {
    return {widget->mapTo(window_.get(), QPoint()), widget->size()};
  }
  // The part of the picture that the colour bar has.
  QRect bar() {
    auto* canvas = static_cast<VtkWidget*>(window_->body_view()->canvas());
    auto* gutter =
        vtkRenderer::SafeDownCast(canvas->renderWindow()->GetRenderers()->GetItemAsObject(2));
    const double left = gutter->GetViewport()[0] * canvas->width();
    const QPoint corner =
        canvas->mapTo(window_.get(), QPoint(static_cast<int>(std::lround(left)), 0));
    return {corner, QSize(canvas->width() - static_cast<int>(std::lround(left)), canvas->height())};
  }
  QJsonObject rectangles() {
    const std::pair<const char*, QRect> parts[] = {
        {"tree", place_in_window(find<QDockWidget>("dock_scene"))},
        {"picture", place_in_window(window_->body_view()->canvas())},
        {"colour bar", bar()},
        {"inspector", place_in_window(find<QDockWidget>("dock_inspector"))},
        {"transport bar", place_in_window(window_->transport())},
        {"charts", place_in_window(find<QDockWidget>("dock_charts"))},
        {"messages", place_in_window(window_->messages())},
        {"status bar", place_in_window(window_->statusBar())},
    };
    QJsonObject all;
    for (const auto& [name, rect] : parts) {
      EXPECT_TRUE(window_->rect().contains(rect)) << name;
      all[QLatin1String(name)] = QJsonArray{rect.x(), rect.y(), rect.width(), rect.height()};
    }
    return all;
  }

  static QJsonObject stored() {
    QFile file(path());
    if (!file.open(QIODevice::ReadOnly)) return {};
    return QJsonDocument::fromJson(file.readAll()).object();
  }
  static QString path() { return QStringLiteral(TETRACTION_LAYOUTS "/rectangles.json"); }
  static void store(const QString& name, const QJsonObject& rectangles) {
    QJsonObject all = stored();
    all[name] = rectangles;
    QFile file(path());
    ASSERT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(QJsonDocument(all).toJson());
  }
  static void expect_same(const QJsonObject& now, const QJsonObject& before, const QString& name) {
    EXPECT_EQ(now.keys(), before.keys()) << name.toStdString();
    for (const QString& part : now.keys()) {
      const auto text = [&](const QJsonObject& all) {
        return QJsonDocument(all[part].toArray()).toJson(QJsonDocument::Compact).toStdString();
      };
      EXPECT_EQ(text(now), text(before)) << name.toStdString() << ", " << part.toStdString();
    }
  }
  void compare_picture(const QString& name) {
    picture_rate()->clear();
    const QImage now = window_->grab().toImage().convertToFormat(QImage::Format_RGB32);
    QDir().mkpath(QStringLiteral(TETRACTION_SCREENSHOTS));
    EXPECT_TRUE(now.save(QStringLiteral(TETRACTION_SCREENSHOTS "/layout_%1.png").arg(name)));
    const char* folder = std::getenv("TETRACTION_LAYOUT_PICTURES");
    if (folder == nullptr) return;
    const QString file = QDir(QString::fromLocal8Bit(folder)).filePath(name + ".png");
    if (stores()) {
      EXPECT_TRUE(now.save(file)) << file.toStdString();
    } else {
      const QImage before = QImage(file).convertToFormat(QImage::Format_RGB32);
      EXPECT_TRUE(now == before) << "compare layout_" << name.toStdString() << ".png with "
                                 << file.toStdString();
    }
  }
};

TEST_F(Layouts, AreAsStored) {
  if (!QFile::exists(QStringLiteral("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"))) {
    GTEST_SKIP() << "fonts-dejavu-core is not installed, and the sizes of texts depend on it";
  }
  const bool is_fine = window_->devicePixelRatioF() == 2.0;
  const std::vector<QSize> sizes =
      is_fine ? std::vector{QSize(2560, 1600)} : std::vector{QSize(1024, 700), QSize(1400, 900)};
  show(first_scene());
  for (int i = 0; i < 30; ++i) window_->simulation()->step();
  settle();
  window_->select({nearest({1.2, 0.3, 0.3})});
  window_->messages()->clear();  // of warnings that depend on the environment
  window_->messages()->show_message(
      MessageStrip::Kind::kWarning,
      QStringLiteral("A message of two lines has a place of its own over the picture, with a "
                     "button below it and one that closes it."),
      {}, {{QStringLiteral("Do something"), [] {}}});
  for (const QSize& size : sizes) {
    const QString name = QStringLiteral("%1x%2").arg(size.width()).arg(size.height());
    window_->resize(size / window_->devicePixelRatioF());
    settle();
    for (const char* theme : {"light", "dark"}) {
      trigger(std::string_view(theme) == "light" ? "theme_1" : "theme_2");
      wait(300);
      const QJsonObject now = rectangles();
      if (stores()) {
        store(name, now);
      } else {
        expect_same(now, stored()[name].toObject(), name);
      }
      compare_picture(name + '_' + theme);
    }
  }
}

}  // namespace
}  // namespace tetraction::viewer
