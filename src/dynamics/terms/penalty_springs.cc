#include "tetraction/dynamics/terms/penalty_springs.h"

namespace tetraction {

PenaltySprings::PenaltySprings(const std::vector<PrescribedVertices>& held, Index vertex_count) {
  for (const PrescribedVertices& list : held) {
    if (!(list.penalty > 0.0)) continue;
    for (std::size_t i = 0; i < list.vertices.size(); ++i) {
      const Vector3 start = list.start.col(static_cast<Index>(i));
      for (Index axis = 0; axis < 3; ++axis) {
        if (!list.components[static_cast<std::size_t>(axis)]) continue;
        springs_.push_back({3 * list.vertices[i] + axis, list.penalty, start, list.motion});
      }
    }
  }
  if (springs_.empty()) return;
  stiffness_.setZero(3 * vertex_count);
  for (const Spring& spring : springs_) stiffness_[spring.dof] += 2.0 * spring.penalty;
}

double PenaltySprings::energy(const ForcePoint& at) const {
  double energy = 0.0;
  for (const Spring& spring : springs_) {
    if (spring.dof >= 3 * at.mass.size()) continue;  // not among the vertices of an energy
    const double gap = at.position[spring.dof] - spring.target(at.time);
    energy += spring.penalty * gap * gap;
  }
  return energy;
}

void PenaltySprings::add_gradient(const ForcePoint& at, Vector& gradient) const {
  for (const Spring& spring : springs_) {
    gradient[spring.dof] +=
        2.0 * spring.penalty * (at.position[spring.dof] - spring.target(at.time));
  }
}

void PenaltySprings::add_hessian(const ForcePoint& /*at*/, HessianForm /*form*/,
                                 HessianBlocks& hessian) const {
  for (const Spring& spring : springs_) {
    Matrix3 block = Matrix3::Zero();
    block(spring.dof % 3, spring.dof % 3) = 2.0 * spring.penalty;
    hessian.add(spring.dof / 3, block);
  }
}

double PenaltySprings::driven_work(const ForcePoint& from, const ForcePoint& to) const {
  double work = 0.0;
  for (const Spring& spring : springs_) {
    if (spring.dof >= 3 * to.mass.size()) continue;
    const double start = spring.target(from.time);
    const double end = spring.target(to.time);
    work += spring.penalty *
            ((start - from.position[spring.dof]) + (end - to.position[spring.dof])) * (end - start);
  }
  return work;
}

}  // namespace tetraction
