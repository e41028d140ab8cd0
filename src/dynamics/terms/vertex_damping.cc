#include "tetraction/dynamics/terms/vertex_damping.h"

namespace tetraction {

double VertexDamping::dissipation(const ForcePoint& at, const Vector& v) const {
  double sum = 0.0;
  for (Index a = 0; a < at.mass.size(); ++a) {
    sum += coefficient(at.mass[a]) * vertex_block(v, a).squaredNorm();
  }
  return 0.5 * sum;
}

void VertexDamping::add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                             Vector& gradient) const {
  for (Index a = 0; a < at.mass.size(); ++a) {
    vertex_block(gradient, a) += coefficient(at.mass[a]) * vertex_block(v, a);
  }
}

void VertexDamping::add_dissipation_hessian(const ForcePoint& at, const Vector& /*v*/,
                                            HessianForm /*form*/, HessianBlocks& hessian) const {
  for (Index a = 0; a < at.mass.size(); ++a) {
    hessian.add(a, coefficient(at.mass[a]) * Matrix3::Identity());
  }
}

}  // namespace tetraction
