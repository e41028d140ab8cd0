#include "tetraction/dynamics/terms/external_forces.h"

#include "load_factor.h"

namespace tetraction {

void ExternalForces::add_load(const ForcePoint& at, Vector& force) const {
  for (const ExternalForce& each : forces_) {
    const double factor = factor_at(each.history, at);
    if (factor == 0.0) continue;
    for (std::size_t i = 0; i < each.vertices.size(); ++i) {
      if (each.vectors.size() == 0) {
        vertex_block(force, each.vertices[i]) += factor * each.vector;
      } else {
        vertex_block(force, each.vertices[i]) += factor * each.vectors.col(static_cast<Index>(i));
      }
    }
  }
}

}  // namespace tetraction
