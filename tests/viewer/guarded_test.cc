#include "viewer/guarded.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace tetraction::viewer {
namespace {

struct Counter {
  int value = 0;
};

template <class Owner>
concept GivesItsDataAway = requires(Owner owner) {
  owner.data_;
}
|| requires(Owner owner) {
  owner.value;
}
|| requires(Owner owner) {
  owner->value;
}
|| requires(Owner owner) {
  *owner;
};
// Only the lock leads to the data, and a const owner gives read access only.
static_assert(!GivesItsDataAway<Guarded<Counter>>);
template <class Owner>
concept Writable = requires(Owner owner) {
  owner.lock()->value = 1;
};
static_assert(Writable<Guarded<Counter>>);
static_assert(!Writable<const Guarded<Counter>>);

TEST(Guarded, LockKeepsThreadsApart) {
  Guarded<Counter> counter;
  constexpr int kTimes = 20000;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&counter] {
      for (int j = 0; j < kTimes; ++j) ++counter.lock()->value;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(counter.lock()->value, 4 * kTimes);
}

TEST(Guarded, WaitGivesTheLockUp) {
  Guarded<Counter> counter;
  std::condition_variable changed;
  std::thread other([&] {
    counter.lock()->value = 7;
    changed.notify_one();
  });
  const bool came = counter.lock().wait_for(changed, std::chrono::seconds(60),
                                            [](const Counter& c) { return c.value == 7; });
  other.join();
  EXPECT_TRUE(came);
}

}  // namespace
}  // namespace tetraction::viewer
