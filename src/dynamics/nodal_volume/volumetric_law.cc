#include "volumetric_law.h"

#include <fmt/format.h>

#include <concepts>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

[[noreturn]] void refuse_material() {
  std::string names;
  for_each_model([&]<class M>() {
    if constexpr (HasVolumetricLaw<M>)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", M::kName);
  });
  throw InputError(fmt::format(
      "mesh.volume = \"nodal\" needs a material whose energy has a volumetric part U(J): "
      "{}. That of Saint Venant–Kirchhoff (stvk) and of a program's own material has none. "
      "Take one of these, or mesh.volume = \"element\".",
      names));
}

template <class M>
VolumetricLaw law_of(const M& material) {
  if constexpr (HasVolumetricLaw<M>) {
    return material.volumetric_law();
  } else {
    refuse_material();
  }
}

}  // namespace

bool has_volumetric_law(const MaterialField& material) {
  return std::visit([]<class M>(const M&) { return HasVolumetricLaw<M>; }, material.model());
}

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
      [&]<class M>(const M& model) -> MaterialField {
        if constexpr (!HasVolumetricLaw<M>) {
          refuse_material();
        } else {
          if (!material.varies()) return model.without_volumetric_part();
          std::vector<IsotropicModel> elements;
          elements.reserve(static_cast<std::size_t>(material.parameters().cols()));
          for (Index e = 0; e < material.parameters().cols(); ++e) {
            elements.emplace_back(material.with_element(
                model, e, [](const auto& own) { return own.without_volumetric_part(); }));
          }
          return MaterialField(elements);
        }
      },
      material.model());
}

}  // namespace tetraction
