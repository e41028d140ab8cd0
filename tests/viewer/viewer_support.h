// What the tests of the viewer's engine share.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/scene_parts.h"
#include "tetraction/core/blas.h"
#include "tetraction/simulation/scene_objects.h"
#include "viewer/history_log.h"
#include "viewer/simulation.h"

namespace tetraction::viewer::testing_support {

using namespace tetraction::testing_support;

/// A body that spins and is held nowhere, paused.
inline std::unique_ptr<Simulation> simulation_of(const Scene& scene) {
  return std::make_unique<Simulation>(scene, mesh_of(scene));
}

/// Waits for what was asked for; a minute is for ever.
inline void settle(const Simulation& simulation) {
  ASSERT_TRUE(simulation.wait_until_idle(60.0));
}

inline void make_steps(Simulation& simulation, int count) {
  for (int i = 0; i < count; ++i) simulation.step();
  settle(simulation);
}

/// These wait for what they do.
inline void undo(Simulation& simulation) {
  simulation.undo();
  settle(simulation);
}
inline void redo(Simulation& simulation) {
  simulation.redo();
  settle(simulation);
}
inline void restart(Simulation& simulation) {
  simulation.restart();
  settle(simulation);
}
inline void go_back(Simulation& simulation) {
  simulation.go_back();
  settle(simulation);
}
inline void release(Simulation& simulation) {
  simulation.release();
  settle(simulation);
}

/// None but what a machine's BLAS is warned of, which is no matter here.
inline void expect_no_notices(Simulation& simulation) {
  for (const Notice& notice : simulation.take_notices()) {
    if (notice.text != blas_warning()) ADD_FAILURE() << notice.text;
  }
}

/// The rows of a scene run from its start to its end, as `tetraction run` does.
inline std::vector<HistoryRow> history_of_run(const Scene& scene, const TetMesh& mesh) {
  Session session(scene, mesh);
  std::vector<HistoryRow> rows{history_row(session)};
  while (session.step()) rows.push_back(history_row(session));
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  return rows;
}

inline void expect_bitwise_equal(const std::vector<HistoryRow>& a,
                                 const std::vector<HistoryRow>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].step, b[i].step);
    ASSERT_EQ(a[i].time, b[i].time) << "row " << i;
    ASSERT_EQ(a[i].kinetic, b[i].kinetic) << "row " << i << ", t = " << a[i].time;
    ASSERT_EQ(a[i].elastic, b[i].elastic) << "row " << i << ", t = " << a[i].time;
    ASSERT_EQ(a[i].environment, b[i].environment) << "row " << i;
    ASSERT_EQ(a[i].external_work, b[i].external_work) << "row " << i;
    ASSERT_EQ(a[i].constraint_work, b[i].constraint_work) << "row " << i;
    ASSERT_EQ(a[i].dissipated_energy, b[i].dissipated_energy) << "row " << i;
    ASSERT_EQ(a[i].edit_work, b[i].edit_work) << "row " << i;
    ASSERT_EQ(a[i].energy_error, b[i].energy_error) << "row " << i;
    ASSERT_EQ(a[i].linear_momentum, b[i].linear_momentum) << "row " << i;
    ASSERT_EQ(a[i].angular_momentum, b[i].angular_momentum) << "row " << i;
    ASSERT_EQ(a[i].probes, b[i].probes) << "row " << i;
    ASSERT_EQ(a[i].iterations, b[i].iterations) << "row " << i;
  }
}

}  // namespace tetraction::viewer::testing_support
