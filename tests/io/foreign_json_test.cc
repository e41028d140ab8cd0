// JSON that anybody may have written: it is read without a crash, and what is no number is none.
#include "io/text/foreign_json.h"

#include <gtest/gtest.h>

#include <string>

#include "core/printable_json.h"

namespace tetraction {
namespace {

std::string nested(int levels) {
  return std::string(static_cast<std::size_t>(levels), '[') +
         std::string(static_cast<std::size_t>(levels), ']');
}

TEST(ForeignJson, DeepTextsAreDiscarded) {
  EXPECT_TRUE(parse_foreign_json(nested(kMostJsonLevels - 1)).is_array());
  for (const int levels : {kMostJsonLevels + 2, 1000000}) {
    EXPECT_TRUE(parse_foreign_json(nested(levels)).is_discarded());
    EXPECT_TRUE(parse_foreign_json("{\"a\": " + nested(levels) + ", \"b\": 1}").is_discarded());
  }
  for (const char* text : {"", "{", "[1", "nan", "\x80", "[1]]", R"({"a": 1, "a": 1})",
                           R"([{"b": {"a": 1, "a": 2}}])"}) {
    EXPECT_TRUE(parse_foreign_json(text).is_discarded()) << text;
  }
}

TEST(ForeignJson, MembersOfAnythingElseAreNull) {
  const auto json = parse_foreign_json(R"({"a": {"b": [1, 2]}, "c": 3})");
  EXPECT_EQ(entry_of(member_of(member_of(json, "a"), "b"), 1), 2);
  EXPECT_TRUE(member_of(json, "d").is_null());
  EXPECT_TRUE(member_of(member_of(json, "c"), "b").is_null());
  EXPECT_TRUE(entry_of(json, 0).is_null());
  EXPECT_TRUE(entry_of(member_of(member_of(json, "a"), "b"), 2).is_null());
  EXPECT_TRUE(member_of(parse_foreign_json("{"), "a").is_null());
}

TEST(ForeignJson, NumbersOutOfRangeAreNone) {
  const auto index = [](const char* text) { return index_or(parse_foreign_json(text), -7); };
  EXPECT_EQ(index("12"), 12);
  EXPECT_EQ(index("-12"), -12);
  EXPECT_EQ(index("9223372036854775807"), 9223372036854775807);
  for (const char* text : {"1e300", "9223372036854775808", "1.5", "\"1\"", "null", "[]", "true"}) {
    EXPECT_EQ(index(text), -7) << text;
  }
  EXPECT_EQ(number_or(parse_foreign_json("1.5"), 0.0), 1.5);
  EXPECT_EQ(number_or(parse_foreign_json("\"1.5\""), 0.0), 0.0);
}

TEST(ForeignJson, PrintableJsonIsTheSameJson) {
  const std::string text = "a\x1b\x7f\xc2\x9b\xe2\x80\xae\xc3\xa4\n";
  const std::string dumped = nlohmann::json(text).dump();
  const std::string safe = printable_json(dumped);
  EXPECT_EQ(safe, "\"a\\u001b\\u007f\\u009b\\u202e\xc3\xa4\\n\"");
  EXPECT_EQ(nlohmann::json::parse(safe).get<std::string>(), text);
}

}  // namespace
}  // namespace tetraction
