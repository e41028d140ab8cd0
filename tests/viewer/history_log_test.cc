#include "viewer/history_log.h"

#include <gtest/gtest.h>

namespace tetraction::viewer {
namespace {

HistoryRow row_of(Index step) {
  HistoryRow row;
  row.step = step;
  return row;
}

TEST(HistoryLog, GrowsWithinItsCapacity) {
  HistoryLog log(16);
  for (Index step = 0; step < 1000; ++step) {
    log.add(row_of(step));
    ASSERT_LT(log.rows().size(), 16U);
    ASSERT_EQ(log.rows().front().step, 0);
  }
  EXPECT_GE(log.rows().size(), 7U);
  const Index stride = log.rows()[1].step;
  for (std::size_t i = 0; i < log.rows().size(); ++i) {
    EXPECT_EQ(log.rows()[i].step, stride * static_cast<Index>(i));
  }
  EXPECT_GE(log.generation(), 6U);
}

TEST(HistoryLog, GoesBack) {
  HistoryLog log(100);
  for (Index step = 0; step < 10; ++step) log.add(row_of(step));
  log.go_back_to(9);
  EXPECT_EQ(log.generation(), 0U);
  log.go_back_to(4);
  EXPECT_EQ(log.rows().size(), 5U);
  EXPECT_EQ(log.generation(), 1U);
  log.clear();
  EXPECT_TRUE(log.rows().empty());
  EXPECT_EQ(log.generation(), 2U);
}

}  // namespace
}  // namespace tetraction::viewer
