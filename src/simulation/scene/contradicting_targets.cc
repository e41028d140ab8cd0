// Events that prescribe two targets for a vertex.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "body_constraints.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

class Targets {
 public:
  Targets(const Scene& scene, const MechanicalSystem& system) : scene_(scene), system_(system) {
    for (const FixSettings& fix : scene.fix) fixes_.push_back(of(fix));
    for (const ConstraintSettings& constraint : scene.constraint) others_.push_back(of(constraint));
  }

  void make(const Edit& edit) {
    if (const auto* set = std::get_if<SetFix>(&edit)) {
      const std::size_t number = set->index.value_or(fixes_.size());
      if (number > fixes_.size()) return;  // the edit is refused
      if (number == fixes_.size()) fixes_.emplace_back();
      fixes_[number] = set->index ? changed(fixes_[number], of(set->entry)) : of(set->entry);
      refuse(number);
      for (const Other& other : others_) {
        if (other.is_handle) refuse_shared(set->entry.where, fixes_[number].held, other);
      }
    } else if (const auto* other = std::get_if<SetConstraint>(&edit)) {
      const std::size_t number = other->index.value_or(others_.size());
      if (number > others_.size()) return;
      if (number == others_.size()) others_.emplace_back();
      others_[number] = of(other->entry);
      refuse_other(number);
    } else if (const auto* removed = std::get_if<RemoveConstraint>(&edit)) {
      if (removed->index < others_.size()) others_[removed->index] = Other{};
    } else if (const auto* release = std::get_if<Unfix>(&edit)) {
      const std::vector<Index> released =
          select_at(system_.mesh(), release->select, release->where);
      for (std::size_t number = 0; number < fixes_.size(); ++number) {
        if (release->fix && *release->fix != number) continue;
        for (const Index v : released) {
          fixes_[number].targets.erase(v);
          fixes_[number].vertices.erase(v);
          fixes_[number].held.erase(v);
        }
      }
    }
  }

 private:
  struct Fix {
    std::map<Index, Vector3> targets;  // empty if they are not known before the run
    std::set<Index> vertices;          // empty if it is not known which velocity they have
    std::set<Index> held;              // all that it holds, not by springs
    FixSettings settings;
    Vector3 velocity = Vector3::Zero();
    std::array<bool, 3> components{};
    std::string where;
  };

  // A [[constraint]] that is no distance.
  struct Other {
    std::set<Index> vertices;
    bool is_handle = false;  // a free one
    std::string where;
  };

  Other of(const ConstraintSettings& constraint) const {
    Other result;
    result.where = constraint.where;
    const ConstraintObject object = make_constraint(
        constraint, system_, system_.mesh().rest_positions(), 0.0, scene_.amplitude);
    result.is_handle = std::holds_alternative<RigidHandle>(object);
    if (std::holds_alternative<FixedDistance>(object)) return result;
    for (const Index v : select_at(system_.mesh(), constraint.select, constraint.where)) {
      result.vertices.insert(v);
    }
    return result;
  }

  Fix of(const FixSettings& fix) const {
    Fix result;
    result.settings = fix;
    result.components = fix.components;
    result.where = fix.where;
    const PrescribedVertices held =
        make_held(fix, system_.mesh(), system_.mesh().rest_positions(), 0.0, scene_.amplitude);
    if (fix.is_penalty) return result;
    result.held.insert(held.vertices.begin(), held.vertices.end());
    if (!fix.amplitude.empty()) return result;
    result.vertices.insert(held.vertices.begin(), held.vertices.end());
    result.velocity = fix.velocity;
    const bool is_known = fix.target.has_value() || !fix.targets.empty();
    if (!is_known || !fix.velocity.isZero(0.0)) return result;
    for (std::size_t i = 0; i < held.vertices.size(); ++i) {
      result.targets[held.vertices[i]] = held.start.col(static_cast<Index>(i));
    }
    return result;
  }

  // Its targets and velocities may be those of before, so that they are not known.
  static Fix changed(const Fix& before, Fix after) {
    const bool goes_on = !before.held.empty() && keeps_place(before.settings, after.settings);
    Fix result;
    if (!after.settings.is_penalty) result.held = goes_on ? before.held : std::move(after.held);
    result.settings = std::move(after.settings);
    result.where = std::move(after.where);
    return result;
  }

  // Targets of different velocities meet at one moment at most.
  void refuse_velocities(const Fix& fix, const Fix& other) const {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto i = static_cast<Index>(c);
      if (!fix.components[c] || !other.components[c] || fix.velocity[i] == other.velocity[i]) {
        continue;
      }
      for (const Index v : fix.vertices) {
        if (other.vertices.count(v) > 0) {
          throw InputError(fmt::format(
              "{}: vertex {} is fixed twice at that time, with different velocities (also by {}). "
              "Release it first with unfix, or let only one of them select it.",
              fix.where, system_.mesh().vertex_id(v), other.where));
        }
      }
    }
  }

  void refuse(std::size_t number) const {
    constexpr double kSame = 1e-9;  // of the coordinates
    const double size = system_.mesh().rest_positions().cwiseAbs().maxCoeff();
    const Fix& fix = fixes_[number];
    for (std::size_t other = 0; other < fixes_.size(); ++other) {
      if (other == number) continue;
      refuse_velocities(fix, fixes_[other]);
      for (const auto& [v, target] : fix.targets) {
        const auto found = fixes_[other].targets.find(v);
        if (found == fixes_[other].targets.end()) continue;
        for (Index i = 0; i < 3; ++i) {
          const auto c = static_cast<std::size_t>(i);
          if (!fix.components[c] || !fixes_[other].components[c]) continue;
          if (std::abs(target[i] - found->second[i]) <= kSame * size) continue;
          throw InputError(
              fmt::format("{}: vertex {} is fixed twice at that time, to different targets (also "
                          "by {}). Release it first with unfix, or let only one of them select it.",
                          fix.where, system_.mesh().vertex_id(v), fixes_[other].where));
        }
      }
    }
  }

  void refuse_shared(const std::string& where, const std::set<Index>& vertices,
                     const Other& other) const {
    for (const Index v : vertices) {
      if (other.vertices.count(v) == 0) continue;
      throw InputError(
          fmt::format("{}: vertex {} is held or guided already at that time, by {}. The vertices "
                      "of a rigid handle cannot be constrained in another way: release them first "
                      "with unfix or remove_constraint, or let only one of them select it.",
                      where, system_.mesh().vertex_id(v), other.where));
    }
  }

  void refuse_other(std::size_t number) const {
    const Other& made = others_[number];
    for (std::size_t i = 0; i < others_.size(); ++i) {
      if (i == number || !(made.is_handle || others_[i].is_handle)) continue;
      refuse_shared(made.where, made.vertices, others_[i]);
    }
    if (!made.is_handle) return;
    for (const Fix& fix : fixes_)
      refuse_shared(made.where, made.vertices, {fix.held, false, fix.where});
  }

  const Scene& scene_;
  const MechanicalSystem& system_;
  std::vector<Fix> fixes_;
  std::vector<Other> others_;
};

}  // namespace

void refuse_contradicting_targets(const Scene& scene, const MechanicalSystem& system) {
  Targets targets(scene, system);
  const bool end_may_change = std::ranges::any_of(scene.event, [](const EventSettings& event) {
    return std::ranges::any_of(
        event.edits, [](const Edit& edit) { return std::holds_alternative<SetTime>(edit); });
  });
  for (const EventSettings& event : scene.event) {
    if (event.at >= scene.time.end && !end_may_change) continue;  // it never happens
    for (const Edit& edit : event.edits) targets.make(edit);
  }
}

}  // namespace tetraction
