// A discrete gradient of the volumetric energy of average nodal volumes.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "fem/element_fields.h"
#include "nodal_volume_impl.h"

namespace tetraction {
namespace {

using NodeMatrix = RestState::Shape::NodeMatrix;

Matrix3 cofactors(const Matrix3& a) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) {
    c.col(k) = Vector3(a.col((k + 1) % 3)).cross(Vector3(a.col((k + 2) % 3)));
  }
  return c;
}

// The derivative of the cofactors of a in the direction b.
Matrix3 cofactor_derivative(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    c.col(k) =
        Vector3(a.col(i)).cross(Vector3(b.col(j))) + Vector3(b.col(i)).cross(Vector3(a.col(j)));
  }
  return c;
}

// One element in a step from F − D to F + D. The change of J is G:ΔC exactly, with
//
//     G = [cof C̄ + cof(ΔC)/12]/(J_k + J_{k+1}),   C̄ = (C_k + C_{k+1})/2,   ΔC = C_{k+1} − C_k,
//
// because det C = J² is cubic in C and its cofactors are quadratic.
struct VolumeStep {
  Matrix3 middle;         // F
  Matrix3 end;            // F + D
  Matrix3 mean_metric;    // C̄
  Matrix3 metric_change;  // ΔC
  Matrix3 g;              // G
  double start_ratio;     // J_k
  double sum;             // J_k + J_{k+1}

  VolumeStep(const Matrix3& f, const Matrix3& d) : middle(f), end(f + d) {
    const Matrix3 start = f - d;
    start_ratio = start.determinant();
    sum = start_ratio + end.determinant();
    const Matrix3 product = f.transpose() * d;
    metric_change = 2.0 * (product + product.transpose());
    mean_metric = f.transpose() * f + d.transpose() * d;
    g = (cofactors(mean_metric) + cofactors(metric_change) / 12.0) / sum;
  }
  // J_{k+1} − J_k.
  double change() const { return g.cwiseProduct(metric_change).sum(); }
  // The first Piola–Kirchhoff stress of a unit tension.
  Matrix3 stress() const { return 2.0 * middle * g; }
  // The change of J_{k+1} where F changes by h and the start stays.
  double end_change(const Matrix3& h) const { return 2.0 * cofactors(end).cwiseProduct(h).sum(); }
  // The change of stress() then.
  Matrix3 stress_change(const Matrix3& h) const {
    const Matrix3 product = end.transpose() * h;
    const Matrix3 mean = product + product.transpose();  // of C̄; twice that of ΔC/2
    const Matrix3 change =
        (cofactor_derivative(mean_metric, mean) +
         cofactor_derivative(metric_change, 2.0 * mean) / 12.0 - end_change(h) * g) /
        sum;
    return 2.0 * (h * g + middle * change);
  }
};

// The steps of all elements from x − half_step to x + half_step.
class VolumeSteps {
 public:
  VolumeSteps(const RestState& rest, const Positions& x, const Vector& half_step)
      : rest_(rest), x_(x), half_step_(half_step) {}
  VolumeStep operator()(Index e) const { return {gradient(e, x_), gradient(e, half_step_)}; }
  // The change of F in the direction d.
  Matrix3 gradient(Index e, const Positions& d) const { return deformation_gradient(rest_, d, e); }
  // The forces of the nodes that belong to a first Piola–Kirchhoff stress.
  NodeMatrix forces(Index e, const Matrix3& stress) const {
    const auto element = rest_.point(e);
    return element.weights[0] * stress * element.gradients[0];
  }

 private:
  const RestState& rest_;
  const Positions& x_;
  const Vector& half_step_;
};

// The secant of U between both ends for every patch, and its change in a direction.
struct Secants {
  Vector value;
  Vector change;
};

Secants find_secants(const NodalPatches& patches, const std::vector<VolumetricLaw>& laws,
                     const RestState& rest, const VolumeSteps& steps, const Vector* direction) {
  const std::size_t lanes = patches.lane_count();
  // V times J_k − 1, the change of J, and the change of J_{k+1} in the direction.
  std::array<std::vector<double>, 3> volumes;
  volumes.fill(std::vector<double>(lanes));
  patches.for_elements([&](Index e, std::size_t lane) {
    const VolumeStep step = steps(e);
    const double v = rest.point(e).weights[0];
    volumes[0][lane] = v * (step.start_ratio - 1.0);
    volumes[1][lane] = v * step.change();
    if (direction == nullptr) return;
    volumes[2][lane] = v * step.end_change(steps.gradient(e, *direction));
  });
  Secants secants{Vector(patches.count()), Vector(patches.count())};
  patches.for_each([&](Index p) {
    std::array<double, 3> sums{};
    for (const std::int32_t lane : patches.lanes(p)) {
      for (std::size_t i = 0; i < 3; ++i) sums[i] += volumes[i][static_cast<std::size_t>(lane)];
    }
    const double scale = 6.0 / patches.rest_volume(p);
    const VolumetricLaw& law = laws[static_cast<std::size_t>(p)];
    secants.value[p] = law.secant(scale * sums[0], scale * sums[1]);
    secants.change[p] = law.secant_derivative(scale * sums[0], scale * sums[1]) * scale * sums[2];
  });
  return secants;
}

}  // namespace

void NodalVolume::add_discrete_gradient(const Positions& x, const Vector& half_step,
                                        Vector& gradient) const {
  Impl& s = *impl_;
  const VolumeSteps steps(s.rest, x, half_step);
  const Secants secants = find_secants(s.patches, s.laws, s.rest, steps, nullptr);
  s.add_forces(gradient, [&](Index e, std::size_t lane) {
    return steps.forces(e, s.patches.mean(secants.value, lane) * steps(e).stress());
  });
}

void NodalVolume::add_discrete_gradient_product(const Positions& x, const Vector& half_step,
                                                const Vector& d, Vector& product) const {
  Impl& s = *impl_;
  const VolumeSteps steps(s.rest, x, half_step);
  const Secants secants = find_secants(s.patches, s.laws, s.rest, steps, &d);
  s.add_forces(product, [&](Index e, std::size_t lane) {
    const VolumeStep step = steps(e);
    const Matrix3 stress =
        s.patches.mean(secants.change, lane) * step.stress() +
        s.patches.mean(secants.value, lane) * step.stress_change(steps.gradient(e, d));
    return steps.forces(e, stress);
  });
}

}  // namespace tetraction
