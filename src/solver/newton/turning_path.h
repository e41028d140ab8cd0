// Curved paths along which the parts of a body turn without being stretched.
#pragma once

#include <memory>

#include "solver/linear/sparse_cholesky.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// A straight path x + t d stretches what turns along it by ½(tω)², with the rotation tω. A slender body resists
/// this far more than it resists bending, so that the potential rises after a small part of the distance to its
/// minimum. On the curved path u(t) = t d + O(t²) the deformation gradient F of each point becomes as nearly as possible
///
///     exp(t skw L) (I + t sym L) F,   L = ∇d F⁻¹,
///
/// the extrapolation in rotation-strain coordinates (Huang, Tong, Zhou, Bao & Desbrun 2011). u(t) is the
/// displacement whose gradient is nearest to that (least squares, weighted with the rest volume), among those that
/// the constraints allow. The matrix of these least squares is a Laplacian, which is factorised once.
class TurningPath {
 public:
  /// Keeps a reference to `system`, whose constraints must not change.
  explicit TurningPath(const MechanicalSystem& system) : system_(system) {}

  /// Begins at the positions x (3 per vertex, m) with a direction d that the constraints allow.
  void begin(const Vector& x, const Vector& d);
  /// The largest |∇d F⁻¹| in the body: a rotation or strain per t.
  double rate() const { return rate_; }
  /// The displacement u(t), m.
  Vector at(double t);

 private:
  struct Laplacian {
    explicit Laplacian(const MechanicalSystem& system);
    SparsityPattern pattern;
    SparseCholesky cholesky;
    bool is_factorized = false;
  };

  const MechanicalSystem& system_;
  std::unique_ptr<Laplacian> laplacian_;  // made when first needed
  Vector x_;
  Vector d_;
  double rate_ = 0.0;
};

}  // namespace tetraction
