// Where the camera of the view looks, and the mark of a body that it does not see.
#include <vtkCamera.h>
#include <vtkRenderer.h>

#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <utility>

#include "body_view.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {

BodyView::Camera BodyView::camera() const {
  vtkCamera* camera = renderer_->GetActiveCamera();
  Camera values{};
  camera->GetPosition(values.data());
  camera->GetFocalPoint(values.data() + 3);
  camera->GetViewUp(values.data() + 6);
  values[9] = camera->GetParallelScale();
  values[10] = camera->GetParallelProjection();
  return values;
}

void BodyView::set_camera(const Camera& values) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  camera->SetPosition(values.data());
  camera->SetFocalPoint(values.data() + 3);
  camera->SetViewUp(values.data() + 6);
  camera->SetParallelScale(values[9]);
  camera->SetParallelProjection(values[10] != 0.0);
  drawn_camera_ = this->camera();  // the caller knows it
  render();
}

void BodyView::fit() {
  scene_->fit();
  render();
}

bool BodyView::is_outside() const {
  if (!drawn_) return false;
  const auto [low, high] = scene_->bounds();
  QRectF box;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3 x = low;
    for (int i = 0; i < 3; ++i) {
      if ((corner >> i & 1) != 0) x[i] = high[i];
    }
    const QPointF place = to_canvas(x);
    if (!std::isfinite(place.x()) || !std::isfinite(place.y())) return false;
    box |= QRectF(place - QPointF(1.0, 1.0), QSizeF(2.0, 2.0));
  }
  return !box.intersects(QRectF(widget_->rect()));
}

void BodyView::fit_if_outside() {
  if (is_outside()) fit();
}

void BodyView::set_follow(bool on) {
  follow_ = on;
}

void BodyView::show_element(const TetMesh& mesh, Index element) {
  if (!drawn_) return;
  std::vector<Index> vertices;
  for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(element)]) vertices.push_back(v);
  scene_->fit(vertices);
  emit band_selected(std::move(vertices), false);
}

// An arrow at the edge of the picture, if the body is outside it.
void BodyView::show_edge_mark() {
  const bool outside = is_outside();
  if (outside) {
    const QPointF middle(0.5 * widget_->width(), 0.5 * widget_->height());
    const QPointF way = scene_->direction_to_body();
    const double length = std::max(std::hypot(way.x(), way.y()), 1e-12);
    const QSize size = edge_mark_->sizeHint();
    const double x = middle.x() - 0.5 * size.width() - 8.0;
    const double y = middle.y() - 0.5 * size.height() - 8.0;
    const double reach = length / std::max(std::abs(way.x()) / x, std::abs(way.y()) / y);
    const QPointF place = middle + way * (reach / length);
    edge_mark_->move((place - QPointF(0.5 * size.width(), 0.5 * size.height())).toPoint());
    const bool sideways = std::abs(way.x()) > std::abs(way.y());
    edge_mark_->setArrowType(sideways ? (way.x() > 0.0 ? Qt::RightArrow : Qt::LeftArrow)
                                      : (way.y() > 0.0 ? Qt::DownArrow : Qt::UpArrow));
  }
  if (outside != edge_mark_->isVisible()) edge_mark_->setVisible(outside);
}

}  // namespace tetraction::viewer
