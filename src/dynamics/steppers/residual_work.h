// What the residual of an energy-momentum step adds to the conserved quantities.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "dynamics/problems/energy_momentum_problem.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/state.h"

namespace tetraction {

/// The energy and the angular momentum that a residual r of the equations adds to the body. With p_{k+1} from the
/// forces and half of the step size s, the energy is 2s Σ (M v − p_k)·M⁻¹r, without the eliminated directions.
class ResidualWork {
 public:
  /// Keeps a reference to `step`, which must live longer.
  explicit ResidualWork(const DiscreteGradientStep& step) : step_(step), system_(step.system()) {}

  /// To be called before the first measure() of a step from this state, which must live until the last one.
  void begin(const State& from) {
    from_ = &from;
    knows_stored_ = false;
  }
  /// Measures what r at u adds (3 per vertex each).
  void measure(const Vector& u, const Vector& residual);

  /// The energy of the last measure(), J.
  double energy() const { return energy_; }
  /// Its magnitude relative to the kinetic energies, and the elastic energy and that of contact at the end, of the
  /// step. The stored energies are those of the first call in a step.
  double energy_share();
  /// The magnitude of the angular momentum relative to those of the vertices, Σ m |x × v|.
  double angular_share() const { return angular_share_; }

 private:
  const DiscreteGradientStep& step_;
  const MechanicalSystem& system_;
  const State* from_ = nullptr;
  Vector positions_;
  Vector projected_;
  double energy_ = 0.0;
  double kinetic_ = 0.0;  // twice the kinetic energies, J
  double angular_share_ = 0.0;
  bool knows_stored_ = false;
  double stored_ =
      0.0;  // magnitude of the elastic energy and that of contact at the end of the step, J
};

inline void ResidualWork::measure(const Vector& u, const Vector& residual) {
  projected_ = residual;
  system_.coordinates().project_momentum(system_.mass(), projected_);
  step_.positions(u, positions_);
  const double s = step_.step();
  double moment_scale = 0.0;
  Vector3 moment = Vector3::Zero();
  energy_ = kinetic_ = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const double mass = system_.mass()[v];
    const Vector3 x = vertex_block(positions_, v);
    const Vector3 velocity = (x - vertex_block(from_->position, v)) / s;
    const Vector3 before = vertex_block(from_->momentum, v) / mass;
    const Vector3 impulse = 2.0 * s * vertex_block(projected_, v);
    energy_ += (velocity - before).dot(impulse);
    kinetic_ += mass * (velocity.squaredNorm() + before.squaredNorm());
    moment += s * velocity.cross(impulse);
    moment_scale += mass * x.cross(velocity).norm();
  }
  angular_share_ = moment_scale > 0.0 ? moment.norm() / moment_scale : 0.0;
}

inline double ResidualWork::energy_share() {
  constexpr double kLittle = 1e-13;  // below which the stored energy does not matter
  if (!(kinetic_ > 0.0)) return 0.0;
  if (std::abs(energy_) <= kLittle * kinetic_) return std::abs(energy_) / kinetic_;
  if (!knows_stored_) {
    const Vector end = 2.0 * positions_ - from_->position;
    double energy = 0.0;
    stored_ = system_.elastic_energy(end, energy).ok() ? std::abs(energy) : 0.0;
    if (const Contact* contact = system_.contact(); contact != nullptr) {
      const double layers = contact->energy(step_.end_point(end));
      if (std::isfinite(layers)) stored_ += layers;
    }
    knows_stored_ = true;
  }
  return std::abs(energy_) / (kinetic_ + stored_);
}

}  // namespace tetraction
