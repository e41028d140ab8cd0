// Preconditioned conjugate gradients for any operator and preconditioner.
#pragma once

#include <cmath>

#include "tetraction/core/types.h"

namespace tetraction {

/// How a solve by conjugate gradients ended.
struct CgReport {
  int iterations = 0;
  double first_square = 0.0;        ///< r·r at the beginning
  double last_square = 0.0;         ///< r·r at the end
  bool negative_curvature = false;  ///< whether a direction p with p·A p ≤ 0 was found
  double curvature = 0.0;           ///< p·A p of that direction
  bool converged = false;
  int coarse_spaces = 0;  ///< number of coarse spaces that were built during the solve

  /// The ratio of |r| at the end to |r| at the beginning.
  double reduction() const {
    return first_square > 0.0 ? std::sqrt(last_square / first_square) : 0.0;
  }
};

/// Solves A x = b until |r| ≤ forcing × |r at the beginning|, in at most `max_iterations` iterations
/// (Hestenes & Stiefel 1952). It ends if a search direction p has p·A p ≤ 0. If this is the first
/// search direction, x is set to p. It ends as well if r·M⁻¹ r ≤ 0, so that M is not positive definite.
///
/// `Vectors` stores x, r, p and A p in any form and provides
///
///     double square() const        returns r·r
///     double precondition()        z = M⁻¹ r; returns r·z
///     void begin()                 p = z
///     bool renew(const CgReport&)  may change the preconditioner; returns whether it did
///     double multiply()            ap = A p; returns p·ap
///     void descend(double alpha)   r −= alpha ap
///     void turn(double alpha, double beta)  x += alpha p; p = z + beta p
///     void finish(double alpha)    x += alpha p
///     void take_direction()        x = p
///
/// The preconditioner may be the most expensive part. It is not applied in the last iteration.
template <class Vectors>
CgReport conjugate_gradients(Vectors& vectors, double forcing, int max_iterations) {
  CgReport report;
  report.first_square = report.last_square = vectors.square();
  const double enough = forcing * forcing * report.first_square;
  report.converged = report.last_square <= enough;
  if (report.converged || max_iterations < 1) return report;
  double rz = vectors.precondition();
  if (!(rz > 0.0)) return report;
  vectors.begin();
  for (;;) {
    if (vectors.renew(report)) {
      ++report.coarse_spaces;
      rz = vectors.precondition();
      vectors.begin();
    }
    ++report.iterations;
    const double curvature = vectors.multiply();
    if (!(curvature > 0.0)) {
      report.negative_curvature = true;
      report.curvature = curvature;
      if (report.iterations == 1) vectors.take_direction();
      return report;
    }
    const double alpha = rz / curvature;
    vectors.descend(alpha);
    report.last_square = vectors.square();
    report.converged = report.last_square <= enough;
    if (report.converged || report.iterations >= max_iterations) {
      vectors.finish(alpha);
      return report;
    }
    const double next = vectors.precondition();
    if (!(next > 0.0)) {
      vectors.finish(alpha);
      return report;
    }
    vectors.turn(alpha, next / rz);
    rz = next;
  }
}

/// The vectors of conjugate_gradients() as Eigen vectors. multiply(p, ap) sets ap = A p, and
/// precondition(r, z) sets z = M⁻¹ r. The caller sets the initial x and r = b − A x.
template <class Multiply, class Precondition>
class PlainVectors {
 public:
  PlainVectors(Vector& x, Vector& r, Multiply multiply, Precondition precondition)
      : x_(x), r_(r), multiply_(multiply), precondition_(precondition) {}

  const Vector& direction() const { return p_; }

  double square() const { return r_.squaredNorm(); }
  double precondition() {
    precondition_(r_, z_);
    return r_.dot(z_);
  }
  void begin() { p_ = z_; }
  bool renew(const CgReport& /*report*/) { return false; }
  double multiply() {
    multiply_(p_, ap_);
    return p_.dot(ap_);
  }
  void descend(double alpha) { r_ -= alpha * ap_; }
  void turn(double alpha, double beta) {
    x_ += alpha * p_;
    p_ = z_ + beta * p_;
  }
  void finish(double alpha) { x_ += alpha * p_; }
  void take_direction() { x_ = p_; }

 private:
  Vector& x_;
  Vector& r_;
  Multiply multiply_;
  Precondition precondition_;
  Vector p_;
  Vector ap_;
  Vector z_;
};

}  // namespace tetraction
