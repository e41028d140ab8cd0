// The type face and the colours of panels, picture and charts.
#pragma once

#include <QColor>
#include <QFont>
#include <array>

class vtkTextProperty;

namespace tetraction::viewer {

/// The choice of the user.
enum class Theme { kAsDesktop, kLight, kDark };

/// Sizes of texts, pixels. Distances are multiples of kGrid.
enum class TextSize { kSmall = 11, kNormal = 13, kTitle = 16 };
inline constexpr int kGrid = 8;

/// A text and what it stands on.
struct ColorPair {
  QColor text, ground;
};

struct ThemeColors {
  ColorPair panel, field, button, accent, disabled;
  QColor border, grid;             ///< of frames, and of the lines of a chart
  std::array<ColorPair, 3> cards;  ///< of notes, warnings and errors
  QColor alert;                    ///< text on the ground of a panel
};

const ThemeColors& theme_colors(bool dark);
/// Whether the present theme is dark.
bool is_dark();
inline const ThemeColors& theme_colors() {
  return theme_colors(is_dark());
}
/// Sets the colours and the type face of the application. Widgets receive QEvent::PaletteChange.
void apply_theme(Theme theme);
/// The choice that is stored in the settings.
Theme stored_theme();

/// Text of VTK in the type face of the window.
void set_type_face(vtkTextProperty* text, TextSize size);

}  // namespace tetraction::viewer
