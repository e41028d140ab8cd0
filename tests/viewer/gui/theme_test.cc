// The colours, the type face and the icons of the window.
#include "viewer/gui/widgets/theme.h"

#include <vtkTextProperty.h>

#include <QFile>
#include <QMap>
#include <QMenu>
#include <QMessageBox>
#include <QToolBar>
#include <QToolButton>
#include <QUrl>
#include <algorithm>
#include <cmath>

#include "dialogs.h"
#include "pictures.h"
#include "tetraction/core/version.h"
#include "viewer/gui/widgets/icons.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

double luminance(const QColor& color) {
  const auto linear = [](double c) {
    return c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.redF()) + 0.7152 * linear(color.greenF()) +
         0.0722 * linear(color.blueF());
}

// The contrast of two opaque colours, 1 … 21, as WCAG 2.1 defines it.
double contrast(const QColor& a, const QColor& b) {
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return (high + 0.05) / (low + 0.05);
}

class Themes : public WindowTest {
 protected:
  void TearDown() override {
    window_.reset();
    apply_theme(Theme::kAsDesktop);
  }
  double view_ground() {
    wait(50);
    return brightness(window_->body_view()->picture(), QPoint(20, 20));
  }
  double chart_ground() {
    wait(50);
    const QImage chart = window_->chart()->canvas()->grab().toImage();
    return brightness(chart, QPoint(chart.width() / 2, 3));
  }
};

// WCAG 2.1, 1.4.3: 4.5 for texts, 1.4.11: 3 for what marks a state. Disabled texts need not be legible.
TEST_F(Themes, ContrastIsThatOfLevelAA) {
  EXPECT_NEAR(contrast(Qt::black, Qt::white), 21.0, 1e-9);
  EXPECT_NEAR(contrast(QColor(0x777777), Qt::white), 4.48, 0.01);  // a known value
  for (const bool dark : {false, true}) {
    const ThemeColors& colors = theme_colors(dark);
    for (const ColorPair& pair : {colors.panel, colors.field, colors.button, colors.accent,
                                  colors.cards[0], colors.cards[1], colors.cards[2]}) {
      EXPECT_GE(contrast(pair.text, pair.ground), 4.5) << dark << pair.text.name().toStdString();
    }
    EXPECT_GE(contrast(colors.alert, colors.panel.ground), 4.5);
    EXPECT_GE(contrast(colors.accent.ground, colors.panel.ground), 3.0);
    EXPECT_GE(contrast(colors.disabled.text, colors.panel.ground), 3.0);
  }
}

TEST_F(Themes, PanelsPictureChartsAndMessagesBecomeDark) {
  show(quiet_beam());
  window_->messages()->show_message(MessageStrip::Kind::kWarning, QStringLiteral("A text."));
  trigger("theme_1");
  EXPECT_GT(view_ground(), 180.0);
  EXPECT_GT(chart_ground(), 240.0);
  keep_picture("theme_light");
  trigger("theme_2");
  EXPECT_TRUE(is_dark());
  EXPECT_LT(view_ground(), 90.0);
  EXPECT_LT(chart_ground(), 60.0);
  EXPECT_LT(window_->palette().color(QPalette::Window).lightness(), 60);
  const auto* card = window_->messages()->findChild<QWidget*>(QStringLiteral("message_card"));
  ASSERT_NE(card, nullptr);
  EXPECT_TRUE(card->styleSheet().contains(theme_colors(true).cards[1].ground.name()));
  keep_picture("theme_dark");
  // The next window has it, too.
  window_->close();
  open_window();
  EXPECT_TRUE(is_dark());
  EXPECT_LT(view_ground(), 90.0);
}

TEST_F(Themes, QtAndVtkUseOneTypeFace) {
  vtkNew<vtkTextProperty> text;
  set_type_face(text, TextSize::kTitle);
  EXPECT_EQ(text->GetFontSize(), 16);
  if (!QFile::exists(QStringLiteral("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"))) {
    GTEST_SKIP() << "fonts-dejavu-core is not installed";
  }
  EXPECT_EQ(text->GetFontFamily(), VTK_FONT_FILE);
  EXPECT_STREQ(text->GetFontFile(), "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf");
  EXPECT_EQ(QApplication::font().family(), QStringLiteral("DejaVu Sans"));
}

TEST_F(Themes, EveryIconIsDrawn) {
  std::vector<QImage> images;
  for (int i = 0; i <= static_cast<int>(Icon::kClose); ++i) {
    images.push_back(icon(static_cast<Icon>(i)).pixmap(32, 32).toImage());
    EXPECT_FALSE(pixels(images.back(), [](QRgb c) { return qAlpha(c) > 200; }).empty()) << i;
    for (int j = 0; j < i; ++j) EXPECT_NE(images[static_cast<std::size_t>(j)], images.back());
  }
}

TEST_F(Themes, ToolTipsNameTheShortcuts) {
  show(quiet_beam());
  int buttons = 0;
  for (QToolButton* button : window_->findChildren<QToolButton*>()) {
    const QAction* action = button->defaultAction();
    if (action == nullptr || action->shortcut().isEmpty()) continue;
    ++buttons;
    EXPECT_TRUE(button->toolTip().contains(action->shortcut().toString(QKeySequence::NativeText)))
        << button->toolTip().toStdString();
  }
  EXPECT_GE(buttons, 8);
}

TEST_F(Themes, EachActionHasAShortcutThatItsToolTipNames) {
  show(quiet_beam());
  QMap<QString, QString> taken;
  for (const QAction* action : window_->findChildren<QAction*>()) {
    const QString text = action->text();
    if (action->menu() != nullptr || action->isSeparator() || text.isEmpty()) continue;
    const QObject* parent = action->parent();
    if (!action->isVisible() || parent == find<QMenu>("groups")) continue;
    if (qobject_cast<const QToolBar*>(parent) != nullptr) continue;  // Qt's own, in no menu
    const QString key = action->shortcut().toString(QKeySequence::NativeText);
    EXPECT_FALSE(key.isEmpty()) << text.toStdString();
    EXPECT_TRUE(action->toolTip().contains(key)) << action->toolTip().toStdString();
    // One of the two actions that go back is enabled.
    if (key != QStringLiteral("B")) {
      EXPECT_FALSE(taken.contains(key)) << text.toStdString() << ", " << taken[key].toStdString();
    }
    taken[key] = text;
  }
  EXPECT_GE(taken.size(), 50);
}

TEST_F(Themes, TheHelpMenuLeadsToTheDocumentsAndTellsTheVersion) {
  for (const char* file : {"viewer.md", "scene.md", "outputs.md", "faq.md"}) {
    const auto actions = window_->findChildren<QAction*>();
    const auto leads_there = [&](const QAction* action) {
      return action->data().toUrl().fileName() == QLatin1String(file);
    };
    const auto found = std::ranges::find_if(actions, leads_there);
    ASSERT_NE(found, actions.end()) << file;
    EXPECT_TRUE(QFile::exists((*found)->data().toUrl().toLocalFile()));
  }
  QString text;
  const DialogAnswer answer([&](QDialog& dialog) {
    if (const auto* box = qobject_cast<QMessageBox*>(&dialog)) text = box->text();
    dialog.reject();
  });
  menu_action(QStringLiteral("&About"))->trigger();
  EXPECT_TRUE(answer.given());
  EXPECT_TRUE(text.contains(QString::fromStdString(version()))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("Apache License 2.0")));
}

TEST_F(Themes, TheLayoutIsReset) {
  show(quiet_beam());
  auto* charts = find<QDockWidget>("dock_charts");
  const QSize before = window_->size();
  charts->hide();
  window_->resize(900, 700);
  wait();
  press_key(Qt::Key_Home, Qt::ControlModifier);
  wait();
  EXPECT_TRUE(charts->isVisible());
  EXPECT_EQ(window_->size(), before);
}

}  // namespace
}  // namespace tetraction::viewer
