// The icons of the window, in the colour of the texts.
#pragma once

#include <QIcon>

namespace tetraction::viewer {

enum class Icon {
  kRun,
  kPause,
  kStep,
  kRestart,
  kBack,
  kRecord,
  kNavigate,
  kSelect,
  kDrag,
  kForce,
  kMomentum,
  kClose,
  kWhole,
  kSave
};

/// Sharp at every size. It follows the theme.
QIcon icon(Icon which);

}  // namespace tetraction::viewer
