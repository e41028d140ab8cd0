#include "body_arrows.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkFloatArray.h>
#include <vtkGlyph3DMapper.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <utility>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

// More arrows would hide each other, and drawing them would take longer than drawing the body.
constexpr std::size_t kMostArrows = 500;

}  // namespace

BodyArrows::BodyArrows(vtkRenderer* renderer, std::string name, std::string unit,
                       const double* color)
    : name_(std::move(name)), unit_(std::move(unit)) {
  std::copy_n(color, 3, color_);
  vectors_->SetName("vector");
  vectors_->SetNumberOfComponents(3);
  data_->SetPoints(points_);
  data_->GetPointData()->AddArray(vectors_);
  vtkNew<vtkArrowSource> arrow;
  arrow->SetTipResolution(8);
  arrow->SetShaftResolution(6);
  arrow->SetTipLength(0.3);
  arrow->SetTipRadius(0.07);
  arrow->SetShaftRadius(0.022);
  arrow->Update();
  mapper_->SetSourceData(arrow->GetOutput());
  mapper_->SetInputData(data_);
  mapper_->SetOrientationArray("vector");
  mapper_->SetOrientationModeToDirection();
  mapper_->SetScaleArray("vector");
  mapper_->SetScaleModeToScaleByMagnitude();
  mapper_->ScalarVisibilityOff();
  actor_->SetMapper(mapper_);
  actor_->GetProperty()->SetColor(color_);
  actor_->GetProperty()->SetAmbient(0.4);
  actor_->VisibilityOff();
  renderer->AddActor(actor_);
}

BodyArrows::~BodyArrows() = default;

void BodyArrows::set_visible(bool visible) {
  visible_ = visible;
  if (!visible) actor_->VisibilityOff();
}

void BodyArrows::update(const Vector& position, const Vector& field,
                        const std::vector<Index>& surface, double longest,
                        const std::function<bool(const Vector3&)>& is_drawn,
                        const Vector& normals) {
  std::vector<Index> places;
  largest_ = 0.0;
  for (Index v = 0; v < field.size() / 3; ++v) {
    largest_ = std::max(largest_, field.segment<3>(3 * v).norm());
  }
  // Vectors below this fraction of the largest are round-off and are not drawn.
  constexpr double kLeastFraction = 1e-6;
  const auto add = [&](Index v) {
    if (field.segment<3>(3 * v).norm() > kLeastFraction * largest_ &&
        is_drawn(vertex_block(position, v))) {
      places.push_back(v);
    }
  };
  for (Index v = 0; v < field.size() / 3; ++v) add(v);
  if (places.size() > kMostArrows) {
    places.clear();
    for (const Index v : surface) add(v);
  }
  const std::size_t stride = places.size() / kMostArrows + 1;
  const auto count = static_cast<vtkIdType>((places.size() + stride - 1) / stride);
  points_->SetNumberOfPoints(count);
  vectors_->SetNumberOfTuples(count);
  for (vtkIdType i = 0; i < count; ++i) {
    const Index v = places[static_cast<std::size_t>(i) * stride];
    Vector3 place = vertex_block(position, v);
    const Vector3 arrow = vertex_block(field, v);
    if (normals.size() > 0 && arrow.dot(vertex_block(normals, v)) < 0.0) {
      place -= longest / largest_ * arrow;
    }
    points_->SetPoint(i, place.data());
    vectors_->SetTuple(i, field.data() + 3 * v);
  }
  points_->Modified();
  vectors_->Modified();
  data_->Modified();
  mapper_->SetScaleFactor(largest_ > 0.0 ? longest / largest_ : 1.0);
  actor_->SetVisibility(visible_ && count > 0);
}

std::string BodyArrows::legend() const {
  if (!visible_ || largest_ == 0.0) return {};
  return fmt::format("{}: longest arrow {}", name_, with_unit(largest_, unit_, 3));
}

}  // namespace tetraction::viewer
