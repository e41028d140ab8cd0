// The body of all measurements: a beam of 4 × 1 × 1 m, clamped at x = 0, under gravity.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/mesh/generate.h"

namespace tetraction::benchmarks {

constexpr double kSoft = 1e6;   ///< Young's modulus, Pa
constexpr double kStiff = 1e8;  ///< Pa

struct BeamSize {
  std::string name;
  std::array<int, 3> cells;

  TetMesh mesh() const { return generate_box({4.0, 1.0, 1.0}, cells); }
  Index tetrahedra() const { return Index{6} * cells[0] * cells[1] * cells[2]; }
  /// About a twentieth of the stability limit at kSoft, s.
  double explicit_step() const { return 8e-4 / cells[1]; }
};

/// S, M, L or XL. Throws InputError for another name.
BeamSize beam_size(const std::string& name);

/// ν = 0.4; `name` as in a scene.
MaterialModel beam_material(const std::string& name, double youngs_modulus);

/// With clamp and gravity; 1000 kg/m³.
std::unique_ptr<MechanicalSystem> make_beam(TetMesh mesh, double youngs_modulus = kSoft);

/// The beam as it falls: after 20 steps of 0.01 s of backward Euler, solved coarsely.
State bent_state(const MechanicalSystem& beam);

/// Mean displacement of the free end along y, m.
double tip_deflection(const MechanicalSystem& beam, const State& state);

/// Throws Error unless the step went well.
void require(const StepOutcome& outcome);

/// Sets the number of threads of the library's loops. The BLAS uses one, as in the program.
void use_threads(int threads);

}  // namespace tetraction::benchmarks
