// The second derivative of the volumetric energy of average nodal volumes.
//
// With R = Σ V_e of a patch and b = Σ ∂v_e/∂x, ∂J/∂x = b/R and the gradient is Σ U' b/4. Its derivative
// is Σ U'' b bᵀ/(4R) + Σ_e t_e ∂²v_e/∂x², where t_e is the mean of U' over the nodes of e.
#include <algorithm>

#include "nodal_volume_impl.h"
#include "six_volume.h"

namespace tetraction {
namespace {

using NodeMatrix = RestState::Shape::NodeMatrix;

}  // namespace

std::span<const double> NodalVolume::tensions(const Positions& x) const {
  impl_->evaluate(x);
  return impl_->lane_tensions();
}

const Vector& NodalVolume::outer_factors(const Positions& x, HessianForm form) const {
  Impl& s = *impl_;
  s.evaluate(x);
  s.outer_factors.resize(s.patches.count());
  s.patches.for_each([&](Index p) {
    double curvature = s.law(p).second(s.ratio_change[p]);
    if (form == HessianForm::kConvex) curvature = std::max(0.0, curvature);
    // The vectors are those of 6v, and rest_volume() is 6R.
    s.outer_factors[p] = curvature / (24.0 * s.patches.rest_volume(p));
  });
  return s.outer_factors;
}

void NodalVolume::add_outer_products(const Positions& x, HessianForm form,
                                     HessianBlocks& hessian) const {
  Impl& s = *impl_;
  const Vector& factors = outer_factors(x, form);
  if (!s.gradients) s.gradients = std::make_unique<PatchGradients<double>>(s.patches);
  s.gradients->set(x);
  const NodalPatches::Rows& rows = s.patches.rows();
  std::vector<Vector3> vectors(rows.vertices.size());
  s.gradients->for_each([&](Index, Index entry, const Eigen::Vector4d& b) {
    vectors[static_cast<std::size_t>(entry)] = b.head<3>();
  });
  for (Index p = 0; p < s.patches.count(); ++p) {
    const std::span<const Index> vertices = patch_vertices(p);
    hessian.add_outer(
        factors[p], vertices,
        std::span(vectors).subspan(rows.begin[static_cast<std::size_t>(p)], vertices.size()));
  }
}

void NodalVolume::add_product(const Positions& x, const Vector& d, Vector& product) const {
  Impl& s = *impl_;
  const Vector& factors = outer_factors(x, HessianForm::kExact);
  const AlignedVector<double>& tensions = s.lane_tensions();
  s.patches.for_elements([&](Index e, std::size_t lane) {
    s.volumes[lane] = six_volume_gradient(s.rest.gather_relative(x, e))
                          .cwiseProduct(s.rest.gather_relative(d, e))
                          .sum();
  });
  Vector change(s.patches.count());
  s.patches.for_each([&](Index p) {
    double sum = 0.0;
    for (const std::int32_t lane : s.patches.lanes(p)) {
      sum += s.volumes[static_cast<std::size_t>(lane)];
    }
    change[p] = factors[p] * sum;
  });
  s.add_forces(product, [&](Index e, std::size_t lane) -> NodeMatrix {
    const NodeMatrix own = s.rest.gather_relative(x, e);
    return 4.0 * s.patches.mean(change, lane) * six_volume_gradient(own) +
           tensions[lane] / 6.0 * six_volume_product(own, s.rest.gather_relative(d, e));
  });
}

Index NodalVolume::patch_count() const {
  return impl_->patches.count();
}

std::span<const Index> NodalVolume::patch_vertices(Index patch) const {
  const NodalPatches::Rows& rows = impl_->patches.rows();
  const auto p = static_cast<std::size_t>(patch);
  return std::span(rows.vertices).subspan(rows.begin[p], rows.begin[p + 1] - rows.begin[p]);
}

}  // namespace tetraction
