// Keys of what vertices do: [[fix]], [[constraint]], momenta, shifts; and [[event]].
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sections.h"
#include "setting_values.h"

namespace tetraction {
namespace {

bool is_penalty(const FixSettings& fix) {
  return fix.is_penalty;
}

std::string target_conflict(const FixSettings& fix) {
  if (!fix.target || !fix.offset) return {};
  return one_key_too_many("target", "offset", ", and each says where the vertices are held");
}

std::string amplitude_conflict(const FixSettings& fix) {
  return fix.amplitude.empty() || fix.offset
             ? ""
             : "needs `offset`, the displacement that it is the factor of.";
}

std::string driven_conflict(const ConstraintSettings& constraint) {
  return constraint.amplitude.empty() || constraint.is_driven()
             ? ""
             : "needs `velocity` or `angular_velocity`, which it is the factor of.";
}

std::string about_conflict(const ConstraintSettings& constraint) {
  return constraint.kind != ConstraintKind::kRigid || !constraint.point ||
                 constraint.angular_velocity
             ? ""
             : "needs `angular_velocity`: it is the point about which the handle turns.";
}

std::string targets_conflict(const FixSettings& fix) {
  if (fix.targets.empty()) return {};
  const auto* select = std::get_if<SelectVertices>(&fix.select);
  if (select == nullptr) {
    return "needs select = { vertices = [...] }: it has one place for each of these vertices.";
  }
  if (select->ids.size() != fix.targets.size()) {
    return fmt::format("has {} places for the {} vertices of select: give one for each.",
                       fix.targets.size(), select->ids.size());
  }
  if (fix.target || fix.offset) {
    return "is one key too many: target or offset is given as well, and each says where the "
           "vertices are held. Leave all but one of them out.";
  }
  return {};
}

template <ConstraintKind kind>
bool is_kind(const ConstraintSettings& constraint) {
  return constraint.kind == kind;
}

bool is_guide(const ConstraintSettings& constraint) {
  return constraint.kind == ConstraintKind::kPlane || constraint.kind == ConstraintKind::kLine;
}

bool takes_selection(const ConstraintSettings& constraint) {
  return has_selection(constraint.kind);
}

template <ConstraintKind kind>
std::string zero_direction(const ConstraintSettings& constraint) {
  return constraint.kind == kind && constraint.direction.isZero(0.0) ? "must not be zero." : "";
}

std::string size_conflict(const ShiftSettings& shift, const std::vector<Vector3>& list) {
  if (list.empty() || list.size() == shift.vertices.size()) return {};
  return fmt::format("has {} entries for {} vertices; give one for each.", list.size(),
                     shift.vertices.size());
}

}  // namespace

SceneSection fix_section() {
  using S = FixSettings;
  return make_section<S>(
      "fix",
      {select_key<S>("the vertices"),
       {{.name = "components",
         .help = "the directions that are held, each letter at most once: `\"z\"` keeps vertices "
                 "in a plane"},
        &S::components},
       {{.name = "target",
         .unit = "m",
         .help = "a point to hold them at",
         .absent = "where the vertices are"},
        &S::target},
       {{.name = "offset",
         .unit = "m",
         .help = "a displacement to hold them at; not beside `target`",
         .absent = "`[0, 0, 0]`"},
        &S::offset},
       {{.name = "targets",
         .unit = "m",
         .help = "a place for each vertex of `select = { vertices = [...] }`, in its order; beside "
                 "neither of the two"},
        &S::targets},
       {{.name = "velocity",
         .unit = "m/s",
         .help = "of the target, which is at its place when the run starts (or at the time of the "
                 "event that fixes) and moves on from there",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::velocity},
       {{.name = "mode",
         .help = "whether they are held exactly or, for comparison, by springs with the force "
                 "−2γ(q − target)",
         .in_file = Written::kUnlessDefault},
        Choice<S>{{"exact", "penalty"},
                  [](const S& s) { return std::string(s.is_penalty ? "penalty" : "exact"); },
                  [](S& s, const std::string& name) { s.is_penalty = name == "penalty"; }}},
       {{.name = "penalty",
         .unit = "N/m",
         .help = "γ; must be given with `\"penalty\"`, has no effect with `\"exact\"`",
         .range = kModeratePositive,
         .needed = "gamma of the force -2 gamma (q - target), in N/m.",
         .in_file = Written::kUnlessDefault},
        &S::penalty,
        is_penalty},
       {{.name = "amplitude",
         .help = "name of an `[[amplitude]]`, the factor of `offset`, which then changes in time",
         .absent = "the factor 1"},
        &S::amplitude}},
      {{{"amplitude"}, amplitude_conflict},
       {{"target", "offset"}, target_conflict},
       {{"targets"}, targets_conflict}});
}

SceneSection constraint_section() {
  using S = ConstraintSettings;
  return make_section<S>(
      "constraint",
      {{{.name = "kind",
         .help = "what the constraint keeps, see below",
         .needed = "\"distance\", \"plane\", \"line\" or \"rigid\"."},
        &S::kind},
       select_key<S>("the vertices, of all kinds but `distance`", takes_selection),
       {{.name = "vertices",
         .help = "of `distance`: the two vertices",
         .needed = "the two vertices, [a, b], as the mesh file numbers them."},
        &S::vertices,
        is_kind<ConstraintKind::kDistance>},
       {{.name = "length",
         .unit = "m",
         .help = "of `distance`",
         .range = kPositive,
         .absent = "as it is"},
        &S::length,
        is_kind<ConstraintKind::kDistance>},
       {{.name = "point",
         .unit = "m",
         .help = "of `plane` and `line`: a point of it",
         .absent = "each vertex its own"},
        &S::point,
        is_guide},
       {{.name = "normal",
         .help = "of `plane`: the direction that it is normal to; any length but zero",
         .needed = "the direction that the plane is normal to, [nx, ny, nz]."},
        &S::direction,
        is_kind<ConstraintKind::kPlane>},
       {{.name = "direction",
         .help = "of `line`; any length but zero",
         .needed = "the direction of the line, [dx, dy, dz]."},
        &S::direction,
        is_kind<ConstraintKind::kLine>},
       {{.name = "velocity",
         .unit = "m/s",
         .help = "of `rigid`: drives it, with this velocity of its centre",
         .absent = "free"},
        &S::velocity,
        is_kind<ConstraintKind::kRigid>},
       {{.name = "angular_velocity",
         .unit = "rad/s",
         .help = "of `rigid`: drives it, turning about its centre, or about the point `about`",
         .absent = "free"},
        &S::angular_velocity,
        is_kind<ConstraintKind::kRigid>},
       {{.name = "about",
         .unit = "m",
         .help = "of a turned `rigid`: a point of the axis about which it turns, when it begins to "
                 "turn or its motion changes; the point moves with `velocity`",
         .absent = "the handle's centre, see below"},
        &S::point,
        is_kind<ConstraintKind::kRigid>},
       {{.name = "amplitude",
         .help = "of a driven `rigid`: name of an `[[amplitude]]`, the factor of both velocities",
         .absent = "the factor 1"},
        &S::amplitude,
        is_kind<ConstraintKind::kRigid>}},
      {{{"normal"}, zero_direction<ConstraintKind::kPlane>},
       {{"direction"}, zero_direction<ConstraintKind::kLine>},
       {{"amplitude"}, driven_conflict},
       {{"about"}, about_conflict}},
      true);
}

SceneSection momentum_section() {
  using S = MomentumSettings;
  return make_section<S>(
      "initial.momentum",
      {select_key<S>("the vertices"),
       {{.name = "value",
         .unit = "kg m/s",
         .per = "of each vertex",
         .help = "the momentum of each selected vertex",
         .needed = "the momentum of each selected vertex, [px, py, pz] in kg m/s."},
        &S::value}});
}

SceneSection event_section() {
  using S = EventSettings;
  std::vector<Key<S>> keys{
      {{.name = "at",
        .unit = "s",
        .help = "when it happens. Before 0 or at the end and later: a warning; the former happens "
                "before the first step, the latter never",
        .needed = "the time of the event in s."},
       &S::at},
      {{.name = "set",
        .help = "`{ \"KEY\" = VALUE, … }` with any key of `[material]`, `[[material_region]]`, "
                "`[time]`, `[solver]`, `[damping]`, `[environment]`, `[[fix]]`, `[[constraint]]`, "
                "`[[obstacle]]` and the loads, written as with `--set`: `\"time.step\" = 1e-3`, "
                "`\"force.0.vector\" = [0, 1, 0]`, `\"constraint.0.velocity\" = [0, 0, 0]`"},
       DocumentedValue<S>{"table"}},
      {{.name = "unset",
        .help = "`[\"KEY\", …]`, keys that are taken out again before `set` is read: "
                "`\"material.ratio\"`, `\"fix.0.target\"`"},
       DocumentedValue<S>{"list of texts"}},
      {{.name = "unfix",
        .help = "`{ select = … }` releases vertices from every `[[fix]]`, or with `fix = n` only "
                "from the one with that number"},
       DocumentedValue<S>{"table"}},
      {{.name = "remove_constraint",
        .help = "takes the `[[constraint]]` with that number away; the others keep theirs"},
       DocumentedValue<S>{"whole number"}},
      {{.name = "remove_obstacle",
        .help = "takes the `[[obstacle]]` with that number away; the others keep theirs"},
       DocumentedValue<S>{"whole number"}},
      {{.name = "fix",
        .help = "fixes vertices, with the keys of `[[fix]]`; by default where they are then"},
       DocumentedValue<S>{"table or list of tables"}},
      {{.name = "constraint", .help = "adds a constraint, with the keys of `[[constraint]]`"},
       DocumentedValue<S>{"table or list of tables"}},
      {{.name = "obstacle",
        .help = "adds an obstacle, with the keys of `[[obstacle]]`; it stands there at that time"},
       DocumentedValue<S>{"table or list of tables"}}};
  // A KeyInfo refers to its texts.
  static const std::vector<std::string> helps = [] {
    std::vector<std::string> texts;
    for (const LoadKind kind : values_of<LoadKind>()) {
      std::string load = to_string(kind);
      std::replace(load.begin(), load.end(), '_', ' ');
      texts.push_back(fmt::format("adds a {}, with the keys of `[[{}]]`", load, name_of(kind)));
    }
    return texts;
  }();
  for (const LoadKind kind : values_of<LoadKind>()) {
    keys.push_back({{.name = name_of(kind), .help = helps[static_cast<std::size_t>(kind)].c_str()},
                    DocumentedValue<S>{"table or list of tables"}});
  }
  keys.insert(keys.end(),
              {{{.name = "momentum",
                 .help = "`{ select = …, value = [px, py, pz] }` sets the momentum of every "
                         "selected vertex, in kg m/s"},
                DocumentedValue<S>{"table or list of tables"}},
               {{.name = "shift",
                 .help = "`{ vertices = [a, …], displacement = [[dx, dy, dz], …], impulse = [[jx, "
                         "jy, jz], …] }` moves single vertices (m) and kicks them (N s), one entry "
                         "for each; one of the two lists may be absent"},
                DocumentedValue<S>{"table or list of tables"}}});
  return make_section<S>("event", keys);
}

SceneSection shift_section() {
  using S = ShiftSettings;
  return make_section<S>(
      "shift",
      {{{.name = "vertices",
         .help = "the vertices, as the mesh file numbers them",
         .needed = "the vertices, [a, b, ...], as the mesh file numbers them."},
        &S::vertices},
       {{.name = "displacement", .unit = "m", .help = "what is added to each position"},
        &S::displacement},
       {{.name = "impulse", .unit = "N s", .help = "what is added to each momentum"}, &S::impulse}},
      {{{},
        [](const S& s) -> std::string {
          if (!s.displacement.empty() || !s.impulse.empty()) return {};
          return "does nothing: give displacement or impulse, one entry for each vertex.";
        }},
       {{"displacement"}, [](const S& s) { return size_conflict(s, s.displacement); }},
       {{"impulse"}, [](const S& s) { return size_conflict(s, s.impulse); }}});
}

}  // namespace tetraction
