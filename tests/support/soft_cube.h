// A soft cube for tests of forces with every rule and solver.
#pragma once

#include "corner_scenes.h"

namespace tetraction::testing_support {

/// Of 0.2 m.
inline TetMesh cube_mesh() {
  return generate_box({0.2, 0.2, 0.2}, {2, 2, 2});
}

class SoftCube : public testing::TestWithParam<RuleWithSolver> {
 protected:
  Scene cube(double step, double end) const {
    Scene scene = scene_of(elastic(5e4, 0.3));
    scene.time = {GetParam().integrator, step, false, end};
    scene.solver = GetParam().solver;
    scene.solver.tolerance = 1e-10;
    return scene;
  }
  bool has_second_order() const { return order(GetParam().integrator) == 2; }
};

}  // namespace tetraction::testing_support
