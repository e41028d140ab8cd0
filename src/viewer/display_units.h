// The units in which the window shows numbers. Scenes and everything else have SI units.
#pragma once

#include <string>

#include "simulation/scene/setting_keys.h"

namespace tetraction::viewer {

/// The choice of the user. kPrefixes: SI units, and single values in the picture have a prefix that suits them. The
/// others are consistent systems: m, kg, s; mm, g, ms (N, MPa); and µm, pg, µs (nN, kPa).
enum class UnitSystem { kPrefixes, kMetres, kMillimetres, kMicrometres };

/// For the whole program. Only the thread of the window may use the functions of this file.
void set_unit_system(UnitSystem system);
UnitSystem unit_system();

/// A unit of the present system: `text` is 10^power times the SI unit.
struct DisplayUnit {
  int power = 0;
  std::string text;

  /// From SI to this unit and back. Both give the decimal number with the point moved, so that 12.5 mm are 0.0125 m
  /// and not a neighbouring number.
  double from_si(double value) const;
  double to_si(double value) const;
  /// The same for the numbers of a value of a scene: one, or those of a list.
  Json from_si(const Json& value) const;
  Json to_si(const Json& value) const;
};

/// For a unit of the tables of scene keys and quantities, such as "kg m/s" and "J/m³". Words that are no unit stay.
DisplayUnit display_unit(const std::string& unit);
/// The same with the prefix for numbers up to `size`, if the system has prefixes. Units that begin with "kg", and pure
/// numbers, have none.
DisplayUnit display_unit(const std::string& unit, double size);

/// Such as "0.0125 m" or "12.5 mm", with so many digits.
std::string with_unit(double value, const std::string& unit, int digits = 4);
/// Such as "1.2 MPa", with the prefix for this number.
std::string with_prefix(double value, const std::string& unit);

}  // namespace tetraction::viewer
