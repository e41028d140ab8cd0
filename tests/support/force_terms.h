// Force terms of several kinds, as a user of the library would write them.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/dynamics/terms/vertex_potential.h"

namespace tetraction::testing_support {

/// A frictionless floor at y = height: the barrier of Li et al. 2020, Incremental Potential Contact, eq. 6.
class FloorBarrier : public VertexPotential {
 public:
  FloorBarrier(double height, double stiffness, double thickness)
      : height_(height), stiffness_(stiffness), thickness_(thickness) {}
  std::string name() const override { return "floor"; }
  double value(double /*mass*/, const Vector3& x) const override {
    const double d = x.y() - height_;
    return d >= thickness_ ? 0.0
                           : -stiffness_ * std::pow(d - thickness_, 2) * std::log(d / thickness_);
  }
  Vector3 gradient(double /*mass*/, const Vector3& x) const override {
    const double d = x.y() - height_;
    if (d >= thickness_) return Vector3::Zero();
    const double gap = d - thickness_;
    return {0.0, -stiffness_ * gap * (2.0 * std::log(d / thickness_) + gap / d), 0.0};
  }
  Matrix3 hessian(double /*mass*/, const Vector3& x) const override {
    const double d = x.y() - height_;
    Matrix3 hessian = Matrix3::Zero();
    if (d >= thickness_) return hessian;
    const double ratio = (d - thickness_) / d;
    hessian(1, 1) = -stiffness_ * (2.0 * std::log(d / thickness_) + 4.0 * ratio - ratio * ratio);
    return hessian;
  }
  bool defined(const Vector3& x) const override { return x.y() > height_; }
  double admissible_fraction(const Vector3& x, const Vector3& d) const override {
    return d.y() < 0.0 ? (height_ - x.y()) / d.y() : std::numeric_limits<double>::infinity();
  }

 private:
  double height_, stiffness_, thickness_;
};

/// Springs U = ½ k (|x_i − x_j| − L)² between pairs of vertices. Their Hessian adds blocks to the
/// pattern of the elements. A spring only pulls: if it is shorter than L, it has no force and no
/// block.
class PairSprings : public ForceTerm {
 public:
  PairSprings(std::vector<std::pair<Index, Index>> pairs, double stiffness, double length)
      : pairs_(std::move(pairs)), stiffness_(stiffness), length_(length) {}
  std::string name() const override { return "pair_springs"; }
  bool has_potential() const override { return true; }
  bool couples_vertices() const override { return true; }
  double energy(const ForcePoint& at) const override {
    double sum = 0.0;
    for (const auto& [i, j] : pairs_) {
      const double stretch = way(at, i, j).norm() - length_;
      if (stretch > 0.0) sum += 0.5 * stiffness_ * stretch * stretch;
    }
    return sum;
  }
  void add_gradient(const ForcePoint& at, Vector& gradient) const override {
    for (const auto& [i, j] : pairs_) {
      const Vector3 d = way(at, i, j);
      const double l = d.norm();
      if (!(l > length_)) continue;
      const Vector3 pull = stiffness_ * (l - length_) / l * d;
      vertex_block(gradient, i) += pull;
      vertex_block(gradient, j) -= pull;
    }
  }
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override {
    for (const auto& [i, j] : pairs_) {
      const Vector3 d = way(at, i, j);
      const double l = d.norm();
      if (!(l > length_)) continue;
      const Matrix3 along = d * d.transpose() / (l * l);
      Matrix3 block = stiffness_ * (along + (1.0 - length_ / l) * (Matrix3::Identity() - along));
      if (form == HessianForm::kConvex) block = positive_semidefinite_part(block);
      hessian.add(i, block);
      hessian.add(j, block);
      hessian.add_pair(i, j, -block);
    }
  }

 private:
  static Vector3 way(const ForcePoint& at, Index i, Index j) {
    return vertex_block(at.position, i) - vertex_block(at.position, j);
  }

  std::vector<std::pair<Index, Index>> pairs_;
  double stiffness_, length_;
};

/// Drag that grows with the square of the speed: D = ⅓ c Σ m |v|³.
class QuadraticDrag : public ForceTerm {
 public:
  explicit QuadraticDrag(double coefficient) : coefficient_(coefficient) {}
  std::string name() const override { return "quadratic_drag"; }
  EnergyAccount account() const override { return EnergyAccount::kNone; }
  bool has_dissipation() const override { return true; }
  double dissipation(const ForcePoint& at, const Vector& v) const override {
    double sum = 0.0;
    for (Index a = 0; a < at.mass.size(); ++a) {
      sum += coefficient_ / 3.0 * at.mass[a] * std::pow(vertex_block(v, a).norm(), 3);
    }
    return sum;
  }
  void add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                Vector& gradient) const override {
    for (Index a = 0; a < at.mass.size(); ++a) {
      const Vector3 own = vertex_block(v, a);
      vertex_block(gradient, a) += coefficient_ * at.mass[a] * own.norm() * own;
    }
  }
  void add_dissipation_hessian(const ForcePoint& at, const Vector& v, HessianForm /*form*/,
                               HessianBlocks& hessian) const override {
    for (Index a = 0; a < at.mass.size(); ++a) {
      const Vector3 own = vertex_block(v, a);
      const double speed = own.norm();
      if (!(speed > 0.0)) continue;
      hessian.add(a, coefficient_ * at.mass[a] *
                         (speed * Matrix3::Identity() + own * own.transpose() / speed));
    }
  }

 private:
  double coefficient_;
};

/// Drag in a medium that gets denser with x: D = ½ c Σ m (1 + x/L)|v|².
class LayeredDrag : public ForceTerm {
 public:
  LayeredDrag(double coefficient, double length) : coefficient_(coefficient), length_(length) {}
  std::string name() const override { return "layered_drag"; }
  EnergyAccount account() const override { return EnergyAccount::kNone; }
  bool has_dissipation() const override { return true; }
  double dissipation(const ForcePoint& at, const Vector& v) const override {
    double sum = 0.0;
    for (Index a = 0; a < at.mass.size(); ++a) {
      sum += 0.5 * factor(at, a) * vertex_block(v, a).squaredNorm();
    }
    return sum;
  }
  void add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                Vector& gradient) const override {
    for (Index a = 0; a < at.mass.size(); ++a) {
      vertex_block(gradient, a) += factor(at, a) * vertex_block(v, a);
    }
  }
  void add_dissipation_hessian(const ForcePoint& at, const Vector& /*v*/, HessianForm /*form*/,
                               HessianBlocks& hessian) const override {
    for (Index a = 0; a < at.mass.size(); ++a) {
      hessian.add(a, factor(at, a) * Matrix3::Identity());
    }
  }

 private:
  double factor(const ForcePoint& at, Index a) const {
    return coefficient_ * at.mass[a] * (1.0 + at.position[3 * a] / length_);
  }

  double coefficient_, length_;
};

/// A uniform field whose strength oscillates: U = −Σ m A sin(ω t) x. It puts energy into the body.
class SwingingField : public ForceTerm {
 public:
  SwingingField(double acceleration, double omega) : acceleration_(acceleration), omega_(omega) {}
  std::string name() const override { return "swing"; }
  bool has_potential() const override { return true; }
  bool is_quadratic() const override { return true; }
  double energy(const ForcePoint& at) const override { return strength(at.time) * moment(at); }
  void add_gradient(const ForcePoint& at, Vector& gradient) const override {
    for (Index v = 0; v < at.mass.size(); ++v) gradient[3 * v] += at.mass[v] * strength(at.time);
  }
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override {
    return (strength(to.time) - strength(from.time)) * 0.5 * (moment(from) + moment(to));
  }

 private:
  double strength(double time) const { return -acceleration_ * std::sin(omega_ * time); }
  static double moment(const ForcePoint& at) {
    double sum = 0.0;
    for (Index v = 0; v < at.mass.size(); ++v) sum += at.mass[v] * at.position[3 * v];
    return sum;
  }

  double acceleration_, omega_;
};

}  // namespace tetraction::testing_support
