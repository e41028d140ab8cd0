#include "material_at.h"

#include "mesh/quadratic_points.h"

namespace tetraction {

MaterialPlace place_of(const RestState& rest, Index i) {
  const Index e = rest.element_of(i);
  if (!rest.is_quadratic()) return {e, rest.center(e)};
  const ElementNodes nodes = rest.nodes(e);
  const auto near = static_cast<int>(i % QuadraticPoints::kPoints);
  const auto level = [near](int k) {
    return k == near ? QuadraticPoints::kNear : QuadraticPoints::kFar;
  };
  const auto node = [&](int a) { return rest.position(nodes[static_cast<std::size_t>(a)]); };
  Vector3 position = Vector3::Zero();
  for (int k = 0; k < 4; ++k) {
    position += level(k) * (2.0 * level(k) - 1.0) * node(k);
    for (int l = 0; l < k; ++l) {
      position += 4.0 * level(k) * level(l) * node(QuadraticPoints::middle(k, l));
    }
  }
  return {e, position};
}

}  // namespace tetraction
