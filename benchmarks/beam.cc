#include "beam.h"

#include <utility>

#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction::benchmarks {

BeamSize beam_size(const std::string& name) {
  if (name == "S") return {name, {20, 4, 4}};
  if (name == "M") return {name, {40, 9, 9}};
  if (name == "L") return {name, {76, 18, 18}};
  if (name == "XL") return {name, {152, 36, 36}};
  throw InputError("There is no beam of size \"" + name + "\": take S, M, L or XL.");
}

MaterialModel beam_material(const std::string& name, double youngs_modulus) {
  const LameParameters lame = lame_from_young(youngs_modulus, 0.4);
  if (name == StVenantKirchhoff::kName) return StVenantKirchhoff(lame.mu, lame.lambda);
  if (name == MooneyRivlin::kName) return mooney_rivlin_from_young(youngs_modulus, 0.4, 0.25);
  return NeoHookean(lame.mu, lame.lambda);
}

std::unique_ptr<MechanicalSystem> make_beam(TetMesh mesh, double youngs_modulus) {
  auto beam = std::make_unique<MechanicalSystem>(
      std::move(mesh), beam_material(NeoHookean::kName, youngs_modulus), 1000.0);
  ConstraintList clamp;
  clamp.held.push_back(
      prescribe_at_rest(beam->mesh(), select_vertices(beam->mesh(), SelectPlane{0, 0.0, {}})));
  beam->set_constraints(Constraints(clamp, beam->mesh(), beam->mass()));
  beam->set_environment(Environment::uniform({0.0, -9.81, 0.0}));
  return beam;
}

State bent_state(const MechanicalSystem& beam) {
  NewtonOptions coarse;
  coarse.tolerance = 1e-2;
  const auto stepper = make_backward_euler_stepper(beam, make_newton_minimizer(beam, coarse));
  State state = beam.rest_state();
  for (int k = 0; k < 20; ++k) require(stepper->step(state, 0.01));
  return state;
}

double tip_deflection(const MechanicalSystem& beam, const State& state) {
  const TetMesh& mesh = beam.mesh();
  const std::vector<Index> end = select_vertices(mesh, SelectPlane{0, 4.0, {}});
  double sum = 0.0;
  for (const Index v : end) {
    sum += state.position[3 * v + 1] - mesh.vertices[static_cast<std::size_t>(v)].y();
  }
  return sum / static_cast<double>(end.size());
}

void require(const StepOutcome& outcome) {
  if (!outcome.ok()) throw Error("A step failed. " + outcome.message);
}

void use_threads(int threads) {
  set_thread_count(threads);
}

}  // namespace tetraction::benchmarks
