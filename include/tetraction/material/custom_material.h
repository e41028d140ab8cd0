// A material of the user's own, of any type that satisfies the concept Material or PlacedMaterial.
#pragma once

#include <Eigen/LU>  // determinant() and inverse(), which most laws use
#include <concepts>
#include <memory>
#include <string>
#include <utility>

#include "tetraction/material/material_concept.h"

namespace tetraction {

/// A Material that also has a name (kName) and small-strain parameters (initial_lame()).
template <class M>
concept SelfDescribingMaterial = (Material<M> || PlacedMaterial<M>)&&requires(const M& m) {
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
///
/// For a PlacedMaterial the functions of F alone throw InputError: ask at(place). Ψ is then measured from its
/// value at rest at the same place, which costs a second evaluation of the energy.
class CustomMaterial {
  struct Base;

 public:
  /// Throws InputError unless the name is not empty, μ > 0, λ > −2μ/3, both are finite, and Ψ is
  /// defined and finite at F = I. For a PlacedMaterial the latter is found out when the body is made.
  template <class M>
  requires(!std::same_as<M, CustomMaterial> && (Material<M> || PlacedMaterial<M>))
      CustomMaterial(M material, std::string name, const LameParameters& initial)
      : CustomMaterial(
            std::make_shared<const Model<M>>(std::move(material), std::move(name), initial)) {}

  /// Takes the name and the parameters from the material itself. Throws as above.
  template <class M>
  requires(!std::same_as<M, CustomMaterial> &&
           SelfDescribingMaterial<M>) explicit CustomMaterial(M material)
      : CustomMaterial(material, std::string(M::kName), material.initial_lame()) {}

  bool admissible(const Matrix3& f) const { return model_->admissible(f, nullptr); }
  double energy_density(const Matrix3& f) const {
    return model_->energy_density(f, nullptr) - energy_at_rest_;
  }
  Matrix3 first_piola(const Matrix3& f) const { return model_->first_piola(f, nullptr); }
  Matrix9 stiffness(const Matrix3& f) const { return model_->stiffness(f, nullptr); }

  /// Whether the material is a PlacedMaterial.
  bool has_places() const { return model_->has_places(); }
  /// A PlacedMaterial at a place, for as long as the CustomMaterial lives.
  class AtPlace {
   public:
    AtPlace(const Base& model, const MaterialPlace& place) : model_(model), place_(place) {}
    bool admissible(const Matrix3& f) const { return model_.admissible(f, &place_); }
    double energy_density(const Matrix3& f) const {
      return model_.energy_density(f, &place_) -
             model_.energy_density(Matrix3::Identity(), &place_);
    }
    Matrix3 first_piola(const Matrix3& f) const { return model_.first_piola(f, &place_); }
    Matrix9 stiffness(const Matrix3& f) const { return model_.stiffness(f, &place_); }
    LameParameters initial_lame() const { return model_.initial; }

   private:
    const Base& model_;
    MaterialPlace place_;
  };
  AtPlace at(const MaterialPlace& place) const { return {*model_, place}; }

  /// Whether the material is a BatchMaterial. The element loops then evaluate whole blocks of elements in
  /// one call.
  bool has_batches() const { return model_->has_batches(); }
  /// Fills the lists of a BatchMaterial.
  void evaluate(const MaterialValues& values) const;
  LameParameters initial_lame() const { return model_->initial; }
  const std::string& name() const { return model_->name; }

 private:
  struct Base {
    Base(std::string own_name, const LameParameters& lame)
        : name(std::move(own_name)), initial(lame) {}
    Base(const Base&) = delete;
    Base& operator=(const Base&) = delete;
    virtual ~Base() = default;
    // The place is null for a material that is the same everywhere.
    virtual bool admissible(const Matrix3& f, const MaterialPlace* place) const = 0;
    virtual double energy_density(const Matrix3& f, const MaterialPlace* place) const = 0;
    virtual Matrix3 first_piola(const Matrix3& f, const MaterialPlace* place) const = 0;
    virtual Matrix9 stiffness(const Matrix3& f, const MaterialPlace* place) const = 0;
    virtual bool has_places() const = 0;
    virtual bool has_batches() const = 0;
    virtual void evaluate(const MaterialValues& values) const = 0;
    [[noreturn]] void refuse_without_place() const;

    std::string name;
    LameParameters initial;
  };

  template <class M>
  struct Model final : Base {
    Model(M own_material, std::string own_name, const LameParameters& lame)
        : Base(std::move(own_name), lame), material(std::move(own_material)) {}
    bool admissible(const Matrix3& f, const MaterialPlace* place) const override {
      return with_law(place, [&](const auto& law) -> bool { return law.admissible(f); });
    }
    double energy_density(const Matrix3& f, const MaterialPlace* place) const override {
      return with_law(place, [&](const auto& law) -> double { return law.energy_density(f); });
    }
    Matrix3 first_piola(const Matrix3& f, const MaterialPlace* place) const override {
      return with_law(place, [&](const auto& law) -> Matrix3 { return law.first_piola(f); });
    }
    Matrix9 stiffness(const Matrix3& f, const MaterialPlace* place) const override {
      return with_law(place, [&](const auto& law) -> Matrix9 { return law.stiffness(f); });
    }
    bool has_places() const override { return PlacedMaterial<M>; }
    bool has_batches() const override { return BatchMaterial<M>; }
    void evaluate([[maybe_unused]] const MaterialValues& values) const override {
      if constexpr (BatchMaterial<M>) material.evaluate(values);
    }
    // Returns body(the law at the place, or everywhere).
    template <class Body>
    auto with_law([[maybe_unused]] const MaterialPlace* place, const Body& body) const {
      if constexpr (PlacedMaterial<M>) {
        if (place == nullptr) this->refuse_without_place();
        return body(material.at(*place));
      } else {
        return body(material);
      }
    }

    M material;
  };

  explicit CustomMaterial(std::shared_ptr<const Base> model);

  std::shared_ptr<const Base> model_;
  double energy_at_rest_ = 0.0;
};

}  // namespace tetraction
