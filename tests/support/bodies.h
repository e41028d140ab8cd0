// Small bodies and helpers that several tests share.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/simulation/scene.h"

namespace tetraction::testing_support {

/// The three models with the same small-strain response (E = 1 MPa, ν = 0.4).
inline std::vector<MaterialModel> all_materials() {
  const LameParameters lame = lame_from_young(1e6, 0.4);
  return {StVenantKirchhoff(lame.mu, lame.lambda), NeoHookean(lame.mu, lame.lambda),
          mooney_rivlin_from_young(1e6, 0.4, 0.5)};
}

/// Moves every DOF by up to `amplitude`, always the same way for a seed.
inline Vector jiggled(const Vector& q, double amplitude, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-amplitude, amplitude);
  Vector result = q;
  for (Index i = 0; i < q.size(); ++i) result[i] += move(random);
  return result;
}

/// A small block of 2 × 1 × 1 m with irregular inner vertices.
inline TetMesh small_block(const std::array<int, 3>& cells = {4, 2, 2}) {
  return generate_box({2, 1, 1}, cells);
}

/// Scene of a free, spinning, stretched neo-Hookean block.
inline Scene spinning_block(Integrator integrator, double step, double end) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {2, 1, 1}, {2, 1, 1}};
  scene.material.youngs_modulus = 1e5;
  scene.material.poissons_ratio = 0.3;
  scene.time = {integrator, step, false, end};
  scene.initial.velocity = {0.3, -0.2, 0.1};
  scene.initial.angular_velocity = {1.0, 2.0, 0.5};
  scene.initial.stretch = {1.1, 0.95, 1.0};
  return scene;
}

/// A value and its gradient; throws if they are not defined at x.
template <class Function>
std::pair<double, Vector> value_and_gradient_of(const Function& function, const Vector& x) {
  std::pair<double, Vector> result;
  if (!function.value_and_gradient(x, result.first, result.second).ok()) {
    throw std::runtime_error("the function is not defined there");
  }
  return result;
}

/// Constraints that hold every component of the selected vertices where they rest.
inline Constraints hold(const TetMesh& mesh, const Selection& selection) {
  const PrescribedVertices held = prescribe_at_rest(mesh, select_vertices(mesh, selection), "hold");
  return Constraints({{held}, {}, {}, {}}, mesh, Vector::Ones(mesh.vertex_count()));
}

}  // namespace tetraction::testing_support
