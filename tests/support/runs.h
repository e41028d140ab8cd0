// Runs that end as they should, and all that the tests of runs share.
#pragma once

#include <stdexcept>
#include <utility>

#include "support/bodies.h"
#include "support/messages.h"
#include "support/rules.h"
#include "support/scene_parts.h"
#include "tetraction/simulation/session.h"

namespace tetraction::testing_support {

/// A session that has run to its end. It throws if the run fails, which fails the test.
class FinishedRun : public Session {
 public:
  template <class... Options>
  FinishedRun(const Scene& scene, TetMesh mesh, Options... options)
      : Session(scene, std::move(mesh), options...) {
    if (run() != RunStatus::kFinished) throw std::runtime_error("the run failed: " + message());
  }
  explicit FinishedRun(const Scene& scene) : FinishedRun(scene, mesh_of(scene)) {}
};

/// The equilibrium of a scene.
class FinishedEquilibrium : public FinishedRun {
 public:
  FinishedEquilibrium(const Scene& scene, TetMesh mesh)
      : FinishedRun(scene, std::move(mesh), Analysis::kEquilibrium) {}
  explicit FinishedEquilibrium(const Scene& scene) : FinishedEquilibrium(scene, mesh_of(scene)) {}
};

}  // namespace tetraction::testing_support
