// The volumetric part U(J) of the materials of a body.
#pragma once

#include "tetraction/material/material_field.h"

namespace tetraction {

/// Whether the energy of a material has a part U(J).
bool has_volumetric_law(const MaterialField& material);
/// The volumetric part of a material. Where parameters vary, its modulus is that of the material's
/// model. Throws InputError for a material that does not satisfy HasVolumetricLaw, such as Saint
/// Venant–Kirchhoff and a custom material.
VolumetricLaw volumetric_law(const MaterialField& material);
/// The modulus of the volumetric part in element e.
double volumetric_modulus(const MaterialField& material, Index e);
/// The material with λ or κ equal to zero. Throws InputError as volumetric_law() does.
MaterialField without_volumetric_part(const MaterialField& material);

}  // namespace tetraction
