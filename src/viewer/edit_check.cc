#include "edit_check.h"

#include <cmath>

#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

void require(bool holds, const char* message) {
  if (!holds) throw InputError(message);
}

bool positive(double value) {
  return value > 0.0 && std::isfinite(value);
}

bool not_negative(double value) {
  return value >= 0.0 && std::isfinite(value);
}

void check(const Selection& selection) {
  if (const auto* plane = std::get_if<SelectPlane>(&selection)) {
    require(std::isfinite(plane->at), "The place of a plane must be finite, in m.");
    require(not_negative(plane->tolerance.value_or(0.0)),
            "The tolerance of a plane must be 0 m or more.");
  }
  if (const auto* box = std::get_if<SelectBox>(&selection)) {
    require(box->min.allFinite() && box->max.allFinite() &&
                (box->min.array() <= box->max.array()).all(),
            "The corners of a box must be finite, and max must not be below min.");
  }
  if (const auto* sphere = std::get_if<SelectSphere>(&selection)) {
    require(sphere->center.allFinite() && positive(sphere->radius),
            "A sphere needs a finite centre and a radius above 0 m.");
  }
  if (const auto* nearest = std::get_if<SelectNearest>(&selection)) {
    require(nearest->point.allFinite(), "The point must be finite, in m.");
  }
}

struct Check {
  void operator()(SetMaterial&) const {}  // make_material() checks
  void operator()(SetTime& edit) const {
    require(edit.time.automatic || positive(edit.time.step),
            "The step must be above 0 s and finite.");
    require(!edit.time.automatic || !is_implicit(edit.time.integrator),
            "The automatic step is for the integrators explicit and verlet: the implicit ones have "
            "no stability limit to take half of. Give a number of seconds.");
  }
  void operator()(SetSolver&) const {}   // Session checks
  void operator()(SetDamping&) const {}  // MechanicalSystem checks
  void operator()(SetEnvironment& edit) const {
    EnvironmentSettings& environment = edit.environment;
    require(not_negative(environment.strength),
            "The strength of the environment must be 0 or more; turn it with its direction.");
    require(not_negative(environment.softening), "The softening must be 0 m or more.");
    require(environment.direction.allFinite() && !environment.direction.isZero(0.0),
            "The direction of the environment must not be zero; [0, -1, 0] is downward.");
    environment.direction = unit_direction(environment.direction);
  }
  void operator()(SetForce& edit) const {
    check(edit.force.select);
    require(edit.force.vector.allFinite(), "A force must be finite, in N.");
    require(std::isfinite(edit.force.from) && edit.force.until > edit.force.from,
            "A force must end later than it begins.");
  }
  void operator()(SetFix& edit) const {
    const FixSettings& fix = edit.fix;
    check(fix.select);
    require(fix.components[0] || fix.components[1] || fix.components[2],
            "Fix at least one of the components x, y and z.");
    require(fix.target.has_value() + fix.offset.has_value() + !fix.targets.empty() <= 1,
            "Give one of target, offset and targets.");
    bool finite = fix.velocity.allFinite() && fix.target.value_or(Vector3::Zero()).allFinite() &&
                  fix.offset.value_or(Vector3::Zero()).allFinite();
    for (const Vector3& target : fix.targets) finite = finite && target.allFinite();
    require(finite, "Where vertices are fixed to, and the velocity of that, must be finite.");
    require(!fix.is_penalty || positive(fix.penalty),
            "The penalty must be above 0 N/m and finite.");
  }
  void operator()(Unfix& edit) const { check(edit.select); }
  void operator()(SetConstraint& edit) const {
    const ConstraintSettings& constraint = edit.constraint;
    check(constraint.select);
    require(positive(constraint.length.value_or(1.0)), "A distance must be above 0 m and finite.");
    require(constraint.kind != ConstraintKind::kDistance ||
                constraint.vertices[0] != constraint.vertices[1],
            "A distance needs two different vertices.");
    require(constraint.point.value_or(Vector3::Zero()).allFinite() &&
                constraint.direction.allFinite() &&
                constraint.velocity.value_or(Vector3::Zero()).allFinite() &&
                constraint.angular_velocity.value_or(Vector3::Zero()).allFinite(),
            "Points, directions and velocities of a constraint must be finite.");
  }
  void operator()(RemoveConstraint&) const {}
  void operator()(SetMomentum& edit) const {
    check(edit.momentum.select);
    require(edit.momentum.value.allFinite(), "A momentum must be finite, in kg m/s.");
  }
  void operator()(ShiftState&) const {}  // Session checks
};

}  // namespace

void check_edit(Edit& edit) {
  std::visit(Check{}, edit);
}

}  // namespace tetraction::viewer
