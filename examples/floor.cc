//                       Tetraction example: a force term of your own
//
// Sample runs:  floor                  two seconds with every rule
//               floor 0.5
//               floor 2 results        also history.csv and frames for ParaView in results/<rule>
//
// Description:  A soft block falls on a frictionless floor and bounces. The floor is a barrier,
//
//                 U(d) = −κ (d − d̂)² ln(d/d̂)   for a vertex at the height 0 < d < d̂ above it,
//
//               0 above d̂, twice continuously differentiable and infinite at d = 0 (Li et al. 2020,
//               Incremental Potential Contact, eq. 6). No vertex can ever pass it. All integrators and
//               solvers, the stability limit and the energy balance take it as they take gravity: the
//               energy that it holds is a column of its own.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

using namespace tetraction;

// 1. The term: energy, gradient and Hessian of one vertex, where they are defined, and how far a vertex
//    may move in one iteration.
class Floor : public VertexPotential {
 public:
  Floor(double height, double stiffness, double thickness)
      : height_(height), stiffness_(stiffness), thickness_(thickness) {}

  std::string name() const override { return "floor"; }

  double value(double /*mass*/, const Vector3& x) const override {
    const double d = x.y() - height_;
    if (d >= thickness_) return 0.0;
    return -stiffness_ * std::pow(d - thickness_, 2) * std::log(d / thickness_);
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
  double height_, stiffness_, thickness_;  // m, κ in N/m, d̂ in m
};

int main(int argc, char** argv) {
  const double end = argc > 1 ? std::atof(argv[1]) : 2.0;
  const std::string directory = argc > 2 ? argv[2] : "";

  // 2. The derivatives must fit the energy: here at one vertex of 1 kg, 2 mm above the floor. Differences
  //    have steps of 10 nm.
  const Vector mass = Vector::Ones(1);
  const Vector vertex = Vector3(0.0, -0.298, 0.0);
  const TermDerivativeErrors errors =
      check_derivatives(Floor(-0.3, 2.0e5, 5.0e-3), {mass, vertex}, Vector::Zero(3), 1e-8)
          .potential;
  std::printf("relative errors of the derivatives: %.0e and %.0e\n", errors.gradient,
              errors.hessian);
  if (errors.gradient > 1e-6 || errors.hessian > 1e-6) return 1;

  std::printf("%-15s %9s %14s %14s %14s %12s\n", "rule", "steps", "floor, most", "floor, end",
              "energy error", "top at end");
  bool all_well = true;
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
                                Integrator::kBackwardEuler}) {
    // 3. The scene: a block of 20 cm, turning a little, 30 cm above the floor.
    Scene scene;
    scene.material.youngs_modulus = 5.0e4;
    scene.material.poissons_ratio = 0.3;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.time = {rule, is_implicit(rule) ? 5.0e-4 : 1.0e-4, false, end};
    scene.initial.angular_velocity = {0.0, 0.0, 1.0};

    // 4. The term joins the others.
    scene.force_term.push_back(std::make_shared<Floor>(-0.3, 2.0e5, 5.0e-3));

    // 5. The run, with the balance of energy in every step.
    Session session(scene, generate_box({0.2, 0.2, 0.2}, {3, 3, 3}));
    std::unique_ptr<RunRecorder> recorder;
    if (!directory.empty()) {
      recorder = std::make_unique<RunRecorder>(directory + "/" + to_string(rule), 100);
      recorder->on_start(session);
    }
    double most = 0.0;
    while (session.step()) {
      most = std::fmax(most, session.balance().energies().of("floor"));
      if (recorder) recorder->on_step(session);
    }
    if (recorder) recorder->on_finish(session);
    if (session.status() != RunStatus::kFinished) {
      std::printf("%s\n", session.message().c_str());
      all_well = false;
    }
    const Balance& balance = session.balance();
    double highest = 0.0;
    for (Index i = 1; i < session.state().position.size(); i += 3) {
      highest = std::fmax(highest, session.state().position[i]);
    }
    std::printf("%-15s %9lld %12.4f J %12.4f J %12.4f J %10.4f m\n", to_string(rule).c_str(),
                static_cast<long long>(session.state().step), most, balance.energies().of("floor"),
                balance.energy_error(), highest);
  }
  return all_well ? 0 : 1;
}
