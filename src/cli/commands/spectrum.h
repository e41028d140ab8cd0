// The effect of time steps on the vibrations of a body, for `check`.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {

/// The frequencies of a body, Hz.
struct Spectrum {
  std::optional<double> lowest;  ///< of the elastic modes; empty if it was not computed
  double highest = 0.0;
  Index rigid = 0;             ///< number of rigid modes, if `lowest` was computed
  Index mechanism = 0;         ///< number of modes of mechanisms, likewise
  Index unstable = 0;          ///< number of unstable modes, likewise
  double damping_ratio = 0.0;  ///< of the lowest mode, likewise; 0 without damping
  std::string warning;         ///< that round-off spoils the lowest frequency; empty if not
};

/// The frequencies at rest. The lowest one takes a factorisation of the stiffness matrix. It is
/// computed if this is cheap, and otherwise only if `always`.
Spectrum spectrum_of(const MechanicalSystem& system, const StabilityLimit& limit, bool always);

/// The frequencies, the damping of the lowest one, and up to which one a step resolves the motion.
void print_resolution(const Spectrum& spectrum, Integrator integrator, double step);

/// A table of ωh, period error and algorithmic damping of the lowest and highest modes.
void print_spectrum(const Spectrum& spectrum, double step);
nlohmann::ordered_json spectrum_json(const Spectrum& spectrum, double step);

}  // namespace tetraction
