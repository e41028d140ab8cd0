// The same bits for any number of threads, with each instruction set.

#include <algorithm>
#include <string>
#include <vector>

#include "support/corner_scenes.h"
#include "support/instruction_sets.h"
#include "support/same_run.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using namespace testing_support;

// More vertices than a piece of the loops over vertices, in a number that no vector divides.
Scene body(Integrator rule) {
  Scene scene = clamped_beam({4, 1, 1}, {14, 12, 12});
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.damping.viscosity = 5.0;
  scene.initial.angular_velocity = {0.3, 0.2, 0.5};
  const double step = is_implicit(rule) ? 1e-2 : 1e-4;
  scene.time = {rule, step, false, (is_implicit(rule) ? 1.0 : 12.0) * step};
  return scene;
}

class Threads : public testing::TestWithParam<Integrator> {
 protected:
  ~Threads() override { set_thread_count(0); }
};

TEST_P(Threads, RunsAreBitwiseTheSame) {
  const Scene scene = body(GetParam());
  for (const std::int64_t set : testing_support::instruction_sets()) {
    const testing_support::UseInstructionSet use(set);
    State first;
    std::vector<double> balance;
    for (const int threads : {1, 2, 3, 4, 4}) {
      set_thread_count(threads);
      Session session(scene, mesh_of(scene));
      ASSERT_GT(session.system().vertex_count(), 2048);
      ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
      const std::vector<double> sums = testing_support::numbers_of(session.balance().sums());
      if (threads == 1) {
        first = session.state();
        balance = sums;
        continue;
      }
      const std::string where =
          testing_support::instruction_set_name(set) + ", " + std::to_string(threads) + " threads";
      EXPECT_EQ(session.state().position, first.position) << where;
      EXPECT_EQ(session.state().momentum, first.momentum) << where;
      EXPECT_EQ(sums, balance) << where;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, Threads, testing::ValuesIn(all_rules()), name_of_rule);

}  // namespace
}  // namespace tetraction
