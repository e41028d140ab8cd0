//                       Tetraction example: a force field of your own
//
// Sample runs:  custom_force_field              2000 steps
//               custom_force_field 100000
//
// Description:  A trap pulls every vertex toward the z axis, weakly far away, and holds it near z = 0:
//
//                 U(m, q) = ½ m (Ω² R² ln(1 + (x² + y²)/R²) + ω_z² z²).
//
//               A soft block circles in it and wobbles. Energy and the angular momentum about the
//               axis are kept by verlet, and a session changes the trap while it runs.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

using namespace tetraction;

// 1. The field: the potential of one vertex, its gradient and its second derivative.
class AxisTrap : public ForceField {
 public:
  AxisTrap(double rate, double radius, double axial_rate)
      : rate_(rate), radius_(radius), axial_rate_(axial_rate) {}

  double value(double mass, const Vector3& q) const override {
    const double s = q.head<2>().squaredNorm() / (radius_ * radius_);
    return 0.5 * mass *
           (std::pow(rate_ * radius_, 2) * std::log1p(s) + std::pow(axial_rate_ * q.z(), 2));
  }
  Vector3 gradient(double mass, const Vector3& q) const override {
    const double k = rate_ * rate_ / (1.0 + q.head<2>().squaredNorm() / (radius_ * radius_));
    return mass * Vector3(k * q.x(), k * q.y(), axial_rate_ * axial_rate_ * q.z());
  }
  Matrix3 hessian(double mass, const Vector3& q) const override {
    const Vector3 r(q.x(), q.y(), 0.0);
    const double k = rate_ * rate_ / (1.0 + r.squaredNorm() / (radius_ * radius_));
    const double bend = -2.0 * k * k / std::pow(rate_ * radius_, 2);
    Matrix3 hessian = Vector3(k, k, axial_rate_ * axial_rate_).asDiagonal();
    hessian += bend * r * r.transpose();
    return mass * hessian;
  }

 private:
  double rate_, radius_, axial_rate_;  // Ω in 1/s, R in m, ω_z in 1/s
};

int main(int argc, char** argv) {
  // 2. The scene: a soft block beside the axis, thrown around it and a little upward.
  const Index steps = argc > 1 ? std::atoi(argv[1]) : 2000;
  Scene scene;
  scene.material.youngs_modulus = 2.0e4;
  scene.material.poissons_ratio = 0.3;
  scene.time.integrator = Integrator::kVerlet;
  scene.time.step = 2.0e-3;
  scene.time.end = static_cast<double>(steps) * scene.time.step;
  scene.initial.velocity = {0.0, 3.0, 1.0};
  scene.environment.kind = EnvironmentKind::kCustom;
  scene.environment.field = std::make_shared<AxisTrap>(2.0, 3.0, 1.0);
  TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {3, 3, 3});
  for (Vector3& x : mesh.vertices.own()) x += Vector3(2.0, -0.5, -0.5);
  Session session(scene, mesh);

  // 3. Run; half-way the trap becomes narrower. What that does to the energy is the edit's work.
  const double spin = session.balance().momenta().angular.z();
  double largest_spin_error = 0.0;
  std::printf("%8s %14s %14s %14s %14s %16s\n", "time", "kinetic [J]", "elastic [J]", "trap [J]",
              "edit work", "Lz [kg m2/s]");
  while (session.step()) {
    const Balance& balance = session.balance();
    const Index step = session.state().step;
    largest_spin_error =
        std::fmax(largest_spin_error, std::abs(balance.momenta().angular.z() - spin));
    if (step == steps / 2) {
      EnvironmentSettings narrower = scene.environment;
      narrower.field = std::make_shared<AxisTrap>(2.5, 2.0, 1.5);
      session.apply(SetEnvironment{narrower});
    }
    if (step % (steps / 10 > 0 ? steps / 10 : 1) == 0) {
      const Energies& e = balance.energies();
      std::printf("%8.3f %14.4f %14.4f %14.4f %14.4f %16.9f\n", session.state().time, e.kinetic(),
                  e.elastic(), e.environment(), balance.edit_work(), balance.momenta().angular.z());
    }
  }
  if (session.status() != RunStatus::kFinished) {
    std::fprintf(stderr, "%s\n", session.message().c_str());
    return 1;
  }

  // 4. What was promised, measured.
  std::printf("energy kept within %.2g of itself\nangular momentum about the axis kept to %.2e\n",
              session.balance().max_relative_energy_drift(), largest_spin_error / std::abs(spin));
  return 0;
}
