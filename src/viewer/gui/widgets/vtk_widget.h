// The widgets that VTK draws in.
#pragma once

class QVTKOpenGLNativeWidget;
class QWidget;
class vtkGenericOpenGLRenderWindow;

namespace tetraction::viewer {

/// A widget for `window`, with a window of the system's own: Qt then composes each new picture with
/// this widget alone rather than with the whole main window, which without a graphics card takes
/// longer than drawing the body.
QVTKOpenGLNativeWidget* make_vtk_widget(vtkGenericOpenGLRenderWindow* window, QWidget* parent);

}  // namespace tetraction::viewer
