#include "tetraction/fem/step_length.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <variant>

#include "element_fields.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

Matrix3 edges(const RestState& rest, const Vector& field, Index i) {
  const RestState::Shape::NodeMatrix nodes = rest.gather(field, i);
  return nodes.rightCols<3>().colwise() - nodes.col(0);
}

// Returns a t ≤ 1 such that J/J(0) = 1 + a t + b t² + c t³ is above `least` on the whole way from 0
// to t.
double admissible_fraction(double a, double b, double c, double least) {
  constexpr double kLimit = 1.0;
  if (1.0 + std::min(a, 0.0) + std::min(b, 0.0) + std::min(c, 0.0) > least) return kLimit;
  const auto ratio = [=](double t) { return 1.0 + t * (a + t * (b + t * c)); };
  // The ends of the intervals on which the ratio is monotonic, ascending.
  std::array<double, 3> ends{kLimit, kLimit, kLimit};
  if (const double discriminant = b * b - 3.0 * a * c; discriminant > 0.0) {
    const double s = -(b + std::copysign(std::sqrt(discriminant), b));
    const auto within = [=](double t) { return t > 0.0 && t < kLimit ? t : kLimit; };
    ends = {within(s / (3.0 * c)), within(a / s), kLimit};
    std::sort(ends.begin(), ends.end());
  }
  double low = 0.0;
  for (double high : ends) {
    if (ratio(high) > least) {
      low = high;
      continue;
    }
    // Bisection until the ratio is above `least` by less than a tenth of the allowed loss.
    while (ratio(low) - least >= 0.1 * (1.0 - least)) {
      const double middle = low + 0.5 * (high - low);
      if (!(middle > low && middle < high)) break;
      (ratio(middle) > least ? low : high) = middle;
    }
    return low;
  }
  return kLimit;
}

// Calls body(m) if materials of this type have a limit of their stretch.
template <class Body>
void with_limited(const MaterialField& material, const Body& body) {
  std::visit(
      [&]<class M>(const M& m) {
        if constexpr (HasStretchLimit<M>) body(m);
      },
      material.model());
}

// The least number to which body(i, least) reduces `longest` at the quadrature points i.
template <class Body>
double least_of_points(const RestState& rest, double longest, const Body& body) {
  double least = longest;
  std::mutex mutex;
  parallel_for(rest.point_count(), 512, [&](Index begin, Index end) {
    double own = longest;
    for (Index i = begin; i < end; ++i) body(i, own);
    const std::lock_guard<std::mutex> lock(mutex);
    least = std::min(least, own);
  });
  return least;
}

// The same with body(m, i, least) at the points of materials m that have a limit of their stretch.
template <class Body>
double least_of_limited(const ElasticPotential& elastic, double longest, const Body& body) {
  return least_of_points(elastic.rest(), longest, [&](Index i, double& least) {
    const Index e = elastic.rest().element_of(i);
    const MaterialField& material =
        elastic.materials()[static_cast<std::size_t>(elastic.material_index(e))];
    with_limited(material, [&](const auto& model) {
      material.with_element(model, e, [&](const auto& m) { body(m, i, least); });
    });
  });
}

template <class M>
double margin_of(const M& m, const Matrix3& f) {
  return jacobian(f) > 0.0 ? m.stretch_margin(f) : -1.0;
}

// The largest t ≤ longest, up to a tenth, such that margin(t) is above `least` on the way.
template <class Margin>
double limited_fraction(const Margin& margin, double least, double longest) {
  constexpr int kLooks = 8;
  double low = 0.0;
  for (int i = 1; i <= kLooks; ++i) {
    double high = longest * i / kLooks;
    if (margin(high) > least) {
      low = high;
      continue;
    }
    for (int halving = 0; halving < 50 && margin(low) > 2.0 * least; ++halving) {
      const double middle = 0.5 * (low + high);
      (margin(middle) > least ? low : high) = middle;
    }
    break;
  }
  return low;
}

}  // namespace

std::string inadmissible_change(const ElasticPotential& elastic, const Vector& q, Index element,
                                std::int64_t id) {
  const RestState& rest = elastic.rest();
  for (Index i = 0; i < rest.point_count(); ++i) {
    if (rest.element_of(i) != element) continue;
    const Matrix3 f = deformation_gradient(rest, q, i);
    if (!(jacobian(f) > 0.0)) return fmt::format("inverts element {}", id);
  }
  return fmt::format("stretches element {} beyond the limit of its material", id);
}

bool has_stretch_limit(const ElasticPotential& elastic) {
  bool found = false;
  for (const MaterialField& material : elastic.materials()) {
    with_limited(material, [&](const auto&) { found = true; });
  }
  return found;
}

double stretch_limited_step(const ElasticPotential& elastic, const Vector& q, const Vector& d,
                            double longest) {
  constexpr double kLeastShare = 0.1;
  return least_of_limited(elastic, longest, [&](const auto& m, Index i, double& own) {
    const Matrix3 f = deformation_gradient(elastic.rest(), q, i);
    const Matrix3 change = deformation_gradient(elastic.rest(), d, i);
    const auto margin = [&](double t) { return margin_of(m, f + t * change); };
    const double now = margin(0.0);
    if (now > 0.0) own = std::min(own, limited_fraction(margin, kLeastShare * now, own));
  });
}

double least_stretch_margin(const ElasticPotential& elastic, const Vector& q) {
  return least_of_limited(elastic, 1.0, [&](const auto& m, Index i, double& own) {
    const RestState& rest = elastic.rest();
    own = std::min(own, margin_of(m, deformation_gradient(rest, q, i)));
  });
}

double admissible_step(const RestState& rest, const Vector& q, const Vector& d,
                       const std::function<bool(Index)>& counts) {
  constexpr double kLeastRatio = 0.1;
  return least_of_points(rest, 1.0, [&](Index i, double& own) {
    if (counts && !counts(rest.element_of(i))) return;
    const Matrix3 current = edges(rest, q, i);
    const double det = current.determinant();
    if (!(det > 0.0)) return;
    const Matrix3 m = current.inverse() * edges(rest, d, i);
    const double a = m.trace();
    const double b = 0.5 * (a * a - (m * m).trace());
    own = std::min(own, admissible_fraction(a, b, m.determinant(), kLeastRatio));
  });
}

}  // namespace tetraction
