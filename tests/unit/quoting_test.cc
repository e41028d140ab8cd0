#include "core/quoting.h"

#include <gtest/gtest.h>

#include <array>

namespace tetraction {
namespace {

using namespace std::string_literals;

TEST(Quoting, EscapesWhatATerminalWouldObey) {
  EXPECT_EQ(in_quotes("red"), "\"red\"");
  EXPECT_EQ(in_quotes("\x1b[31mred\x07\0end"s), "\"\\x1b[31mred\\x07\\x00end\"");
  EXPECT_EQ(in_quotes("a\nb\tc\rd"), "\"a\\nb\\tc\\rd\"");
  EXPECT_EQ(in_quotes("größe → 5 µm"), "\"größe → 5 µm\"");
  // A control character of two bytes, one that turns the direction of writing, a line separator.
  EXPECT_EQ(in_quotes("\xc2\x9b"), "\"\\xc2\\x9b\"");
  EXPECT_EQ(in_quotes("\u202Eabc\u2028"), "\"\\xe2\\x80\\xaeabc\\xe2\\x80\\xa8\"");
}

TEST(Quoting, EscapesBytesThatAreNoUtf8) {
  // A byte alone, an encoding that is too long, a surrogate, a number too large, an end that is cut.
  for (const char* wrong : {"\xff", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"}) {
    const std::string text = excerpt(wrong);
    EXPECT_EQ(text.size(), 4 * std::string(wrong).size()) << text;
    EXPECT_EQ(text.substr(0, 2), "\\x");
  }
}

TEST(Quoting, CutsAfterEightyCharacters) {
  EXPECT_EQ(excerpt(std::string(80, 'a')), std::string(80, 'a'));
  EXPECT_EQ(excerpt(std::string(1'000'000, 'a')), std::string(80, 'a') + "…");
  std::string umlauts;
  for (int i = 0; i < 100; ++i) umlauts += "ä";
  EXPECT_EQ(excerpt(umlauts), umlauts.substr(0, 160) + "…");
}

TEST(Quoting, PrintableKeepsLinesAndLength) {
  EXPECT_EQ(printable("two\nlines\t\x1b"), "two\nlines\t\\x1b");
  EXPECT_EQ(printable(std::string(10'000, 'x')).size(), 10'000U);
}

TEST(Quoting, LongWordsOfMessagesAreCut) {
  EXPECT_EQ(printable_message("a  b\nc\x1b"), "a  b\nc\\x1b");
  EXPECT_EQ(printable_message("no " + std::string(1'000'000, 'x') + " here"),
            "no " + std::string(80, 'x') + "… here");
  EXPECT_EQ(printable_message(std::string(1000, 'x')).size(), 1000U);
}

TEST(Quoting, ListsAreCut) {
  EXPECT_EQ(quoted_list({"a", "b"}), "\"a\", \"b\"");
  std::vector<std::string_view> names(1000, "n");
  EXPECT_NE(quoted_list(names).find("\"n\" and 980 more"), std::string::npos);
}

}  // namespace
}  // namespace tetraction
