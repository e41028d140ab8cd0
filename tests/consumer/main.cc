// The program of a user of the library: a session with a material of his own, and the parts.
#include <cstdio>
#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/study.h"

#ifndef __OPTIMIZE__
#error \
    "a material of one's own is compiled here: without optimisation it takes 50 to 110 times as long"
#endif
static_assert(__cplusplus >= 202002L, "the headers need C++20");

int main() {
  using namespace tetraction;
  struct Rubber {
    NeoHookean inner{3.6e5, 1.4e6};
    // The function is in Eigen/LU, which custom_material.h includes.
    bool admissible(const Matrix3& f) const { return f.determinant() > 0.0; }
    double energy_density(const Matrix3& f) const { return inner.energy_density(f); }
    Matrix3 first_piola(const Matrix3& f) const { return inner.first_piola(f); }
    Matrix9 stiffness(const Matrix3& f) const { return inner.stiffness(f); }
  };
  Scene scene;
  scene.material.custom = CustomMaterial(Rubber{}, "rubber", {3.6e5, 1.4e6});
  scene.time = {Integrator::kVerlet, 1e-4, false, 1e-2};
  Session session(scene, generate_box({4, 1, 1}, {8, 2, 2}));
  for (int step = 0; step < 10; ++step) {
    session.step();
  }
  const Checkpoint checkpoint = session.checkpoint();
  while (session.step()) {
  }
  session.restore(checkpoint);
  while (session.step()) {
  }
  std::puts(to_string(session.status()).c_str());
}
