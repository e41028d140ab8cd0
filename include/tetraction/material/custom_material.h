// A material of the user's own, of any type that satisfies the Material concept.
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <utility>

#include "tetraction/material/material_concept.h"

namespace tetraction {

/// A Material that also has a name (kName) and small-strain parameters (initial_lame()).
template <class M>
concept SelfDescribingMaterial = Material<M> && requires(const M& m) {
  { M::kName } -> std::convertible_to<std::string>;
  { m.initial_lame() } -> std::convertible_to<LameParameters>;
};

/// Holds a user's material of any type and calls it through a virtual function. Copies share the
/// material, so that copying is cheap.
///
/// Ψ is measured from its value at rest, Ψ(I), so that a constant in the user's formula has no
/// effect. Ψ should have its minimum at rest, because Ceres (solver/ceres_minimizer.h) takes a
/// square root of the energy.
///
/// The small-strain parameters are used for scales only: the solver's tolerance near round-off, wave
/// speeds in reports, and the energy that counts as round-off. The stability limit is computed from
/// stiffness(). For an anisotropic material give the parameters of the stiffest direction.
class CustomMaterial {
 public:
  /// Throws InputError unless the name is not empty, μ > 0, λ > −2μ/3, both are finite, and Ψ is
  /// defined and finite at F = I.
  template <class M>
  requires(!std::same_as<M, CustomMaterial> && Material<M>)
      CustomMaterial(M material, std::string name, const LameParameters& initial)
      : CustomMaterial(
            std::make_shared<const Model<M>>(std::move(material), std::move(name), initial)) {}

  /// Takes the name and the parameters from the material itself. Throws as above.
  template <class M>
  requires(!std::same_as<M, CustomMaterial> &&
           SelfDescribingMaterial<M>) explicit CustomMaterial(M material)
      : CustomMaterial(material, std::string(M::kName), material.initial_lame()) {}

  bool admissible(const Matrix3& f) const { return model_->admissible(f); }
  double energy_density(const Matrix3& f) const {
    return model_->energy_density(f) - energy_at_rest_;
  }
  Matrix3 first_piola(const Matrix3& f) const { return model_->first_piola(f); }
  Matrix9 stiffness(const Matrix3& f) const { return model_->stiffness(f); }
  /// Whether the material is a BatchMaterial. The element loops then evaluate whole blocks of elements in
  /// one call.
  bool has_batches() const { return model_->has_batches(); }
  /// Fills the lists of a BatchMaterial.
  void evaluate(const MaterialValues& values) const {
    model_->evaluate(values);
    for (double& energy : values.energy) energy -= energy_at_rest_;
  }
  LameParameters initial_lame() const { return model_->initial; }
  const std::string& name() const { return model_->name; }

 private:
  struct Base {
    Base(std::string own_name, const LameParameters& lame)
        : name(std::move(own_name)), initial(lame) {}
    Base(const Base&) = delete;
    Base& operator=(const Base&) = delete;
    virtual ~Base() = default;
    virtual bool admissible(const Matrix3& f) const = 0;
    virtual double energy_density(const Matrix3& f) const = 0;
    virtual Matrix3 first_piola(const Matrix3& f) const = 0;
    virtual Matrix9 stiffness(const Matrix3& f) const = 0;
    virtual bool has_batches() const = 0;
    virtual void evaluate(const MaterialValues& values) const = 0;

    std::string name;
    LameParameters initial;
  };

  template <class M>
  struct Model final : Base {
    Model(M own_material, std::string own_name, const LameParameters& lame)
        : Base(std::move(own_name), lame), material(std::move(own_material)) {}
    bool admissible(const Matrix3& f) const override { return material.admissible(f); }
    double energy_density(const Matrix3& f) const override { return material.energy_density(f); }
    Matrix3 first_piola(const Matrix3& f) const override { return material.first_piola(f); }
    Matrix9 stiffness(const Matrix3& f) const override { return material.stiffness(f); }
    bool has_batches() const override { return BatchMaterial<M>; }
    void evaluate([[maybe_unused]] const MaterialValues& values) const override {
      if constexpr (BatchMaterial<M>) material.evaluate(values);
    }

    M material;
  };

  explicit CustomMaterial(std::shared_ptr<const Base> model);

  std::shared_ptr<const Base> model_;
  double energy_at_rest_ = 0.0;
};

}  // namespace tetraction
