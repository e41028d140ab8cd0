#include "edit_check.h"

#include <cmath>

#include "simulation/scene/setting_keys.h"

namespace tetraction::viewer {
namespace {

struct Check {
  void operator()(SetMaterial&) const {}  // make_material() checks the values
  void operator()(SetTime& edit) const {
    TimeSettings time = edit.settings;
    if (std::isinf(time.end)) time.end = TimeSettings{}.end;  // runs in a window have no end
    check_settings(time);
  }
  void operator()(SetEnvironment& edit) const {
    check_settings(edit.settings);
    edit.settings.direction = unit_direction(edit.settings.direction);
  }
  template <class Section>
  void operator()(SetSection<Section>& edit) const {
    check_settings(edit.settings);
  }
  template <class Entry>
  void operator()(SetEntry<Entry>& edit) const {
    check_selection(edit.entry.select);
    check_settings(edit.entry);
  }
  void operator()(Unfix& edit) const { check_selection(edit.select); }
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
