#include "spectrum.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>

#include "cli/console.h"
#include "fem/jointed_pieces.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/steppers/oscillator.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

constexpr double kPeriodError = 0.1;
constexpr double kLoss = 0.1;  // of the amplitude in a period

double omega_h(double frequency, double step) {
  return 2.0 * std::numbers::pi * frequency * step;
}

// ", 6 rigid modes"
std::string modes_text(Index count, const char* kind) {
  if (count == 0) return {};
  return fmt::format(", {} {} mode{}", count, kind, count == 1 ? "" : "s");
}

// The highest frequency that steps resolve, Hz.
double resolved(Integrator rule, double step) {
  return resolved_omega_h(rule, kPeriodError, kLoss) / (2.0 * std::numbers::pi * step);
}

std::string columns(Integrator rule, double frequency, double step) {
  const double x = omega_h(frequency, step);
  const OscillatorResponse response = oscillator_response(rule, x);
  if (!response.is_stable) return fmt::format("{:>10.3g}{:>10}{:>10}", x, "unstable", "");
  return fmt::format("{:>10.3g}{:>8.2g} %{:>10.2g}", x, 100.0 * response.period_error,
                     response.damping_ratio);
}

nlohmann::ordered_json mode_json(Integrator rule, double frequency, double step) {
  const double x = omega_h(frequency, step);
  const OscillatorResponse response = oscillator_response(rule, x);
  nlohmann::ordered_json json{{"frequency", frequency}, {"omega_h", x}};
  json["stable"] = response.is_stable;
  if (!response.is_stable) return json;
  json["period_error"] = response.period_error;
  json["damping_ratio"] = response.damping_ratio;
  json["amplitude_left"] = response.amplitude_left;
  return json;
}

}  // namespace

Spectrum spectrum_of(const MechanicalSystem& system, const StabilityLimit& limit, bool always) {
  constexpr Index kCheap = 20000;  // free coordinates
  Spectrum spectrum;
  spectrum.highest = limit.omega_max / (2.0 * std::numbers::pi);
  const Index size = system.coordinates().count();
  if (size == 0 || (size > kCheap && !always)) return spectrum;
  // Each part has six rigid modes at most, unless it has hinges.
  const auto parts = static_cast<Index>(connected_parts(system.rest()).size());
  for (const Index count : {6 * parts + 1, 6 * parts + 200}) {
    NormalModes modes;
    NormalModeOptions options;
    options.count = count;
    try {
      modes = normal_modes(system, system.mesh().rest_positions(), options);
    } catch (const Error&) {  // the rest of the check does not need them
      if (always) throw;
      return spectrum;
    }
    spectrum.rigid = spectrum.mechanism = spectrum.unstable = 0;
    for (const NormalMode& mode : modes.modes) {
      if (mode.kind == ModeKind::kRigid) ++spectrum.rigid;
      if (mode.kind == ModeKind::kMechanism) ++spectrum.mechanism;
      if (mode.kind == ModeKind::kUnstable) ++spectrum.unstable;
      if (mode.kind != ModeKind::kElastic) continue;
      spectrum.lowest = mode.frequency();
      spectrum.damping_ratio = mode.damping_ratio;
      spectrum.warning = round_off_warning({.modes = {mode}});
      return spectrum;
    }
    if (modes.total <= count) break;
  }
  return spectrum;
}

void print_resolution(const Spectrum& spectrum, Integrator integrator, double step) {
  if (!(spectrum.highest > 0.0)) return;
  std::string text = "frequencies: ";
  if (spectrum.lowest) {
    text += fmt::format("{:.5g} Hz to {:.5g} Hz", *spectrum.lowest, spectrum.highest);
    text += modes_text(spectrum.unstable, "unstable") + modes_text(spectrum.rigid, "rigid") +
            modes_text(spectrum.mechanism, "mechanism");
  } else {
    text +=
        fmt::format("up to {:.5g} Hz (--spectrum computes the lowest one, too)", spectrum.highest);
  }
  if (spectrum.damping_ratio > 0.0) {
    text += fmt::format(
        "\ndamping ratio of the mode at {:.5g} Hz: {:.4g} (tetraction modes prints those of "
        "others)",
        *spectrum.lowest, spectrum.damping_ratio);
  }
  const double most = resolved(integrator, step);
  print_result(
      "{}\n{} with this step resolves {} (period error below {:.0f} %{})\n", text,
      to_string(integrator),
      most > spectrum.highest ? "all motion" : fmt::format("motion up to {:.3g} Hz", most),
      100.0 * kPeriodError,
      is_variational(integrator)
          ? ""
          : fmt::format(", less than {:.0f} % of the amplitude lost in a period", 100.0 * kLoss));
}

void print_spectrum(const Spectrum& spectrum, double step) {
  if (!(spectrum.highest > 0.0)) return;
  const std::string lowest =
      spectrum.lowest ? fmt::format("lowest, {:.5g} Hz", *spectrum.lowest) : "no elastic mode";
  print_result("\nvibrations in steps of {:.6g} s:\n{:<16}{:>30}{:>30}\n", step, "", lowest,
               fmt::format("highest, {:.5g} Hz", spectrum.highest));
  constexpr const char* kColumns = "{:>10}{:>10}{:>10}";
  const std::string names = fmt::format(fmt::runtime(kColumns), "omega h", "period", "damping");
  print_result("{:<16}{}{}{:>16}\n", "integrator", names, names, "resolved up to");
  for (const Integrator rule : all_integrators()) {
    print_result("{:<16}{}{}{:>13.3g} Hz\n", to_string(rule),
                 spectrum.lowest ? columns(rule, *spectrum.lowest, step)
                                 : fmt::format(fmt::runtime(kColumns), "", "", ""),
                 columns(rule, spectrum.highest, step), resolved(rule, step));
  }
  write_result(
      "period: error of the period; damping: algorithmic damping ratio; resolved: period error and "
      "loss of amplitude in a period below 10 %\n");
}

nlohmann::ordered_json spectrum_json(const Spectrum& spectrum, double step) {
  nlohmann::ordered_json json{{"step", step}};
  for (const Integrator rule : all_integrators()) {
    nlohmann::ordered_json row{{"integrator", to_string(rule)}};
    if (spectrum.lowest) row["lowest"] = mode_json(rule, *spectrum.lowest, step);
    if (spectrum.highest > 0.0) row["highest"] = mode_json(rule, spectrum.highest, step);
    row["resolved_up_to"] = resolved(rule, step);
    json["integrators"].push_back(std::move(row));
  }
  return json;
}

}  // namespace tetraction
