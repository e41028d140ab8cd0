// The material of a region of the body: the same everywhere, or with parameters that vary from
// element to element.
#pragma once

#include <concepts>
#include <memory>
#include <vector>

#include "tetraction/material/material.h"

namespace tetraction {

/// The least and largest small-strain parameters of a material.
struct LameRange {
  LameParameters least;
  LameParameters most;
  double least_modulus = 0.0;  ///< least λ + 2μ, Pa
  double most_modulus = 0.0;   ///< largest λ + 2μ, Pa
  double most_ratio = 0.0;     ///< largest Poisson's ratio λ/(2(λ + μ))
};

/// A material that is the same in all elements, or one law with parameters of its own in every
/// element. Copies share the parameters, so that copying is cheap.
class MaterialField {
 public:
  /// The same material everywhere.
  template <class M>
  requires(!std::same_as<M, MaterialField> && std::constructible_from<MaterialModel, M>)
      MaterialField(M material)  // NOLINT(google-explicit-constructor)
      : MaterialField(MaterialModel(std::move(material)), nullptr) {}

  /// Element e of the mesh has the material elements[e]. Throws InputError if there are none, or if
  /// not all have the same law, volumetric part and number of terms.
  explicit MaterialField(const std::vector<IsotropicModel>& elements);

  /// Whether the parameters vary.
  bool varies() const { return parameters_ != nullptr; }
  /// The material if it is the same everywhere. Otherwise the law with the mean of each parameter.
  const MaterialModel& model() const { return model_; }
  /// The material of element e.
  MaterialModel at(Index e) const;
  /// The parameters in the order of the material's parameter_values(), one column for each element. Call
  /// it only if they vary.
  const Matrix& parameters() const { return *parameters_; }
  const LameRange& lame_range() const { return range_; }

  /// Calls body(m) with the material of element e, where m is model() as its own type.
  template <class M, class Body>
  decltype(auto) with_element(const M& m, Index e, const Body& body) const {
    if constexpr (!std::same_as<M, CustomMaterial>) {
      if (varies()) return body(with_parameters(m, parameters_->col(e).data()));
    }
    return body(m);
  }

  /// The material m with other parameters, given in the order of parameter_values().
  template <class M>
  static M with_parameters(const M& m, const double* values) {
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      if constexpr (requires { m.with_values(values); }) {
        return m.with_values(values);
      } else if constexpr (M::kHasVolumetricPart) {
        return M(values[i]..., m.volumetric());
      } else {
        return M(values[i]...);
      }
    }
    (std::make_index_sequence<number_count<M>()>());
  }

 private:
  MaterialField(MaterialModel model, std::shared_ptr<const Matrix> parameters);

  MaterialModel model_;
  std::shared_ptr<const Matrix> parameters_;  // null if they do not vary
  LameRange range_;
};

}  // namespace tetraction
