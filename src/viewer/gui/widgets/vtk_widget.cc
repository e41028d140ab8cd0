#include "vtk_widget.h"

#include <vtkGenericOpenGLRenderWindow.h>

namespace tetraction::viewer {

VtkWidget::VtkWidget(vtkGenericOpenGLRenderWindow* window, QWidget* parent)
    : QVTKOpenGLNativeWidget(window, parent) {
  setAttribute(Qt::WA_DontCreateNativeAncestors);
  setAttribute(Qt::WA_NativeWindow);
}

void VtkWidget::paintGL() {
  painting_ = true;
  QVTKOpenGLNativeWidget::paintGL();
  painting_ = false;
}

}  // namespace tetraction::viewer
