//                       Tetraction example: a material of your own
//
// Sample runs:  custom_material               0.2 s
//               custom_material 1.0
//
// Description:  Rubber with stiff fibres in one direction a:
//
//                 Ψ = Ψ_neo-hookean + k₁/(2k₂) (exp(k₂ e²) − 1),   e = I₄ − 1 = |F a|² − 1
//
//               (the fibre term of Holzapfel, Gasser & Ogden 2000, here also under compression). Any
//               class with the four functions of the Material concept will do; CustomMaterial carries
//               it to every place that takes a material. A clamped beam is loaded at its end, with
//               the fibres along and across it, by an explicit and by an implicit rule.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/solver/ceres_minimizer.h"

using namespace tetraction;

// 1. The material: energy density, its derivative by F and the derivative of that. With m = F a aᵀ,
//    de = 2 m : dF, so that
//
//      P = P_nh + 2 k₁ e exp(k₂ e²) m
//      A = A_nh + 4 k₁ (1 + 2 k₂ e²) exp(k₂ e²) vec(m) vec(m)ᵀ + 2 k₁ e exp(k₂ e²) (a aᵀ ⊗ I).
class FibreRubber {
 public:
  static constexpr const char* kName = "fibre-rubber";
  FibreRubber(const LameParameters& lame, double k1, double k2, const Vector3& direction)
      : rubber_(lame.mu, lame.lambda), k1_(k1), k2_(k2), a_(direction.normalized()) {}

  bool admissible(const Matrix3& f) const { return rubber_.admissible(f); }
  double energy_density(const Matrix3& f) const {
    const double e = strain(f);
    return rubber_.energy_density(f) + 0.5 * k1_ / k2_ * std::expm1(k2_ * e * e);
  }
  Matrix3 first_piola(const Matrix3& f) const {
    const double e = strain(f);
    return rubber_.first_piola(f) + 2.0 * k1_ * e * std::exp(k2_ * e * e) * f * a_ * a_.transpose();
  }
  Matrix9 stiffness(const Matrix3& f) const {
    const double e = strain(f);
    const double k = 2.0 * k1_ * std::exp(k2_ * e * e);
    const Vector9 m = flatten(f * a_ * a_.transpose());
    Matrix9 stiffness = rubber_.stiffness(f);
    stiffness += 2.0 * k * (1.0 + 2.0 * k2_ * e * e) * m * m.transpose();
    for (int j = 0; j < 3; ++j) {
      for (int l = 0; l < 3; ++l) {
        stiffness.block<3, 3>(3 * j, 3 * l).diagonal().array() += k * e * a_[j] * a_[l];
      }
    }
    return stiffness;
  }
  // Of the stiffest direction, the fibres': λ + 2μ + 4k₁ against pulling at small strain.
  LameParameters initial_lame() const {
    const LameParameters lame = rubber_.initial_lame();
    return {lame.mu, lame.lambda + 4.0 * k1_};
  }

 private:
  // e, from F − I: of tiny strains, too, all digits count.
  double strain(const Matrix3& f) const {
    const Vector3 d = (f - Matrix3::Identity()) * a_;
    return d.dot(2.0 * a_ + d);
  }

  NeoHookean rubber_;
  double k1_, k2_;  // Pa, 1
  Vector3 a_;
};

int main(int argc, char** argv) {
  // 2. The body, clamped at x = 0, with 200 N on each vertex of the other end.
  const double end = argc > 1 ? std::atof(argv[1]) : 0.2;
  const TetMesh mesh = generate_box({4.0, 1.0, 1.0}, {12, 3, 3});
  const std::vector<Index> tip = select_vertices(mesh, SelectPlane{0, 4.0, {}});
  ConstraintList clamp;
  clamp.held.push_back(prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}})));

  // 3. The same rubber without fibres, and with fibres along and across the beam.
  const LameParameters lame = lame_from_young(1.0e6, 0.4);
  struct Body {
    const char* fibres;
    MaterialModel material;
  };
  const Body bodies[] = {
      {"none", NeoHookean(lame.mu, lame.lambda)},
      {"along", CustomMaterial(FibreRubber(lame, 1.0e6, 5.0, Vector3::UnitX()))},
      {"across", CustomMaterial(FibreRubber(lame, 1.0e6, 5.0, Vector3::UnitY()))}};

  std::printf("%-8s %-10s %10s %16s %14s\n", "fibres", "integrator", "step [s]", "deflection [m]",
              "energy drift");
  double worst = 0.0;
  for (const Body& body : bodies) {
    MechanicalSystem beam(mesh, body.material, 1000.0);
    beam.set_constraints(Constraints(clamp, mesh, beam.mass()));
    beam.add_force({tip, {0.0, -200.0, 0.0}});

    // 4. Are the formulas right? Against finite differences, in a strained state.
    const DerivativeErrors errors = check_derivatives(
        beam.elastic(), strained_state(beam.elastic(), beam.rest_state().position));
    worst = std::fmax(worst, std::fmax(errors.force, errors.stiffness));

    // 5. Verlet at half the stability limit, which knows of the fibres; midpoint at 0.01 s.
    const StabilityLimit limit = stability_limit(beam, beam.rest_state().position);
    for (const bool implicit : {false, true}) {
      const double wanted = implicit ? 0.01 : 0.5 * limit.critical_step;
      const int steps = static_cast<int>(std::ceil(end / wanted));
      const double h = end / steps;
      const auto stepper = implicit ? make_midpoint_stepper(beam, make_ceres_minimizer(beam, {}))
                                    : make_verlet_stepper(beam);
      State state = beam.rest_state();
      Balance balance(beam, state);
      for (int k = 0; k < steps; ++k) {
        const StepOutcome outcome = stepper->step(state, h);
        if (!outcome.ok()) {
          std::fprintf(stderr, "step %d failed: %s\n", k + 1, outcome.message.c_str());
          return 1;
        }
        balance.enter(state, outcome);
      }

      // 6. The mean deflection of the end, and what the integrator added to the energy.
      double deflection = 0.0;
      for (const Index v : tip) {
        deflection += state.position[3 * v + 1] - mesh.vertices[static_cast<std::size_t>(v)].y();
      }
      std::printf("%-8s %-10s %10.3g %16.8f %14.2g\n", body.fibres,
                  implicit ? "midpoint" : "verlet", h, deflection / static_cast<double>(tip.size()),
                  balance.max_relative_energy_drift());
    }
  }
  std::printf("derivatives against differences: largest relative error %.1e\n", worst);
  return 0;
}
