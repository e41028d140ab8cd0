// The units in which the window shows numbers.
#include "viewer/display_units.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace tetraction::viewer {
namespace {

class DisplayUnits : public testing::Test {
 protected:
  void TearDown() override { set_unit_system(UnitSystem::kPrefixes); }
};

TEST_F(DisplayUnits, NumbersHavePrefixes) {
  EXPECT_EQ(with_prefix(1.234e6, "Pa"), "1.23 MPa");
  EXPECT_EQ(with_prefix(-25e3, "Pa"), "-25 kPa");
  EXPECT_EQ(with_prefix(0.0125, "m"), "12.5 mm");
  EXPECT_EQ(with_prefix(3.2e-6, "m/s"), "3.2 µm/s");
  EXPECT_EQ(with_prefix(0.0, "N"), "0 N");
  EXPECT_EQ(with_prefix(1500.0, "kg m/s"), "1.5e+03 kg m/s");
  EXPECT_EQ(with_prefix(1.02, ""), "1.02");
  EXPECT_EQ(display_unit("Pa", 1000.0 * (1.0 - 1e-12)).text, "kPa");
  EXPECT_EQ(display_unit("Pa", 1e30).text, "TPa");
  EXPECT_EQ(with_unit(1.234e6, "Pa"), "1.234e+06 Pa") << "fields have no prefixes";
}

TEST_F(DisplayUnits, FixedSystemsHaveNoPrefixes) {
  set_unit_system(UnitSystem::kMetres);
  EXPECT_EQ(with_prefix(1.234e6, "Pa"), "1.23e+06 Pa");
  EXPECT_EQ(with_unit(0.0125, "m"), "0.0125 m");
  set_unit_system(UnitSystem::kMillimetres);
  EXPECT_EQ(with_prefix(1.234e6, "Pa"), "1.23 MPa");
  EXPECT_EQ(with_prefix(1.234e-6, "m"), "0.00123 mm");
}

// Each unit of the tables of keys and quantities, with the power of ten that follows from the powers of its symbols.
TEST_F(DisplayUnits, AreConsistentSystems) {
  struct Case {
    const char* unit;
    DisplayUnit milli, micro;
  };
  const Case cases[] = {
      {"m", {-3, "mm"}, {-6, "µm"}},
      {"kg/m³", {6, "g/mm³"}, {3, "pg/µm³"}},
      {"m/s²", {3, "mm/ms²"}, {6, "µm/µs²"}},
      {"kg m/s", {-3, "g mm/ms"}, {-15, "pg µm/µs"}},
      {"kg m²/s", {-6, "g mm²/ms"}, {-21, "pg µm²/µs"}},
      {"N/m³", {9, "N/mm³"}, {9, "nN/µm³"}},
      {"Pa s", {3, "MPa ms"}, {-3, "kPa µs"}},
      {"J/m³", {6, "mJ/mm³"}, {3, "fJ/µm³"}},
      {"1/s", {3, "1/ms"}, {6, "1/µs"}},
      {"Hz", {3, "kHz"}, {6, "MHz"}},
      {"rad/s", {3, "rad/ms"}, {6, "rad/µs"}},
      {"degrees", {0, "degrees"}, {0, "degrees"}},
      {"", {0, ""}, {0, ""}},
  };
  for (const auto& [unit, milli, micro] : cases) {
    for (const auto& [system, expected] :
         {std::pair{UnitSystem::kMillimetres, milli}, {UnitSystem::kMicrometres, micro}}) {
      set_unit_system(system);
      EXPECT_EQ(display_unit(unit).power, expected.power) << unit;
      EXPECT_EQ(display_unit(unit).text, expected.text) << unit;
    }
  }
  // N = kg m/s² and Pa = J/m³, so that the numbers of an equation fit together in each system.
  for (const UnitSystem system : {UnitSystem::kMillimetres, UnitSystem::kMicrometres}) {
    set_unit_system(system);
    EXPECT_EQ(display_unit("N").power, display_unit("kg m/s²").power);
    EXPECT_EQ(display_unit("Pa").power, display_unit("J/m³").power);
    EXPECT_EQ(display_unit("J").power, display_unit("N m").power);
    EXPECT_EQ(display_unit("W").power, display_unit("J/s").power);
    EXPECT_EQ(display_unit("Hz").power, display_unit("1/s").power);
  }
}

TEST_F(DisplayUnits, MoveTheDecimalPointExactly) {
  set_unit_system(UnitSystem::kMillimetres);
  const DisplayUnit length = display_unit("m");
  const DisplayUnit stress = display_unit("Pa");
  EXPECT_EQ(length.to_si(12.5), 0.0125);
  EXPECT_EQ(length.to_si(5.1), 0.0051);
  EXPECT_NE(5.1 * 1e-3, 0.0051) << "a product would be another number";
  for (int i = 1; i < 2000; ++i) {
    const double x = i / 1000.0;
    EXPECT_EQ(length.to_si(length.from_si(x)), x);
    EXPECT_EQ(stress.to_si(stress.from_si(x)), x);
  }
  EXPECT_EQ(length.from_si(0.0), 0.0);
  EXPECT_EQ(length.from_si(-std::numeric_limits<double>::infinity()),
            -std::numeric_limits<double>::infinity());
  EXPECT_EQ(stress.to_si(1e308), std::numeric_limits<double>::infinity());
  EXPECT_EQ(length.to_si(5e-324), 0.0);
  const Json list = {{0.0125, 1}, {"a", nullptr}};
  EXPECT_EQ(length.from_si(list), (Json{{12.5, 1000.0}, {"a", nullptr}}));
  EXPECT_EQ(length.to_si(length.from_si(list)), list);
}

}  // namespace
}  // namespace tetraction::viewer
