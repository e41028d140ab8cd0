#include "parallel_features.h"

#include <fmt/format.h>

#include <variant>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr const char* kTakeForce = "take [[force]]";
constexpr const char* kLeaveObstacle = "leave it out, or take a [[fix]] where the body only rests";
constexpr const char* kTakeFix = "take [[fix]] if vertices are only held or led";

[[noreturn]] void refuse(const std::string& where, const std::string& what,
                         const std::string& remedy) {
  throw InputError(fmt::format(
      "{}{}{} does not work in several processes yet: {}, or run the scene in one process without "
      "mpirun and with solver.engine = \"local\".",
      where, where.empty() ? "" : ": ", what, remedy));
}

void check_time(const TimeSettings& time, const std::string& where) {
  if (needs_root_finder(time.integrator)) {
    refuse(where, fmt::format("time.integrator = \"{}\"", to_string(time.integrator)),
           "take \"midpoint\"");
  }
}

void check_solver_of_parts(const SolverSettings& solver, const std::string& where) {
  if (solver.kind != "newton") {
    refuse(where, fmt::format("solver.kind = \"{}\"", solver.kind), "take \"newton\"");
  }
}

// Checks whether runs in several processes allow the edits of an event.
struct EditCheck {
  const std::string& where;

  void operator()(const SetTime& edit) const { check_time(edit.settings, where); }
  void operator()(const SetSolver& edit) const { check_solver_of_parts(edit.settings, where); }
  void operator()(const SetForce& edit) const {
    if (edit.entry.kind == LoadKind::kPressure) refuse(where, "[[pressure]]", "take [[traction]]");
  }
  void operator()(const SetPull&) const { refuse(where, "[pull]", kTakeForce); }
  void operator()(const SetConstraint&) const { refuse(where, "[[constraint]]", kTakeFix); }
  void operator()(const RemoveConstraint&) const { refuse(where, "[[constraint]]", kTakeFix); }
  void operator()(const SetObstacle&) const { refuse(where, "[[obstacle]]", kLeaveObstacle); }
  void operator()(const RemoveObstacle&) const { refuse(where, "[[obstacle]]", kLeaveObstacle); }
  void operator()(const ShiftState&) const { refuse(where, "a shift of vertices", "leave it out"); }
  template <class Other>
  void operator()(const Other&) const {}
};

}  // namespace

void require_local_engine(const Scene& scene) {
  if (scene.solver.engine == "local") return;
  throw InputError(fmt::format(
      "solver.engine = \"{}\" is for tetraction run: take solver.engine = \"local\" here.",
      scene.solver.engine));
}

void refuse_what_parts_lack(const Scene& scene, Analysis analysis) {
  if (analysis == Analysis::kEquilibrium) refuse("", "an equilibrium", "compute a motion");
  if (scene.initial.is_static) refuse("", "initial.static = true", "leave it out");
  if (scene.mesh.quadratic) refuse("", "mesh.element = \"quadratic\"", "take \"linear\"");
  if (!scene.mesh.copies.empty()) refuse("", "mesh.copies", "merge the meshes in the mesh file");
  if (scene.mesh.volume == VolumeRule::kNodal) {
    refuse("", "mesh.volume = \"nodal\"", "take \"element\"");
  }
  // Before the integrator: no other one helps a scene with contact.
  if (!scene.obstacle.empty()) {
    refuse(scene.obstacle.front().where, "[[obstacle]]", kLeaveObstacle);
  }
  if (scene.contact.between != ContactBetween::kNone) {
    refuse("", "contact.between", "leave it out");
  }
  check_time(scene.time, "");
  check_solver_of_parts(scene.solver, "");
  if (!scene.pressure.empty()) {
    refuse(scene.pressure.front().where, "[[pressure]]", "take [[traction]]");
  }
  if (!scene.pull.vertices.empty()) refuse("", "[pull]", kTakeForce);
  if (!scene.constraint.empty()) {
    refuse(scene.constraint.front().where, "[[constraint]]", kTakeFix);
  }
  if (scene.contact.mass != 1.0) refuse("", "contact.mass", "leave it out");
  if (!scene.force_term.empty()) refuse("", "a force term of a program", "leave it out");
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) std::visit(EditCheck{event.where}, edit);
  }
}

}  // namespace tetraction
