// The hyperelastic materials of the program, and the variant that holds any material. The notation is
// that of material_concept.h, with C = FᵀF and E = ½(C − I). Every material is stress-free at F = I.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "tetraction/material/custom_material.h"
#include "tetraction/material/gent.h"
#include "tetraction/material/material_concept.h"
#include "tetraction/material/mooney_rivlin.h"
#include "tetraction/material/neo_hookean.h"
#include "tetraction/material/ogden.h"
#include "tetraction/material/st_venant_kirchhoff.h"
#include "tetraction/material/yeoh.h"

namespace tetraction {

/// The materials of the program. Names, scene keys, the fields of the window, tables and tests follow from
/// this list. The formulas of each are in a file of src/material/laws.
using IsotropicModel = std::variant<StVenantKirchhoff, NeoHookean, MooneyRivlin, Yeoh, Ogden, Gent>;

/// The types of a variant and one more.
template <class Variant, class More>
struct Extended;
template <class... M, class More>
struct Extended<std::variant<M...>, More> {
  using Type = std::variant<M..., More>;
};
/// A material that is chosen at run time. The element loops visit the variant once, outside the
/// loop.
using MaterialModel = Extended<IsotropicModel, CustomMaterial>::Type;

/// Calls the template `body` for every type M of IsotropicModel.
template <class Body>
void for_each_model(const Body& body) {
  const auto visit = [&]<class... M>(const std::variant<M...>*) {
    (body.template operator()<M>(), ...);
  };
  visit(static_cast<const IsotropicModel*>(nullptr));
}

/// A material of every model, with usual parameters and these small-strain parameters.
std::vector<MaterialModel> materials_like(const LameParameters& lame);

/// The name of the model in scenes, such as "neo-hookean", or the name of a custom material.
std::string material_name(const MaterialModel& material);

/// Small-strain Lamé parameters of a model, Pa.
LameParameters initial_lame(const MaterialModel& material);

/// μ = E/(2(1+ν)), λ = Eν/((1+ν)(1−2ν)).
/// Throws InputError unless E > 0 and ν in (−1, 0.5); the message says what to do near ν = 0.5.
LameParameters lame_from_young(double youngs_modulus, double poissons_ratio);

/// Mooney–Rivlin with the small-strain response of (E, ν) and μ₂/μ₁ = `ratio` ≥ 0:
/// μ₁ = μ/(1 + ratio), μ₂ = μ − μ₁, and its λ is λ(E, ν) − 2μ₂.
MooneyRivlin mooney_rivlin_from_young(double youngs_modulus, double poissons_ratio, double ratio);

/// Speed of compression waves √((λ + 2μ)/ρ), m/s.
double wave_speed(const LameParameters& lame, double density);

}  // namespace tetraction
