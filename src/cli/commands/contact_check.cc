#include "contact_check.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "mesh/bounding_box.h"
#include "mesh/mesh_pieces.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Sums of squares.
struct ErrorSums {
  double force = 0.0;
  double force_norm = 0.0;
  double stiffness = 0.0;
  double stiffness_norm = 0.0;
};

class ContactCheck {
 public:
  explicit ContactCheck(const MechanicalSystem& system)
      : system_(system), contact_(*system.contact()), thickness_(contact_.least_thickness()) {}

  // q moved by a part of `all` to where the first obstacle or body on the way is half of a layer away, or nothing.
  std::optional<Vector> in_layer(const Vector& q, const Vector& all) const {
    constexpr int kHalvings = 200;
    const double touch = contact_.longest_step(point(q), all);
    if (!(touch < 1.0)) return std::nullopt;
    double low = 0.0;
    double high = touch;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      const Vector x = q + middle * all;
      const bool is_beyond = contact_.undefined_vertex(point(x)) >= 0;
      const double gap = is_beyond ? 0.0 : contact_.smallest_gap(point(x));
      if (gap > 0.4 * thickness_ && gap < 0.6 * thickness_) return x;
      (gap > 0.5 * thickness_ ? low : high) = middle;
    }
    return std::nullopt;
  }

  void compare(const Vector& x) {
    constexpr int kDirections = 4;
    constexpr double kStep = 3e-5;
    constexpr double kJump = 1e-7;  // of the slope of a vertex, between two steps
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    Vector here = x;
    for (double& each : here) each += 0.1 * thickness_ * number(random_);
    if (contact_.undefined_vertex(point(here)) >= 0) here = x;
    HessianBlocks hessian;
    hessian.reset(system_.vertex_count());
    contact_.add_hessian(point(here), HessianForm::kExact, hessian);
    const Vector gradient = gradient_at(here);
    for (int k = 0; k < kDirections; ++k) {
      Vector direction(here.size());
      for (double& each : direction) each = number(random_);
      const Vector high = here + kStep * 0.5 * thickness_ * direction;
      const Vector low = here - kStep * 0.5 * thickness_ * direction;
      const Vector above = gradient_at(high);
      const Vector below = gradient_at(low);
      const auto product = [&](const Vector& by) {
        Vector result = Vector::Zero(by.size());
        hessian.add_product(by, result);
        return result;
      };
      // What the two points really are apart.
      const Vector whole = product(high - low);
      const Vector slope = above - below;
      const Vector quarter = 0.5 * (high - here);
      const Vector slope_of_half =
          2.0 * (gradient_at(here + quarter) - gradient_at(here - quarter));
      bool jumps = false;
      for (Index v = 0; v < system_.vertex_count(); ++v) {
        const Vector3 found = vertex_block(slope, v);
        // Where a closest feature changes between the points, the second derivative jumps: there is none.
        if ((found - vertex_block(slope_of_half, v)).norm() > kJump * found.norm()) {
          jumps = true;
          continue;
        }
        const Vector3 expected = vertex_block(whole, v);
        sums_.stiffness += (found - expected).squaredNorm();
        sums_.stiffness_norm += expected.squaredNorm();
      }
      const Vector mean = jumps ? Vector(0.25 * (above + 2.0 * gradient + below)) : gradient;
      const double expected = mean.dot(high - low);
      sums_.force +=
          std::pow(contact_.energy(point(high)) - contact_.energy(point(low)) - expected, 2);
      sums_.force_norm += expected * expected;
    }
    squared_force_ += gradient.squaredNorm();
  }

  DerivativeErrors errors() const {
    return {std::sqrt(sums_.force / sums_.force_norm),
            sums_.stiffness_norm > 0.0 ? std::sqrt(sums_.stiffness / sums_.stiffness_norm) : 0.0,
            std::sqrt(squared_force_), 0};
  }

 private:
  ForcePoint point(const Vector& x) const { return system_.force_point(x, 0.0); }
  Vector gradient_at(const Vector& x) const {
    Vector gradient = Vector::Zero(x.size());
    contact_.add_gradient(point(x), gradient);
    return gradient;
  }

  const MechanicalSystem& system_;
  const Contact& contact_;
  double thickness_;
  std::mt19937 random_{20060901};
  ErrorSums sums_;
  double squared_force_ = 0.0;
};

}  // namespace

std::optional<DerivativeErrors> check_contact_derivatives(const MechanicalSystem& system,
                                                          const Vector& q) {
  constexpr double kReach = 1e3;  // sizes of the body
  if (system.contact() == nullptr) return std::nullopt;
  ContactCheck check(system);
  const double size = bounding_box(system.mesh()).diagonal();
  bool any = false;
  const auto go = [&](const Vector& way) {
    const auto x = check.in_layer(q, way);
    if (!x) return;
    check.compare(*x);
    any = true;
  };
  for (const double sign : {-1.0, 1.0}) {
    for (Index axis = 0; axis < 3; ++axis) {
      go((sign * kReach * size * Vector3::Unit(axis)).replicate(system.vertex_count(), 1));
    }
  }
  if (system.contact()->between() != nullptr) {
    // All bodies come together, towards the middle of all vertices.
    Vector3 middle = Vector3::Zero();
    for (Index v = 0; v < system.vertex_count(); ++v) middle += vertex_block(q, v);
    middle /= static_cast<double>(system.vertex_count());
    Vector inwards(q.size());
    for (const MeshPiece& body : mesh_pieces(system.mesh())) {
      Vector3 center = Vector3::Zero();
      for (const Index v : body.vertices) center += vertex_block(q, v);
      center /= static_cast<double>(body.vertices.size());
      for (const Index v : body.vertices) vertex_block(inwards, v) = middle - center;
    }
    go(inwards);
  }
  if (!any) return std::nullopt;
  return check.errors();
}

}  // namespace tetraction
