#include "usual_obstacle.h"

#include <cmath>
#include <string>
#include <vector>

#include "mesh/bounding_box.h"
#include "tetraction/simulation/obstacle_settings.h"

namespace tetraction::viewer {
namespace {

// A length of few digits, which is easy to read.
double rounded(double length, double scale, double (*round)(double)) {
  return round(length * scale) / scale;
}

Json vector(double x, double y, double z) {
  return Json::array({x, y, z});
}

Json usual_shape(ObstacleKind kind, const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh);
  const double gap = 0.05 * box.diagonal();
  const double scale = std::pow(10.0, -std::floor(std::log10(gap)));
  const auto below = [&](double x) { return rounded(x - gap, scale, std::floor); };
  const auto above = [&](double x) { return rounded(x + gap, scale, std::ceil); };
  const Vector3 middle = 0.5 * (box.low + box.high);
  const double x = rounded(middle.x(), scale, std::round);
  const double z = rounded(middle.z(), scale, std::round);
  const double top = below(box.low.y());
  const double radius = rounded(0.5 * box.diagonal(), scale, std::round);
  const double center = rounded(top - radius, scale, std::round);
  Json table{{"kind", name_of(kind)}};
  switch (kind) {
    case ObstacleKind::kPlane:
      table["point"] = vector(0.0, top, 0.0);
      table["normal"] = vector(0.0, 1.0, 0.0);
      break;
    case ObstacleKind::kSphere:
      table["center"] = vector(x, center, z);
      table["radius"] = radius;
      break;
    case ObstacleKind::kCylinder:
      table["point"] = vector(x, center, z);
      table["axis"] = vector(0.0, 0.0, 1.0);
      table["radius"] = radius;
      break;
    case ObstacleKind::kBox:
      table["min"] = vector(below(box.low.x()), top, below(box.low.z()));
      table["max"] = vector(above(box.high.x()), above(box.high.y()), above(box.high.z()));
      table["inside"] = true;
      break;
    case ObstacleKind::kMesh:
      break;
  }
  return table;
}

}  // namespace

SceneChange with_usual_shape(const SceneChange& change, const Json& scene, const TetMesh& mesh) {
  SceneChange whole = change;
  if (change.kind == SceneChange::Kind::kAdd && change.value.is_null()) {
    whole.value = usual_shape(ObstacleKind::kPlane, mesh);
    whole.value["name"] = "floor";
  }
  const bool is_kind = change.kind == SceneChange::Kind::kSet &&
                       change.path == std::vector<std::string>{"kind"} && change.value.is_string();
  if (!is_kind) return whole;
  const auto kind = find_named<ObstacleKind>(change.value.get<std::string>());
  if (!kind) return whole;
  Json table = scene.at(change.place.section).at(change.place.index);
  for (const char* key :
       {"point", "normal", "center", "axis", "radius", "min", "max", "inside", "file", "unit"}) {
    table.erase(key);
  }
  table.update(usual_shape(*kind, mesh));
  whole.path.clear();
  whole.value = table;
  return whole;
}

}  // namespace tetraction::viewer
