// The energies of a state, by name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tetraction {

/// Energies of a state, J: kinetic T = ½ pᵀM⁻¹p, elastic Σ V Ψ, that of the environment, and that
/// of every other force term whose energy is stored (EnergyAccount::kStored), in the order of the
/// terms.
class Energies {
 public:
  struct Entry {
    std::string name;
    double value = 0.0;
  };

  Energies() : entries_{{"kinetic", 0.0}, {"elastic", 0.0}, {"environment", 0.0}} {}

  double kinetic() const { return entries_[kKinetic].value; }
  double elastic() const { return entries_[kElastic].value; }
  double environment() const { return entries_[kEnvironment].value; }
  /// The energy of that name; throws InputError where there is none.
  double of(std::string_view name) const;
  double total() const;

  const std::vector<Entry>& entries() const { return entries_; }
  /// The number of entries after the first three, which every body has.
  std::size_t extra_count() const { return entries_.size() - kFixed; }
  const Entry& extra(std::size_t i) const { return entries_[kFixed + i]; }

  void set_kinetic(double value) { entries_[kKinetic].value = value; }
  void set_elastic(double value) { entries_[kElastic].value = value; }
  void set_environment(double value) { entries_[kEnvironment].value = value; }
  /// Sets the name and the value of entry i after the first three.
  void set_extra(std::size_t i, const std::string& name, double value);

 private:
  static constexpr std::size_t kKinetic = 0;
  static constexpr std::size_t kElastic = 1;
  static constexpr std::size_t kEnvironment = 2;
  static constexpr std::size_t kFixed = 3;

  std::vector<Entry> entries_;
};

}  // namespace tetraction
