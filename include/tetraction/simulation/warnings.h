// Warnings about scenes and results that are valid but may mislead.
#pragma once

#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A warning for nearly incompressible materials (Poisson's ratio at small strain of kLockingRatio
/// and more), with which linear tetrahedra lock. Empty if the body has none.
std::string locking_warning(const MechanicalSystem& system);

/// A warning for a body with nodal volumes of which a tenth or more is in walls or rods that are one or two
/// tetrahedra thick: there they are too stiff in bending. A tetrahedron is in such a wall if neither it nor
/// one beside it touches a tetrahedron without vertices on the boundary. Empty if the body has none.
std::string thin_wall_warning(const MechanicalSystem& system);

/// A warning for the first material whose energy falls when the strain grows, with the stretch at
/// which this begins. Empty if the body has none.
/// - Yeoh, where ∂Ψ/∂Ī₁ ≤ 0 (Yeoh::unstable_from()), with the stretch λ of incompressible uniaxial
///   tension, Ī₁ = λ² + 2/λ.
/// - Neo-Hooke and Mooney–Rivlin with a negative λ of the volumetric part. Their energy then has no
///   lower bound: for large J with VolumetricPart::kQuadratic, for small J with kLogarithmic. The
///   stretch is that of F = s I at which Ψ is largest. A warning is given if it lies between 0.5
///   and 10.
std::string instability_warning(const MechanicalSystem& system);

/// The highest frequency that a step resolves, Hz. For the variational rules it is 1/(20 h), that
/// is, twenty steps in a period. For backward Euler it is 1/(400 h), at which a vibration loses a
/// tenth of its energy in a period.
double resolved_frequency(Integrator integrator, double time_step);

}  // namespace tetraction
