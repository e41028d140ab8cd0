// The names and components of what colours the body.
#include "viewer/color_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace tetraction::viewer {
namespace {

ColorField field_of(const std::string& key) {
  const auto found = std::ranges::find(color_fields(), key, &ColorField::key);
  EXPECT_NE(found, color_fields().end()) << key;
  return found == color_fields().end() ? ColorField() : *found;
}

TEST(ColorFields, HaveTheLengthsOfVectorsAndAllComponents) {
  EXPECT_EQ(color_fields().front(), ColorField());
  EXPECT_EQ(field_of("velocity").title(), "Speed");
  EXPECT_EQ(field_of("velocity_y").title(), "Velocity y");
  EXPECT_EQ(field_of("velocity_y").component, 1);
  EXPECT_EQ(field_of("principal_stresses_3").title(), "Principal stresses 3");
  EXPECT_EQ(field_of("cauchy_stress_xz").component, 5);
  EXPECT_FALSE(field_of("velocity").middle().has_value());
  EXPECT_EQ(field_of("velocity_y").middle(), 0.0);
  EXPECT_EQ(field_of("pressure").middle(), 0.0);
  EXPECT_EQ(field_of("jacobian").middle(), 1.0);
  field_of("reaction_force_x");
  std::set<std::string> keys;
  for (const ColorField& field : color_fields()) {
    EXPECT_TRUE(keys.insert(field.key()).second) << field.key();
    EXPECT_EQ(field == nullptr, field.title().empty());
    EXPECT_NE(field.key(), "cauchy_stress") << "a tensor has no length";
  }
}

TEST(ColorFields, ValuesAreLengthsOrComponents) {
  Matrix values(3, 2);
  values << 3.0, 0.0, 4.0, -1.0, 0.0, 0.0;
  EXPECT_EQ(color_values(values, -1), (std::vector<float>{5.0F, 1.0F}));
  EXPECT_EQ(color_values(values, 1), (std::vector<float>{4.0F, -1.0F}));
  const Matrix scalar = Matrix::Constant(1, 1, -2.0);
  EXPECT_EQ(color_values(scalar, -1), std::vector<float>{-2.0F});
}

}  // namespace
}  // namespace tetraction::viewer
