#include "display_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

namespace tetraction::viewer {
namespace {

UnitSystem chosen_system = UnitSystem::kPrefixes;

// What stands in place of an SI unit in the systems kMillimetres and kMicrometres.
struct Row {
  const char* unit;
  struct {
    const char* text;
    int power;
  } instead[2];
};
constexpr std::array kRows{
    Row{"m", {{"mm", -3}, {"µm", -6}}},  Row{"s", {{"ms", -3}, {"µs", -6}}},
    Row{"kg", {{"g", -3}, {"pg", -15}}}, Row{"N", {{"N", 0}, {"nN", -9}}},
    Row{"Pa", {{"MPa", 6}, {"kPa", 3}}}, Row{"J", {{"mJ", -3}, {"fJ", -15}}},
    Row{"W", {{"W", 0}, {"nW", -9}}},    Row{"Hz", {{"kHz", 3}, {"MHz", 6}}},
};

// x·10^power, with the same decimal digits.
double moved(double x, int power) {
  if (power == 0 || x == 0.0 || !std::isfinite(x)) return x;
  std::array<char, 64> shortest{};
  const auto end =
      std::to_chars(shortest.begin(), shortest.end(), x, std::chars_format::scientific);
  const std::string text(shortest.begin(), end.ptr);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1)) + power;
  const std::string result = fmt::format("{}e{}", text.substr(0, e), exponent);
  double value = 0.0;
  const auto read = std::from_chars(result.data(), result.data() + result.size(), value);
  if (read.ec != std::errc::result_out_of_range) return value;
  return exponent < 0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), x);
}

Json moved(Json value, int power) {
  if (value.is_number() && power != 0) return moved(value.get<double>(), power);
  if (value.is_array()) {
    for (Json& part : value) part = moved(part, power);
  }
  return value;
}

}  // namespace

void set_unit_system(UnitSystem system) {
  chosen_system = system;
}

UnitSystem unit_system() {
  return chosen_system;
}

double DisplayUnit::from_si(double value) const {
  return moved(value, -power);
}

double DisplayUnit::to_si(double value) const {
  return moved(value, power);
}

Json DisplayUnit::from_si(const Json& value) const {
  return moved(value, -power);
}

Json DisplayUnit::to_si(const Json& value) const {
  return moved(value, power);
}

DisplayUnit display_unit(const std::string& unit) {
  if (chosen_system < UnitSystem::kMillimetres) return {0, unit};
  const std::size_t column = chosen_system == UnitSystem::kMillimetres ? 0 : 1;
  DisplayUnit shown;
  int sign = 1;
  for (auto at = unit.begin(); at != unit.end();) {
    const auto end =
        std::find_if_not(at, unit.end(), [](unsigned char c) { return std::isalpha(c); });
    if (end == at) {
      if (*at == '/') sign = -1;
      shown.text += *at++;
      continue;
    }
    const std::string_view symbol(&*at, static_cast<std::size_t>(end - at));
    at = end;
    const std::string_view rest(unit.data() + (end - unit.begin()),
                                static_cast<std::size_t>(unit.end() - end));
    const int exponent = rest.starts_with("²") ? 2 : rest.starts_with("³") ? 3 : 1;
    const auto row =
        std::ranges::find(kRows, symbol, [](const Row& r) { return std::string_view(r.unit); });
    if (row == kRows.end()) {
      shown.text += symbol;
    } else {
      shown.text += row->instead[column].text;
      shown.power += sign * exponent * row->instead[column].power;
    }
  }
  return shown;
}

DisplayUnit display_unit(const std::string& unit, double size) {
  static constexpr std::array kPrefixes{"n", "µ", "m", "", "k", "M", "G", "T"};
  constexpr int kNone = 3;
  if (chosen_system != UnitSystem::kPrefixes) return display_unit(unit);
  if (unit.empty() || unit.starts_with("kg") || !(size > 0.0) || !std::isfinite(size)) {
    return {0, unit};
  }
  // The slack is for round-off: 1000 × (1 − 1e-12) is written as 1 k.
  const int power = static_cast<int>(std::floor(std::log10(size * (1.0 + 1e-9)) / 3.0));
  const int place = std::clamp(power + kNone, 0, static_cast<int>(kPrefixes.size()) - 1);
  return {3 * (place - kNone), kPrefixes[static_cast<std::size_t>(place)] + unit};
}

std::string with_unit(double value, const std::string& unit, int digits) {
  const DisplayUnit shown = display_unit(unit);
  const std::string number = fmt::format("{:.{}g}", shown.from_si(value), digits);
  return unit.empty() ? number : number + " " + shown.text;
}

std::string with_prefix(double value, const std::string& unit) {
  const DisplayUnit shown = display_unit(unit, std::abs(value));
  const std::string number = fmt::format("{:.3g}", shown.from_si(value));
  return unit.empty() ? number : number + " " + shown.text;
}

}  // namespace tetraction::viewer
