#include "edit_check.h"

#include <cmath>

#include "simulation/scene/setting_keys.h"

namespace tetraction::viewer {
namespace {

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
    check_selection(edit.force.select);
    check_settings(edit.force);
  }
  void operator()(SetFix& edit) const {
    check_selection(edit.fix.select);
    check_settings(edit.fix);
  }
  void operator()(Unfix& edit) const { check_selection(edit.select); }
  void operator()(SetConstraint& edit) const {
    check_selection(edit.constraint.select);
    check_settings(edit.constraint);
  }
  void operator()(RemoveConstraint&) const {}
  void operator()(SetMomentum& edit) const {
    check_selection(edit.momentum.select);
    check_settings(edit.momentum);
  }
  void operator()(ShiftState& edit) const { check_settings(edit.shift); }
};

}  // namespace

void check_edit(Edit& edit) {
  std::visit(Check{}, edit);
}

}  // namespace tetraction::viewer
