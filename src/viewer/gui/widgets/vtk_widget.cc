#include "vtk_widget.h"

#include <QVTKOpenGLNativeWidget.h>
#include <vtkGenericOpenGLRenderWindow.h>

namespace tetraction::viewer {

QVTKOpenGLNativeWidget* make_vtk_widget(vtkGenericOpenGLRenderWindow* window, QWidget* parent) {
  auto* widget = new QVTKOpenGLNativeWidget(window, parent);
  widget->setAttribute(Qt::WA_DontCreateNativeAncestors);
  widget->setAttribute(Qt::WA_NativeWindow);
  return widget;
}

}  // namespace tetraction::viewer
