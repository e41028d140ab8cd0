#include "theme.h"

#include <vtkTextProperty.h>

#include <QApplication>
#include <QFile>
#include <QFontDatabase>
#include <QPalette>
#include <QSettings>
#include <QStyleFactory>
#include <algorithm>

namespace tetraction::viewer {
namespace {

// Of Debian's package fonts-dejavu-core, which scripts/setup installs. Without it the fonts of Qt and VTK are used.
constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

// What the desktop's own palette is, before the program sets one.
bool desktop_is_dark() {
  static const bool dark = QApplication::palette().color(QPalette::Window).lightness() < 128;
  return dark;
}

bool& dark_now() {
  static bool dark = false;
  return dark;
}

QPalette palette_of(const ThemeColors& colors) {
  QPalette palette;
  const auto set = [&](QPalette::ColorRole role, const QColor& color) {
    palette.setColor(role, color);
  };
  set(QPalette::Window, colors.panel.ground);
  set(QPalette::WindowText, colors.panel.text);
  set(QPalette::Base, colors.field.ground);
  set(QPalette::AlternateBase, colors.panel.ground);
  set(QPalette::Text, colors.field.text);
  set(QPalette::PlaceholderText, colors.disabled.text);
  set(QPalette::Button, colors.button.ground);
  set(QPalette::ButtonText, colors.button.text);
  set(QPalette::BrightText, colors.alert);
  set(QPalette::ToolTipBase, colors.field.ground);
  set(QPalette::ToolTipText, colors.field.text);
  set(QPalette::Highlight, colors.accent.ground);
  set(QPalette::HighlightedText, colors.accent.text);
  set(QPalette::Link, colors.accent.ground);
  set(QPalette::LinkVisited, colors.accent.ground);
  set(QPalette::Light, colors.button.ground.lighter(110));
  set(QPalette::Midlight, colors.button.ground.lighter(104));
  set(QPalette::Mid, colors.border);
  set(QPalette::Dark, colors.border.darker(120));
  set(QPalette::Shadow, colors.border.darker(150));
  for (const QPalette::ColorRole role :
       {QPalette::WindowText, QPalette::Text, QPalette::ButtonText}) {
    palette.setColor(QPalette::Disabled, role, colors.disabled.text);
  }
  return palette;
}

}  // namespace

const ThemeColors& theme_colors(bool dark) {
  static const auto pair = [](QRgb text, QRgb ground) {
    return ColorPair{QColor(text), QColor(ground)};
  };
  static const ThemeColors light{
      pair(0x1d2329, 0xf3f5f7),
      pair(0x1d2329, 0xffffff),
      pair(0x1d2329, 0xe6eaee),
      pair(0xffffff, 0x1a6fb0),
      pair(0x626b74, 0xf3f5f7),
      QColor(0xb8c0c8),
      QColor(0xe1e4e8),
      {pair(0x10344f, 0xe3f0fb), pair(0x5c4300, 0xfff3cd), pair(0x6b0d0d, 0xfbdcdc)},
      QColor(0xb00000)};
  static const ThemeColors night{
      pair(0xe4e8ec, 0x23282e),
      pair(0xe4e8ec, 0x1a1e23),
      pair(0xe4e8ec, 0x343b43),
      pair(0x0b1620, 0x5fb0ec),
      pair(0x98a2ac, 0x23282e),
      QColor(0x4c555f),
      QColor(0x3a424b),
      {pair(0xcfe6fa, 0x17334a), pair(0xffe39a, 0x443508), pair(0xffcaca, 0x4d1a1a)},
      QColor(0xff8f8f)};
  return dark ? night : light;
}

bool is_dark() {
  return dark_now();
}

Theme stored_theme() {
  const int stored = QSettings().value(QStringLiteral("theme"), 0).toInt();
  return static_cast<Theme>(std::clamp(stored, 0, static_cast<int>(Theme::kDark)));
}

void apply_theme(Theme theme) {
  const bool desktop = desktop_is_dark();
  dark_now() = theme == Theme::kDark || (theme == Theme::kAsDesktop && desktop);
  QApplication::setStyle(QStyleFactory::create(QStringLiteral("Fusion")));
  QApplication::setPalette(palette_of(theme_colors()));
  QFont font = QApplication::font();
  static const int file = QFontDatabase::addApplicationFont(QLatin1String(kFontFile));
  if (file >= 0) font.setFamily(QFontDatabase::applicationFontFamilies(file).front());
  font.setPixelSize(static_cast<int>(TextSize::kNormal));
  QApplication::setFont(font);
}

void set_type_face(vtkTextProperty* text, TextSize size) {
  static const bool exists = QFile::exists(QLatin1String(kFontFile));
  if (exists) {
    text->SetFontFile(kFontFile);
    text->SetFontFamily(VTK_FONT_FILE);
  } else {
    text->SetFontFamilyToArial();
  }
  text->SetFontSize(static_cast<int>(size));
  text->SetBold(false);
  text->SetItalic(false);
  text->SetShadow(false);
}

}  // namespace tetraction::viewer
