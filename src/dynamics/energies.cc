#include "tetraction/dynamics/energies.h"

#include "tetraction/core/error.h"

namespace tetraction {

double Energies::of(std::string_view name) const {
  for (const Entry& entry : entries_) {
    if (entry.name == name) return entry.value;
  }
  throw InputError("There is no energy of the name \"" + std::string(name) + "\".");
}

double Energies::total() const {
  double total = 0.0;
  for (const Entry& entry : entries_) total += entry.value;
  return total;
}

void Energies::set_extra(std::size_t i, const std::string& name, double value) {
  if (entries_.size() <= kFixed + i) entries_.resize(kFixed + i + 1);
  Entry& entry = entries_[kFixed + i];
  if (entry.name != name) entry.name = name;
  entry.value = value;
}

}  // namespace tetraction
