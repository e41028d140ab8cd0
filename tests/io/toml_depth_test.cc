#include "io/toml/toml_depth.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

namespace tetraction {
namespace {

std::string repeated(const std::string& part, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += part;
  return text;
}

bool is_deep(const std::string& text) {
  return place_of_deep_nesting(text).has_value();
}

TEST(TomlDepth, TheBoundHoldsForKeysTablesListsAndTheirMixture) {
  const std::size_t most = kDeepestNesting;
  for (const auto& [before, part, after] :
       {std::tuple("", "a.", "a = 1"), std::tuple("", "\"a.b\" . ", "a = 1"),
        std::tuple("", "'a' .", "a = 1"), std::tuple("x = ", "[", "]"),
        std::tuple("x = ", "{ a = ", "1 }")}) {
    EXPECT_FALSE(is_deep(before + repeated(part, most) + after)) << part;
    EXPECT_TRUE(is_deep(before + repeated(part, most + 1) + after)) << part;
  }
  EXPECT_FALSE(is_deep(std::string("[") + repeated("a.", most - 1) + "a]"));
  EXPECT_TRUE(is_deep(std::string("[") + repeated("a.", most) + "a]"));
  EXPECT_TRUE(is_deep(std::string("[[") + repeated("a.", most) + "a]]"));
  // Each short by itself, deep together.
  EXPECT_TRUE(is_deep(std::string("x = ") + repeated("{ a.a.a.a.a.a.a.a = ", most / 8 + 1)));
  EXPECT_TRUE(is_deep(std::string("x = ") + repeated("[ 1, [2, 3], ", most + 1)));
}

TEST(TomlDepth, ManySmallThingsAreNotDeep) {
  EXPECT_FALSE(is_deep(repeated("a.b.c = 1.5\n", 1000)));
  EXPECT_FALSE(is_deep(std::string("x = [") + repeated("[1.5, 2.5, 3.5],\n", 1000) + "]"));
  EXPECT_FALSE(is_deep(repeated("[[a.b]]\nc = { d.e = [1.0] }\r\n", 1000)));
  EXPECT_FALSE(is_deep(std::string("x = { ") + repeated("a.b = 1.5, ", 1000) + "}"));
}

TEST(TomlDepth, StringsAndCommentsDoNotCount) {
  const std::string deep = repeated("[.", 2 * kDeepestNesting);
  EXPECT_FALSE(is_deep("# " + deep));
  EXPECT_FALSE(is_deep("a = \"" + deep + "\" # " + deep + "\nb = 1"));
  EXPECT_FALSE(is_deep("a = \"\\\"" + deep + "\""));
  EXPECT_FALSE(is_deep("a = '\\' # '" + deep));
  EXPECT_FALSE(is_deep("a = \"\"\"\n\"\" " + deep + "\n\\\"\"\"" + deep + "\"\"\"\"\""));
  EXPECT_FALSE(is_deep("a = '''\n' " + deep + "\n''" + deep + "'''"));
  // Behind the end of each of them everything counts again.
  for (const char* before :
       {"a = \"\\\\\"", "a = '\\'", "a = \"\"", "a = ''", "a = \"\"\"x\"\"\"\"\"", "a = '''x'''",
        "# x", "a = \"\"\"\"\"\"", "a = \"x\n"}) {
    EXPECT_TRUE(is_deep(std::string(before) + "\nx = " + deep)) << before;
  }
}

TEST(TomlDepth, WhatIsBrokenIsLeftToTheParser) {
  for (const char* text : {"", "a = \"", "a = '''", "a = \"\\", "]]]]}}}}", "a = \"\"\"\"", "# "}) {
    EXPECT_FALSE(is_deep(text)) << text;
  }
}

TEST(TomlDepth, ThePlaceIsThatOfTheFirstOneTooMany) {
  const auto place =
      place_of_deep_nesting(std::string("a = 1\n\nb = ") + repeated("[", kDeepestNesting + 1));
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->line, 3U);
  EXPECT_EQ(place->column, 5 + kDeepestNesting);
}

}  // namespace
}  // namespace tetraction
