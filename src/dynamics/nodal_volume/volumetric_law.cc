#include "volumetric_law.h"

#include <concepts>
#include <variant>
#include <vector>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

template <class M>
VolumetricLaw law_of(const M& material) {
  if constexpr (std::same_as<M, NeoHookean> || std::same_as<M, MooneyRivlin>) {
    return {material.lambda(), material.volumetric() == VolumetricPart::kLogarithmic};
  } else if constexpr (std::same_as<M, Yeoh>) {
    return {material.kappa(), false};
  } else {
    throw InputError(
        "mesh.volume = \"nodal\" needs a material whose energy has a volumetric part U(J): "
        "neo-hookean, mooney-rivlin or yeoh. That of Saint Venant–Kirchhoff (stvk) and of a "
        "program's own material has none. Take one of the three, or mesh.volume = \"element\".");
  }
}

template <class M>
IsotropicModel without_volume(const M& m) {
  if constexpr (std::same_as<M, NeoHookean>) {
    return NeoHookean(m.mu(), 0.0, m.volumetric());
  } else if constexpr (std::same_as<M, MooneyRivlin>) {
    return MooneyRivlin(m.mu1(), m.mu2(), 0.0, m.volumetric());
  } else if constexpr (std::same_as<M, Yeoh>) {
    return Yeoh(m.c10(), m.c20(), m.c30(), 0.0);
  } else {
    law_of(m);  // throws
    throw InputError("");
  }
}

}  // namespace

VolumetricLaw volumetric_law(const MaterialField& material) {
  return std::visit([](const auto& model) { return law_of(model); }, material.model());
}

double volumetric_modulus(const MaterialField& material, Index e) {
  return std::visit(
      [&](const auto& model) {
        return material.with_element(model, e, [](const auto& own) { return law_of(own).modulus; });
      },
      material.model());
}

MaterialField without_volumetric_part(const MaterialField& material) {
  return std::visit(
      [&](const auto& model) -> MaterialField {
        const IsotropicModel reduced = without_volume(model);
        if (!material.varies()) {
          return std::visit([](const auto& m) { return MaterialField(m); }, reduced);
        }
        std::vector<IsotropicModel> elements;
        elements.reserve(static_cast<std::size_t>(material.parameters().cols()));
        for (Index e = 0; e < material.parameters().cols(); ++e) {
          material.with_element(model, e,
                                [&](const auto& own) { elements.push_back(without_volume(own)); });
        }
        return MaterialField(elements);
      },
      material.model());
}

}  // namespace tetraction
