#include "edit_check.h"

#include <cmath>
#include <type_traits>

#include "tetraction/core/error.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction::viewer {
namespace {

void check(const Selection& selection) {
  const auto check_kind = [](const auto& kind) {
    using Kind = std::decay_t<decltype(kind)>;
    if constexpr (std::is_same_v<Kind, SelectPlane> || std::is_same_v<Kind, SelectBox> ||
                  std::is_same_v<Kind, SelectSphere> || std::is_same_v<Kind, SelectFaces>) {
      check_settings(kind);
    }
    if constexpr (std::is_same_v<Kind, SelectSet> || std::is_same_v<Kind, SelectNamed>) {
      for (const SelectionPart& part : kind.of) check(part.selection);
    }
  };
  std::visit(check_kind, selection);
  const auto* nearest = std::get_if<SelectNearest>(&selection);
  if (nearest != nullptr && !nearest->point.allFinite()) {
    throw InputError("The point of a selection must be finite, in m.");
  }
}

struct Check {
  void operator()(SetMaterial&) const {}  // make_material() checks the values
  void operator()(SetTime& edit) const {
    TimeSettings time = edit.time;
    if (std::isinf(time.end)) time.end = TimeSettings{}.end;  // runs in a window have no end
    check_settings(time);
  }
  void operator()(SetSolver& edit) const { check_settings(edit.solver); }
  void operator()(SetDamping& edit) const { check_settings(edit.damping); }
  void operator()(SetEnvironment& edit) const {
    check_settings(edit.environment);
    edit.environment.direction = unit_direction(edit.environment.direction);
  }
  void operator()(SetForce& edit) const {
    check(edit.force.select);
    visit_load(edit.force, [](const auto& load) { check_settings(load); });
  }
  void operator()(SetFix& edit) const {
    check(edit.fix.select);
    check_settings(edit.fix);
  }
  void operator()(Unfix& edit) const { check(edit.select); }
  void operator()(SetConstraint& edit) const {
    check(edit.constraint.select);
    check_settings(edit.constraint);
  }
  void operator()(RemoveConstraint&) const {}
  void operator()(SetMomentum& edit) const {
    check(edit.momentum.select);
    check_settings(edit.momentum);
  }
  void operator()(ShiftState& edit) const { check_settings(edit.shift); }
};

}  // namespace

void check_edit(Edit& edit) {
  std::visit(Check{}, edit);
}

}  // namespace tetraction::viewer
