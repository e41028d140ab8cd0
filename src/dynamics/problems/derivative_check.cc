#include "tetraction/dynamics/problems/derivative_check.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using Shape = ElasticPotential::Shape;

double shortest_edge(const Shape::NodeMatrix& x) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int a = 0; a < Shape::kNodes; ++a) {
    for (int b = a + 1; b < Shape::kNodes; ++b) {
      shortest = std::min(shortest, (x.col(a) - x.col(b)).norm());
    }
  }
  return shortest;
}

// ‖analytic − difference‖/‖analytic‖ from the squares of both.
double relative_error(double error_squared, double norm_squared) {
  if (norm_squared > 0.0) return std::sqrt(error_squared / norm_squared);
  return error_squared > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
}

// Compares columns of a second derivative with differences of the first one.
class ColumnErrors {
 public:
  /// `low`, `here` and `high` are the first derivative behind, at and ahead of a point, `behind` and `ahead` away.
  /// Returns whether the second derivative jumps.
  template <class Column>
  bool enter(const Column& low, const Column& here, const Column& high, double behind, double ahead,
             const Column& given) {
    constexpr double kLeastJump = 1e-3;
    constexpr double kRoundOff = 1e3 * std::numeric_limits<double>::epsilon();
    const Column left = (here - low) / behind;
    const Column right = (high - here) / ahead;
    double squared = ((high - low) / (behind + ahead) - given).squaredNorm();
    const bool jumps =
        (right - left).norm() > kLeastJump * std::max(left.norm(), right.norm()) +
                                    kRoundOff * here.norm() / std::min(behind, ahead);
    if (jumps) {
      squared = std::min({squared, (left - given).squaredNorm(), (right - given).squaredNorm()});
      ++jumps_;
    }
    squared_ += squared;
    norm_ += given.squaredNorm();
    return jumps;
  }
  void add(const ColumnErrors& other) {
    squared_ += other.squared_;
    norm_ += other.norm_;
    jumps_ += other.jumps_;
  }
  double relative() const { return relative_error(squared_, norm_); }
  Index jumps() const { return jumps_; }

 private:
  double squared_ = 0.0;
  double norm_ = 0.0;
  Index jumps_ = 0;
};

double least_eigenvalue(const HessianBlocks& hessian) {
  double least = std::numeric_limits<double>::infinity();
  double size = 0.0;
  const auto add = [&](const auto& matrix) {
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix, Eigen::EigenvaluesOnly);
    least = std::min(least, eigen.eigenvalues().minCoeff());
    size = std::max(size, eigen.eigenvalues().cwiseAbs().maxCoeff());
  };
  if (hessian.pairs().empty() && hessian.outers().empty()) {
    for (Index v = 0; v < hessian.vertex_count(); ++v) add(Matrix(hessian.diagonal(v)));
  } else {
    const Index dofs = 3 * hessian.vertex_count();
    Matrix dense = Matrix::Zero(dofs, dofs);
    const Matrix diagonal = hessian.whole_diagonal();
    for (Index v = 0; v < hessian.vertex_count(); ++v) {
      dense.block<3, 3>(3 * v, 3 * v) = diagonal.middleCols<3>(3 * v);
    }
    hessian.for_each_pair([&](Index i, Index j, const Matrix3& block) {
      dense.block<3, 3>(3 * i, 3 * j) += block;
      dense.block<3, 3>(3 * j, 3 * i) += block.transpose();
    });
    add(dense);
  }
  return size > 0.0 ? least / size : 0.0;
}

// The expected difference of energies between two points, divided by their distance: the first derivative here, or
// its mean if its own derivative jumps here.
double mean_slope(double low, double here, double high, bool jumps) {
  return jumps ? 0.25 * (low + 2.0 * here + high) : here;
}

// Compares at y. change(a, b) is the energy at b minus that at a, add_gradient(y, g) and
// add_hessian(y, form, h) add the derivatives at y.
template <class Change, class AddGradient, class AddHessian>
TermDerivativeErrors compare(const Vector& y, double step, const Change& change,
                             const AddGradient& add_gradient, const AddHessian& add_hessian) {
  const auto gradient_at = [&](const Vector& point) {
    Vector gradient = Vector::Zero(point.size());
    add_gradient(point, gradient);
    return gradient;
  };
  HessianBlocks hessian;
  hessian.reset(y.size() / 3);
  add_hessian(y, HessianForm::kExact, hessian);
  const Vector gradient = gradient_at(y);
  double gradient_error = 0.0;
  ColumnErrors columns;
  Vector low = y;
  Vector high = y;
  Vector unit = Vector::Zero(y.size());
  for (Index j = 0; j < y.size(); ++j) {
    low[j] = y[j] - step;
    high[j] = y[j] + step;
    const double width = high[j] - low[j];  // what the two points really are apart
    unit[j] = 1.0;
    Vector column = Vector::Zero(y.size());
    hessian.add_product(unit, column);
    const Vector below = gradient_at(low);
    const Vector above = gradient_at(high);
    const bool jumps = columns.enter(below, gradient, above, y[j] - low[j], high[j] - y[j], column);
    const double slope = mean_slope(below[j], gradient[j], above[j], jumps);
    gradient_error += std::pow(change(low, high) / width - slope, 2);
    low[j] = high[j] = y[j];
    unit[j] = 0.0;
  }
  HessianBlocks convex;
  convex.reset(y.size() / 3);
  add_hessian(y, HessianForm::kConvex, convex);
  return {relative_error(gradient_error, gradient.squaredNorm()), columns.relative(),
          least_eigenvalue(convex), gradient.norm(), columns.jumps()};
}

// An element with one of its coordinates moved down and up.
class MovedElement {
 public:
  struct Pair {
    double low = 0.0;  ///< the coordinate as it is rounded
    double high = 0.0;
    ElasticPotential::ElementTerms below;
    ElasticPotential::ElementTerms above;
    /// How much the slope of the forces differs between both sides, relative to itself; infinite where the energy is not
    /// defined on both.
    double bend = std::numeric_limits<double>::infinity();
  };

  MovedElement(const ElasticPotential& potential, const Vector& q)
      : potential_(potential), q_(q), moved_(q) {}

  /// Both sides at this step, or at one so much shorter that the forces are nearly straight lines, whose central
  /// differences are then exact to the square of the bend. Near the limit of a law, where its energy has no bound,
  /// they are straight over a small part of the distance to the limit only. A bend that does not get
  /// smaller with the step is a jump of the stiffness or round-off.
  Pair smooth_pair(Index e, Index dof, double step, const ElasticPotential::ElementTerms& here) {
    constexpr double kStraight = 1e-4;
    constexpr double kLeast = 1e-5;  // of the first step
    Pair pair = at(e, dof, step, here);
    for (double t = 0.25; pair.bend > kStraight && t > kLeast; t *= 0.25) {
      Pair closer = at(e, dof, t * step, here);
      if (!(closer.bend < 0.5 * pair.bend) && std::isfinite(pair.bend)) break;
      pair = closer;
    }
    return pair;
  }

 private:
  Pair at(Index e, Index dof, double step, const ElasticPotential::ElementTerms& here) {
    Pair pair;
    moved_[dof] = pair.high = q_[dof] + step;
    const bool is_above = potential_.element_terms(e, moved_, false, pair.above);
    moved_[dof] = pair.low = q_[dof] - step;
    const bool is_below = potential_.element_terms(e, moved_, false, pair.below);
    moved_[dof] = q_[dof];
    if (!is_above) pair.above = here;
    if (!is_below) pair.below = here;
    if (is_above && is_below) {
      const double change = (pair.above.gradient - pair.below.gradient).norm();
      const double bend = (pair.above.gradient - 2.0 * here.gradient + pair.below.gradient).norm();
      pair.bend = change > 0.0 ? bend / change : 0.0;
    }
    return pair;
  }

  const ElasticPotential& potential_;
  const Vector& q_;
  Vector moved_;
};

// Sums over elements whose derivatives were compared.
struct ElementErrors {
  double force_error = 0.0;
  double force_norm = 0.0;
  ColumnErrors columns;

  void compare(const ElasticPotential& potential, const Vector& q, Index e, MovedElement& moved) {
    using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 30, 1>;
    constexpr double kStep = 1e-5;
    const RestState& rest = potential.rest();
    ElasticPotential::ElementTerms exact;
    potential.element_terms(e, q, true, exact);
    const Column forces = exact.gradient.reshaped();
    const double step = kStep * shortest_edge(rest.gather(q, rest.points_per_element() * e));
    for (Index j = 0; j < forces.size(); ++j) {
      const Index dof = 3 * rest.nodes(e)[static_cast<std::size_t>(j / 3)] + j % 3;
      const MovedElement::Pair at = moved.smooth_pair(e, dof, step, exact);
      const Column below = at.below.gradient.reshaped();
      const Column above = at.above.gradient.reshaped();
      const bool jumps = columns.enter(below, forces, above, q[dof] - at.low, at.high - q[dof],
                                       Column(exact.hessian.col(j)));
      const double slope = mean_slope(below[j], forces[j], above[j], jumps);
      force_error += std::pow((at.above.energy - at.below.energy) / (at.high - at.low) - slope, 2);
      force_norm += forces[j] * forces[j];
    }
  }
  void add(const ElementErrors& other) {
    force_error += other.force_error;
    force_norm += other.force_norm;
    columns.add(other.columns);
  }
};

}  // namespace

DerivativeErrors check_derivatives(const ElasticPotential& potential, const Vector& q) {
  constexpr Index kMostCompared = 8192;
  constexpr Index kParts = 16;  // whose sums are added in this order for any number of threads
  const Index elements = potential.rest().element_count();
  const Index stride = std::max<Index>(1, elements / kMostCompared);
  const Index compared = (elements + stride - 1) / stride;
  std::array<ElementErrors, kParts> parts;
  parallel_for(kParts, 1, [&](Index begin, Index end) {
    MovedElement moved(potential, q);
    for (Index p = begin; p < end; ++p) {
      for (Index k = p * compared / kParts; k < (p + 1) * compared / kParts; ++k) {
        parts[static_cast<std::size_t>(p)].compare(potential, q, k * stride, moved);
      }
    }
  });
  ElementErrors all;
  for (const ElementErrors& part : parts) all.add(part);
  return {relative_error(all.force_error, all.force_norm), all.columns.relative(),
          std::sqrt(all.force_norm), all.columns.jumps()};
}

DerivativeErrors check_derivatives(const NodalVolume& volume, const RestState& rest,
                                   const Vector& q) {
  constexpr double kStep = 1e-5;
  constexpr int kDirections = 4;
  double edge = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < rest.point_count(); ++i) {
    edge = std::min(edge, shortest_edge(rest.gather(q, i)));
  }
  const auto gradient_at = [&](const Vector& x) {
    Vector gradient = Vector::Zero(q.size());
    volume.add_gradient(x, gradient);
    return gradient;
  };
  const Vector gradient = gradient_at(q);
  std::mt19937 random(20060901);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  double force_error = 0.0;
  double force_norm = 0.0;
  double stiffness_error = 0.0;
  double stiffness_norm = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    Vector direction(q.size());
    for (double& x : direction) x = number(random);
    const Vector high = q + kStep * edge * direction;
    const Vector low = q - kStep * edge * direction;
    const Vector distance = high - low;  // what the two points really are apart
    const double analytic = gradient.dot(distance);
    force_error += std::pow(volume.energy(high) - volume.energy(low) - analytic, 2);
    force_norm += analytic * analytic;
    Vector product = Vector::Zero(q.size());
    volume.add_product(q, distance, product);
    stiffness_error += (gradient_at(high) - gradient_at(low) - product).squaredNorm();
    stiffness_norm += product.squaredNorm();
  }
  return {relative_error(force_error, force_norm), relative_error(stiffness_error, stiffness_norm),
          gradient.norm(), 0};
}

Vector strained_state(const ElasticPotential& potential, const Vector& q, double strain) {
  const Index vertices = q.size() / 3;
  const auto points = q.reshaped(3, vertices);
  const Vector3 low = points.rowwise().minCoeff();
  const Vector3 size = (points.rowwise().maxCoeff() - low).cwiseMax(1e-300);

  double edge = std::numeric_limits<double>::infinity();
  const RestState& rest = potential.rest();
  for (Index i = 0; i < rest.point_count(); ++i) {
    edge = std::min(edge, shortest_edge(rest.gather(q, i)));
  }
  std::mt19937 random(20060901);
  std::uniform_real_distribution<double> jitter(-0.2 * edge, 0.2 * edge);

  Vector displacement(q.size());
  for (Index v = 0; v < vertices; ++v) {
    const Vector3 t = (vertex_block(q, v) - low).cwiseQuotient(size);  // in [0, 1]³
    vertex_block(displacement, v) =
        size.minCoeff() * Vector3(std::sin(2.0 * t.y()) * t.x(), std::cos(1.5 * t.z()) * t.x(),
                                  std::sin(1.0 + t.x()) * t.y()) +
        Vector3(jitter(random), jitter(random), jitter(random));
  }
  for (double scale = strain;; scale *= 0.5) {
    Vector result = q + scale * displacement;
    double energy = 0.0;  // its loop is the fastest that finds where W is not defined
    if (potential.value(result, energy).ok()) return result;
    if (scale < 1e-12) return q;
  }
}

ForceTermErrors check_derivatives(const ForceTerm& term, const ForcePoint& at, const Vector& v,
                                  double step) {
  const Index dofs = 3 * at.mass.size();
  if (at.position.size() != dofs || v.size() != dofs || !(step > 0.0)) {
    throw InputError(
        fmt::format("The check of the force term \"{}\" needs {} positions and velocities, 3 for "
                    "each mass, and "
                    "a step above 0; it was given {} positions, {} velocities and a step of {} m.",
                    term.name(), dofs, at.position.size(), v.size(), step));
  }
  constexpr double kStep = 1e-5;
  ForceTermErrors errors;
  if (term.has_potential()) {
    const auto point = [&](const Vector& x) { return ForcePoint{at.mass, x, at.time}; };
    for (const double shift : {0.0, -step, step}) {
      for (Index axis = 0; axis < 3; ++axis) {
        Vector moved = at.position;
        moved.reshaped(3, at.mass.size()).row(axis).array() += shift;
        const Index vertex = term.undefined_vertex(point(moved));
        if (vertex < 0) continue;
        throw InputError(fmt::format(
            "The potential of the force term \"{}\" is not defined at vertex {} or within {} m of "
            "it: check the derivatives at other positions, or with a smaller step.",
            term.name(), vertex, step));
      }
    }
    errors.potential = compare(
        at.position, step,
        [&](const Vector& a, const Vector& b) { return term.energy_change(point(a), point(b)); },
        [&](const Vector& x, Vector& gradient) { term.add_gradient(point(x), gradient); },
        [&](const Vector& x, HessianForm form, HessianBlocks& hessian) {
          term.add_hessian(point(x), form, hessian);
        });
  }
  if (term.has_dissipation()) {
    const double speed = v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0;
    errors.dissipation = compare(
        v, kStep * (speed > 0.0 ? speed : 1.0),
        [&](const Vector& a, const Vector& b) {
          return term.dissipation(at, b) - term.dissipation(at, a);
        },
        [&](const Vector& w, Vector& gradient) { term.add_dissipation_gradient(at, w, gradient); },
        [&](const Vector& w, HessianForm form, HessianBlocks& hessian) {
          term.add_dissipation_hessian(at, w, form, hessian);
        });
  }
  return errors;
}

}  // namespace tetraction
