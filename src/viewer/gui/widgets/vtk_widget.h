// The widget in which VTK draws.
#pragma once

#include <QVTKOpenGLNativeWidget.h>

class vtkGenericOpenGLRenderWindow;

namespace tetraction::viewer {

/// Shows what VTK draws in a render window. It is a native window of its own, so that Qt composes each
/// new picture with this widget only. Composing the whole main window would take longer than drawing
/// the body if there is no graphics card.
class VtkWidget : public QVTKOpenGLNativeWidget {
 public:
  VtkWidget(vtkGenericOpenGLRenderWindow* window, QWidget* parent);

  /// Whether Qt is painting the widget. If VTK requests a picture meanwhile, the previous one has been
  /// lost, for instance because the size has changed.
  bool painting() const { return painting_; }

 protected:
  void paintGL() override;

 private:
  bool painting_ = false;
};

}  // namespace tetraction::viewer
