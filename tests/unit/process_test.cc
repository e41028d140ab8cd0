#include "tetraction/core/process.h"

#include <gtest/gtest.h>

#include <vector>

namespace tetraction {
namespace {

TEST(PeakMemory, GrowsByWhatIsUsedAndDoesNotFall) {
  constexpr std::int64_t kMebibyte = 1 << 20;
  const std::int64_t before = peak_memory_bytes();
  EXPECT_GT(before, kMebibyte);
  std::int64_t with = 0;
  {
    const std::vector<char> used(static_cast<std::size_t>(256 * kMebibyte), 'x');
    with = peak_memory_bytes();
    EXPECT_EQ(used.back(), 'x');
  }
  EXPECT_GT(with, 250 * kMebibyte);
  EXPECT_LT(with, before + 300 * kMebibyte);
  // The kernel counts pages in lots: give or take one mebibyte.
  EXPECT_GT(peak_memory_bytes(), with - kMebibyte);
}

}  // namespace
}  // namespace tetraction
