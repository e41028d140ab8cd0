#include "body_scene.h"

#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkAxesActor.h>
#include <vtkCamera.h>
#include <vtkCaptionActor2D.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCutter.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkLight.h>
#include <vtkLineSource.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSphereSource.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTubeFilter.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "viewer/gui/widgets/theme.h"

namespace tetraction::viewer {
namespace {

constexpr double kForceColor[3] = {0.80, 0.15, 0.15};
constexpr double kMomentumColor[3] = {0.10, 0.45, 0.85};
constexpr double kReactionColor[3] = {0.15, 0.55, 0.25};
constexpr double kContactColor[3] = {0.85, 0.55, 0.05};
constexpr double kBodyColor[3] = {0.62, 0.70, 0.78};
constexpr double kGhostColor[3] = {0.80, 0.47, 0.65};
constexpr double kSelectedColor[3] = {1.0, 0.45, 0.0};

void draw_as_points(vtkPolyDataMapper* mapper, vtkPolyData* data, vtkActor* actor,
                    const double* color) {
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  mapper->SetRelativeCoincidentTopologyPointOffsetParameter(-8.0);
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(color[0], color[1], color[2]);
  actor->GetProperty()->LightingOff();
}

}  // namespace

BodyScene::BodyScene(vtkRenderer* renderer, vtkRenderer* gutter)
    : renderer_(renderer),
      gutter_(gutter),
      forces_(renderer, "External force", "N", kForceColor),
      momenta_(renderer, "Momentum", "kg m/s", kMomentumColor),
      reactions_(renderer, "Reaction", "N", kReactionColor),
      contacts_(renderer, "Contact", "N", kContactColor),
      obstacles_(renderer),
      color_bar_(gutter) {
  vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();
  for (vtkFloatArray* array : {point_values_.Get(), triangle_values_.Get(), cell_values_.Get()}) {
    array->SetName("color");
  }
  points_->SetDataTypeToFloat();
  for (vtkPolyData* data :
       {surface_.Get(), edges_.Get(), cloud_.Get(), fixed_.Get(), selected_.Get(), area_.Get()}) {
    data->SetPoints(points_);
  }
  normals_->SetNumberOfComponents(3);
  grid_->SetPoints(points_);

  surface_mapper_->SetInputData(surface_);
  surface_mapper_->SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 6.0);
  surface_actor_->SetMapper(surface_mapper_);
  section_->SetInputData(grid_);
  section_->SetCutFunction(clip_plane_);
  section_->GenerateCutScalarsOff();
  section_mapper_->SetInputConnection(section_->GetOutputPort());
  section_actor_->SetMapper(section_mapper_);
  for (vtkActor* actor : {surface_actor_.Get(), section_actor_.Get()}) {
    actor->GetProperty()->SetColor(kBodyColor[0], kBodyColor[1], kBodyColor[2]);
  }
  for (vtkPolyDataMapper* mapper :
       {surface_mapper_.Get(), section_mapper_.Get(), cloud_mapper_.Get()}) {
    mapper->SetLookupTable(color_bar_.table());
    mapper->UseLookupTableScalarRangeOn();
  }
  edge_mapper_->SetInputData(edges_);
  edge_mapper_->ScalarVisibilityOff();
  edge_mapper_->SetRelativeCoincidentTopologyLineOffsetParameters(-1.0, -4.0);
  edge_actor_->SetMapper(edge_mapper_);
  edge_actor_->GetProperty()->LightingOff();
  draw_as_points(cloud_mapper_, cloud_, cloud_actor_, kBodyColor);
  draw_as_points(fixed_mapper_, fixed_, fixed_actor_, kBodyColor);
  draw_as_points(selected_mapper_, selected_, selected_actor_, kSelectedColor);
  draw_as_points(area_mapper_, area_, area_actor_, kSelectedColor);
  selected_actor_->GetProperty()->RenderPointsAsSpheresOn();
  const auto draw_wires = [](vtkPolyData* data, vtkActor* actor) {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    actor->GetProperty()->LightingOff();
  };
  draw_wires(rest_, rest_actor_);
  draw_wires(ghost_, ghost_actor_);

  center_->SetThetaResolution(16);
  center_->SetPhiResolution(12);
  vtkNew<vtkPolyDataMapper> center_mapper;
  center_mapper->SetInputConnection(center_->GetOutputPort());
  center_actor_->SetMapper(center_mapper);
  center_actor_->GetProperty()->SetColor(0.55, 0.15, 0.65);

  vtkNew<vtkPolyDataMapper> pulled_mapper;
  vtkNew<vtkArrowSource> pulled;
  pulled->SetTipResolution(16);
  pulled->SetShaftResolution(12);
  pulled_mapper->SetInputConnection(pulled->GetOutputPort());
  pulled_actor_->SetMapper(pulled_mapper);
  pulled_actor_->GetProperty()->SetColor(kSelectedColor[0], kSelectedColor[1], kSelectedColor[2]);
  pulled_actor_->GetProperty()->LightingOff();
  pulled_actor_->VisibilityOff();

  vtkNew<vtkPolyDataMapper> drag_mapper;
  drag_mapper->SetInputConnection(drag_line_->GetOutputPort());
  drag_actor_->SetMapper(drag_mapper);
  drag_actor_->GetProperty()->SetColor(kSelectedColor[0], kSelectedColor[1], kSelectedColor[2]);
  drag_actor_->GetProperty()->LightingOff();
  drag_actor_->VisibilityOff();

  for (vtkActor* actor :
       {surface_actor_.Get(), section_actor_.Get(), edge_actor_.Get(), cloud_actor_.Get(),
        fixed_actor_.Get(), selected_actor_.Get(), area_actor_.Get(), drag_actor_.Get(),
        rest_actor_.Get(), ghost_actor_.Get(), center_actor_.Get(), pulled_actor_.Get()}) {
    renderer->AddActor(actor);
  }
  renderer->AddActor(axes_);

  arrow_legend_->SetPosition(12, 10);
  set_type_face(arrow_legend_->GetTextProperty(), TextSize::kNormal);
  renderer->AddActor2D(arrow_legend_);
  for (auto& mark : extremes_) {
    set_type_face(mark->GetTextProperty(), TextSize::kNormal);
    mark->GetTextProperty()->SetVerticalJustificationToCentered();
    mark->GetTextProperty()->SetBackgroundOpacity(0.7);
    mark->GetPositionCoordinate()->SetCoordinateSystemToWorld();
    mark->VisibilityOff();
    renderer->AddActor2D(mark);
  }
  renderer->SetMaximumNumberOfPeels(4);
  renderer->SetOcclusionRatio(0.05);

  renderer->AutomaticLightCreationOff();
  light_->SetLightTypeToCameraLight();
  renderer->AddLight(light_);
  vtkNew<vtkLight> fill;  // a second light, so that no side is black
  fill->SetLightTypeToHeadlight();
  fill->SetIntensity(0.375);  // both lights together give no more than the colour itself
  renderer->AddLight(fill);
  set_pixel_ratio(1.0);
  set_drawing(drawing_);
}

BodyScene::~BodyScene() = default;

void BodyScene::set_body(std::shared_ptr<const BodyShape> shape) {
  shape_ = std::move(shape);
  points_->DeepCopy(shape_->rest);
  grid_->SetCells(shape_->cell_type, shape_->tetrahedra);
  surface_->SetPolys(shape_->faces);
  edges_->SetLines(shape_->edges);
  cloud_->SetVerts(shape_->points);
  rest_->SetPoints(shape_->rest);
  rest_->SetLines(shape_->edges);
  ghost_->SetPoints(shape_->rest);
  ghost_->SetLines(shape_->edges);
  selection_.clear();
  selected_->SetVerts(point_cells({}));
  fixed_->SetVerts(point_cells({}));
  area_->SetVerts(point_cells({}));

  const double diagonal = size();
  axes_->SetTotalLength(0.25 * diagonal, 0.25 * diagonal, 0.25 * diagonal);
  center_->SetRadius(0.015 * diagonal);
  obstacles_.set(nullptr);
  last_.reset();
  color_bar_.forget_range();
  update_clip();
  reset_camera(kOblique);
}

void BodyScene::set_state(std::shared_ptr<const Snapshot> next) {
  const Snapshot& snapshot = *next;
  const Index n = snapshot.position.size() / 3;
  if (n != points_->GetNumberOfPoints()) return;
  auto* xyz = static_cast<float*>(points_->GetVoidPointer(0));
  for (Index i = 0; i < 3 * n; ++i) xyz[i] = static_cast<float>(snapshot.position[i]);
  points_->Modified();
  constexpr std::chrono::milliseconds kTextPause(250);
  const auto now = std::chrono::steady_clock::now();
  texts_due_ = !snapshot.running || now - texts_changed_ >= kTextPause;
  if (texts_due_) texts_changed_ = now;
  color(snapshot);

  std::vector<Index> fixed;
  for (std::size_t v = 0; v < snapshot.fixed.size(); ++v) {
    if (snapshot.fixed[v] != 0) fixed.push_back(static_cast<Index>(v));
  }
  if (!last_ || last_->fixed != snapshot.fixed) fixed_->SetVerts(point_cells(fixed));
  if (!last_ || last_->pulled != snapshot.pulled) area_->SetVerts(point_cells(snapshot.pulled));
  for (vtkPolyData* data :
       {surface_.Get(), edges_.Get(), cloud_.Get(), fixed_.Get(), selected_.Get(), area_.Get()}) {
    data->Modified();
  }
  grid_->Modified();
  obstacles_.set(snapshot.obstacles);
  last_ = std::move(next);
  update_arrows();
}

void BodyScene::set_drawing(const DrawingSettings& drawing) {
  drawing_ = drawing;
  struct Shades {
    double top[3], bottom[3], text, edge, rest;
  };
  static constexpr Shades kLight{{0.80, 0.86, 0.92}, {0.97, 0.98, 0.99}, 0.12, 0.25, 0.62};
  static constexpr Shades kWhite{{1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, 0.10, 0.25, 0.7};
  static constexpr Shades kDark{{0.10, 0.12, 0.16}, {0.25, 0.28, 0.33}, 0.92, 0.12, 0.5};
  const bool as_window = drawing.background == Background::kAsWindow;
  const bool dark = as_window ? viewer::is_dark() : drawing.background == Background::kDark;
  const Shades& shades = dark ? kDark : drawing.background == Background::kWhite ? kWhite : kLight;
  double middle[3];
  for (int i = 0; i < 3; ++i) middle[i] = 0.5 * (shades.top[i] + shades.bottom[i]);
  for (vtkRenderer* each : {renderer_, gutter_}) {
    each->SetGradientBackground(gradient_);
    each->SetBackground(gradient_ ? shades.bottom : middle);
    each->SetBackground2(shades.top);
  }
  const double edge = drawing.surface ? shades.edge : (shades.text < 0.5 ? 0.25 : 0.8);
  edge_gray_ = edge;
  edge_actor_->GetProperty()->SetColor(edge, edge, edge);
  const double fixed = dark ? 0.95 : 0.15;
  fixed_actor_->GetProperty()->SetColor(fixed, fixed, fixed);
  rest_actor_->GetProperty()->SetColor(shades.rest, shades.rest, shades.rest);
  ghost_actor_->GetProperty()->SetColor(kGhostColor[0], kGhostColor[1], kGhostColor[2]);
  arrow_legend_->GetTextProperty()->SetColor(shades.text, shades.text, shades.text);
  for (auto& mark : extremes_) {
    mark->GetTextProperty()->SetColor(shades.text, shades.text, shades.text);
    mark->GetTextProperty()->SetBackgroundColor(middle);
  }
  for (vtkCaptionActor2D* caption :
       {axes_->GetXAxisCaptionActor2D(), axes_->GetYAxisCaptionActor2D(),
        axes_->GetZAxisCaptionActor2D()}) {
    caption->GetTextActor()->SetTextScaleModeToNone();
    set_type_face(caption->GetCaptionTextProperty(), TextSize::kNormal);
    caption->GetCaptionTextProperty()->SetColor(shades.text, shades.text, shades.text);
  }

  surface_actor_->SetVisibility(drawing.surface);
  renderer_->SetUseFXAA(drawing.antialiasing == Antialiasing::kOn ||
                        (drawing.antialiasing == Antialiasing::kWithGraphicsCard && gradient_));
  // Objects are opaque as far as possible. Without a graphics card a translucent object takes longer to draw
  // than the whole body.
  renderer_->SetUseDepthPeeling(drawing.opacity < 1.0);
  for (vtkActor* actor : {surface_actor_.Get(), section_actor_.Get()}) {
    actor->GetProperty()->SetOpacity(drawing.opacity);
    // Flat shading shows the faces of the linear tetrahedra.
    actor->GetProperty()->SetInterpolation(drawing.smooth ? VTK_GOURAUD : VTK_FLAT);
  }
  // The edges are drawn as part of the surface. Separate lines would be half hidden by it.
  surface_actor_->GetProperty()->SetEdgeVisibility(drawing.edges);
  surface_actor_->GetProperty()->SetEdgeColor(edge, edge, edge);
  section_actor_->GetProperty()->SetEdgeVisibility(drawing.edges);
  section_actor_->GetProperty()->SetEdgeColor(edge, edge, edge);
  edge_actor_->SetVisibility(drawing.edges && !drawing.surface);
  cloud_actor_->SetVisibility(drawing.points);
  fixed_actor_->SetVisibility(drawing.fixed);
  rest_actor_->SetVisibility(drawing.rest);
  ghost_actor_->SetVisibility(drawing.ghost);
  axes_->SetVisibility(drawing.axes);
  center_actor_->SetVisibility(attraction_ && drawing.center);
  forces_.set_visible(drawing.forces);
  momenta_.set_visible(drawing.momenta);
  reactions_.set_visible(drawing.reactions);
  contacts_.set_visible(drawing.contacts);
  obstacles_.set_visible(drawing.obstacles);
  obstacles_.set_dark(dark);

  constexpr double kRadian = std::numbers::pi / 180.0;
  const double azimuth = drawing.light_azimuth * kRadian;
  const double elevation = drawing.light_elevation * kRadian;
  light_->SetPosition(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                      std::cos(elevation) * std::cos(azimuth));
  light_->SetFocalPoint(0.0, 0.0, 0.0);
  light_->SetIntensity(0.625);

  text_gray_ = shades.text;
  color_bar_.set(drawing, regions_, text_gray_);
  update_clip();
  if (last_) {
    texts_due_ = true;
    color(*last_);
    update_arrows();
  }
}

void BodyScene::set_pixel_ratio(double ratio) {
  if (ratio == std::exchange(pixel_ratio_, ratio)) return;
  const auto size = static_cast<float>(ratio);
  cloud_actor_->GetProperty()->SetPointSize(4.0F * size);
  fixed_actor_->GetProperty()->SetPointSize(6.0F * size);
  selected_actor_->GetProperty()->SetPointSize(9.0F * size);
  area_actor_->GetProperty()->SetPointSize(5.0F * size);
  drag_actor_->GetProperty()->SetLineWidth(2.0F * size);
  obstacles_.set_pixel_ratio(ratio);
  for (vtkActor* actor : {surface_actor_.Get(), section_actor_.Get(), edge_actor_.Get(),
                          rest_actor_.Get(), ghost_actor_.Get()}) {
    actor->GetProperty()->SetLineWidth(size);
  }
}

void BodyScene::set_graphics_card(bool present) {
  gradient_ = present;
  set_drawing(drawing_);
}

void BodyScene::set_selection(const std::vector<Index>& vertices) {
  selection_ = vertices;
  selected_->SetVerts(point_cells(vertices));
  selected_->Modified();
}

void BodyScene::set_pulled_arrow(const Vector3& from, const Vector3& to) {
  const Vector3 arrow = to - from;
  const double length = arrow.norm();
  pulled_actor_->SetVisibility(length > 0.0);
  if (!(length > 0.0)) return;
  // VTK's arrow points along x. Its orientation is given by rotations about z and y, in degrees.
  constexpr double kDegree = 180.0 / std::numbers::pi;
  pulled_actor_->SetPosition(from.x(), from.y(), from.z());
  pulled_actor_->SetScale(length);
  pulled_actor_->SetOrientation(0.0, 0.0, 0.0);
  pulled_actor_->RotateZ(std::atan2(arrow.y(), arrow.x()) * kDegree);
  pulled_actor_->RotateY(-std::asin(std::clamp(arrow.z() / length, -1.0, 1.0)) * kDegree);
}

void BodyScene::set_drag_line(const Vector3& from, const Vector3& to) {
  drag_actor_->SetVisibility(from != to);
  drag_line_->SetPoint1(from.x(), from.y(), from.z());
  drag_line_->SetPoint2(to.x(), to.y(), to.z());
}

void BodyScene::set_attraction(bool present) {
  attraction_ = present;
  center_actor_->SetVisibility(present && drawing_.center);
}

bool BodyScene::is_drawn(const Vector3& point) const {
  if (!drawing_.clip) return true;
  Vector3 x = point;
  // The tolerance makes sure that points in the plane are drawn in spite of round-off.
  return clip_plane_->EvaluateFunction(x.data()) >= -1e-9 * size();
}

void BodyScene::update_clip() {
  Vector3 normal = Vector3::Unit(drawing_.clip_axis) * (drawing_.clip_flipped ? 1.0 : -1.0);
  Vector3 origin = shape_->low + drawing_.clip_at * (shape_->high - shape_->low);
  clip_plane_->SetNormal(normal.data());
  clip_plane_->SetOrigin(origin.data());
  section_actor_->SetVisibility(drawing_.clip && drawing_.surface);
  for (vtkPolyDataMapper* mapper :
       {surface_mapper_.Get(), edge_mapper_.Get(), cloud_mapper_.Get(), fixed_mapper_.Get(),
        selected_mapper_.Get(), area_mapper_.Get()}) {
    mapper->RemoveAllClippingPlanes();
    if (drawing_.clip) mapper->AddClippingPlane(clip_plane_);
  }
}

// The sum of the area vectors of the triangles at each vertex.
Vector BodyScene::outward_normals(const Vector& x) const {
  Vector normals = Vector::Zero(x.size());
  for (const auto& [a, b, c] : shape_->triangles) {
    const Vector3 origin = vertex_block(x, a);
    const Vector3 normal = (vertex_block(x, b) - origin).cross(vertex_block(x, c) - origin);
    for (const Index v : {a, b, c}) vertex_block(normals, v) += normal;
  }
  return normals;
}

void BodyScene::update_arrows() {
  if (!last_) return;
  const double longest = 0.2 * size() * drawing_.arrow_scale;
  std::string legend;
  const auto draw = [&](BodyArrows& arrows, const Vector& field, const Vector& normals = {}) {
    if (!arrows.visible()) return;
    arrows.update(
        last_->position, field, shape_->surface_vertices, longest,
        [this](const Vector3& x) { return is_drawn(x); }, normals);
    if (const std::string text = arrows.legend(); !text.empty()) {
      legend += (legend.empty() ? "" : "\n") + text;
    }
  };
  const Vector normals =
      forces_.visible() || contacts_.visible() ? outward_normals(last_->position) : Vector();
  draw(forces_, last_->external_force, normals);
  draw(momenta_, last_->momentum);
  draw(reactions_, last_->reaction_force);
  draw(contacts_, last_->contact_force, normals);
  // Texts are changed rarely, because numbers that change in every picture cannot be read and text is slow
  // to draw.
  if (texts_due_) arrow_legend_->SetInput(legend.c_str());
}

}  // namespace tetraction::viewer
