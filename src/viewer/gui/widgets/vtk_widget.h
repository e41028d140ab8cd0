// The widget in which VTK draws.
#pragma once

class QVTKOpenGLNativeWidget;
class QWidget;
class vtkGenericOpenGLRenderWindow;

namespace tetraction::viewer {

/// Makes a widget for `window`. It is a native window of its own, so that Qt composes each new picture
/// with this widget only. Composing the whole main window would take longer than drawing the body if
/// there is no graphics card.
QVTKOpenGLNativeWidget* make_vtk_widget(vtkGenericOpenGLRenderWindow* window, QWidget* parent);

}  // namespace tetraction::viewer
