// Keys of [[obstacle]] and [contact].
#include <fmt/format.h>

#include <string>
#include <vector>

#include "sections.h"
#include "setting_values.h"

namespace tetraction {
namespace {

using S = ObstacleSettings;

constexpr NumberRange kAnyEnd{.infinity = true};

template <ObstacleKind... kinds>
bool is_one_of(const S& obstacle) {
  return ((obstacle.kind == kinds) || ...);
}

constexpr auto is_plane = is_one_of<ObstacleKind::kPlane>;
constexpr auto is_sphere = is_one_of<ObstacleKind::kSphere>;
constexpr auto is_cylinder = is_one_of<ObstacleKind::kCylinder>;
constexpr auto is_box = is_one_of<ObstacleKind::kBox>;
constexpr auto is_mesh = is_one_of<ObstacleKind::kMesh>;
constexpr auto has_point = is_one_of<ObstacleKind::kPlane, ObstacleKind::kCylinder>;
constexpr auto is_round = is_one_of<ObstacleKind::kSphere, ObstacleKind::kCylinder>;
constexpr auto has_inside =
    is_one_of<ObstacleKind::kSphere, ObstacleKind::kCylinder, ObstacleKind::kBox>;

std::string zero_normal(const S& obstacle) {
  return is_plane(obstacle) && obstacle.normal.isZero(0.0) ? "must not be zero." : "";
}

std::string zero_axis(const S& obstacle) {
  return is_cylinder(obstacle) && obstacle.axis.isZero(0.0) ? "must not be zero." : "";
}

std::string empty_box(const S& obstacle) {
  if (!is_box(obstacle) || (obstacle.min.array() < obstacle.max.array()).all()) return {};
  return "must be above min in all three directions.";
}

std::string motion_conflict(const S& obstacle) {
  return obstacle.amplitude.empty() || !obstacle.velocity.isZero(0.0) ||
                 !obstacle.angular_velocity.isZero(0.0)
             ? ""
             : "needs `velocity` or `angular_velocity`, which it is the factor of.";
}

std::string end_conflict(const S& obstacle) {
  if (obstacle.until > obstacle.from) return {};
  return fmt::format("does not fit: the obstacle moves from {} s until {} s; until must be later.",
                     obstacle.from, obstacle.until);
}

}  // namespace

SceneSection obstacle_section() {
  return make_section<S>(
      "obstacle",
      {{{.name = "kind",
         .help = "its shape, see below",
         .needed = "\"plane\", \"sphere\", \"cylinder\", \"box\" or \"mesh\"."},
        &S::kind},
       {{.name = "name",
         .help = "by which messages, columns and results refer to it; each name once",
         .needed = "a name, such as \"floor\"."},
        &S::name},
       {{.name = "point",
         .unit = "m",
         .help = "a point of the plane or of the cylinder's axis",
         .needed = "a point of the plane or of the axis, [x, y, z] in m."},
        &S::point,
        has_point},
       {{.name = "normal",
         .help = "of a plane: the direction to the side of the body; any length but zero",
         .needed = "the direction from the plane to the side of the body, such as [0, 1, 0]."},
        &S::normal,
        is_plane},
       {{.name = "center",
         .unit = "m",
         .help = "of a sphere",
         .needed = "the center of the sphere, [x, y, z] in m."},
        &S::center,
        is_sphere},
       {{.name = "axis",
         .help = "of a cylinder, which has no ends; any length but zero",
         .needed = "the direction of the axis, such as [0, 0, 1]."},
        &S::axis,
        is_cylinder},
       {{.name = "radius",
         .unit = "m",
         .help = "of a sphere or cylinder",
         .range = kPositive,
         .needed = "the radius in m."},
        &S::radius,
        is_round},
       {{.name = "min",
         .unit = "m",
         .help = "the lower corner of a box",
         .needed = "the lower corner of the box, [x, y, z] in m."},
        &S::min,
        is_box},
       {{.name = "max",
         .unit = "m",
         .help = "the upper corner of a box",
         .needed = "the upper corner of the box, [x, y, z] in m."},
        &S::max,
        is_box},
       {{.name = "inside", .help = "keeps the body inside the sphere, the cylinder or the box"},
        &S::inside,
        has_inside},
       {{.name = "file",
         .help = "of a mesh: a surface of triangles, whose both sides act; a relative path starts "
                 "at the "
                 "scene's folder. `.stl`, `.obj`, `.vtp`; `.msh`, `.vtu`, `.vtk`: the boundary of "
                 "their "
                 "tetrahedra, or their triangles",
         .needed = "the file of a surface of triangles."},
        &S::file,
        is_mesh},
       {{.name = "unit",
         .help = "of a mesh: of the file's coordinates",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{length_unit_names(), &S::unit},
        {.used = is_mesh}},
       {{.name = "friction",
         .title = "Friction",
         .help = "the coefficient μ of Coulomb friction",
         .range = kNotNegative,
         .usual = 1.0},
        &S::friction},
       {{.name = "slip_speed",
         .unit = "m/s",
         .help = "of implicit steps: the speed below which friction grows from 0 to its full value",
         .range = kPositive,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::slip_speed},
       {{.name = "thickness",
         .unit = "m",
         .help = "the distance d̂ at which contact begins",
         .range = kPositive,
         .absent = "a tenth of the mean edge of the surface"},
        &S::thickness},
       {{.name = "stiffness",
         .unit = "Pa",
         .help = "κ: at the pressure κ the layer is about half as thick as at rest",
         .range = kPositive,
         .absent = "Young's modulus of the softest material"},
        &S::stiffness},
       {{.name = "select",
         .help = "the faces of the body's boundary that may touch it",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        SelectionValue<S>()},
       {{.name = "velocity",
         .unit = "m/s",
         .help = "moves it; it stands at its place at the time 0",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::velocity},
       {{.name = "angular_velocity",
         .unit = "rad/s",
         .help = "turns it about the point `about`, which moves with `velocity`",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::angular_velocity},
       {{.name = "about",
         .unit = "m",
         .help = "a point of the axis about which it turns",
         .absent = "its center or `point`; of a box or a mesh the center of its bounding box"},
        &S::about},
       {{.name = "amplitude",
         .help = "name of an `[[amplitude]]`, the factor of both velocities",
         .absent = "the factor 1"},
        &S::amplitude},
       {{.name = "from",
         .unit = "s",
         .help = "when its motion begins",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::from},
       {{.name = "until",
         .unit = "s",
         .help = "when its motion ends, later than `from`; `inf` for never",
         .range = kAnyEnd,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::until},
       {{.name = "offset",
         .unit = "m",
         .help =
             "a displacement, by which an equilibrium moves it together with the growing loads; in "
             "a motion it stands there from the start",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::offset}},
      {{{"normal"}, zero_normal},
       {{"axis"}, zero_axis},
       {{"min", "max"}, empty_box},
       {{"amplitude"}, motion_conflict},
       {{"from", "until"}, end_conflict}},
      true);
}

SceneSection contact_section() {
  using C = ContactSettings;
  return make_section<C>(
      "contact",
      {{{.name = "between",
         .help = "what of the surface may touch: `\"none\"` of it, different `\"bodies\"`, or "
                 "`\"all\"` of it, so that a body touches itself, too",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &C::between},
       {{.name = "thickness",
         .unit = "m",
         .help = "the distance d̂ at which contact between bodies begins",
         .range = kPositive,
         .absent = "a tenth of the mean edge of the surface, or the smallest gap at rest if it is "
                   "less"},
        &C::thickness},
       {{.name = "stiffness",
         .unit = "Pa",
         .help = "κ between bodies: at the pressure κ the layer is about half as thick as at rest",
         .range = kPositive,
         .absent = "Young's modulus of the softest material"},
        &C::stiffness},
       {{.name = "friction",
         .help = "the coefficient μ of Coulomb friction between bodies",
         .range = kNotNegative,
         .usual = 1.0,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &C::friction},
       {{.name = "slip_speed",
         .unit = "m/s",
         .help = "of implicit steps: the speed below which friction between bodies grows from 0 to "
                 "its full value",
         .range = kPositive,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &C::slip_speed},
       {{.name = "select",
         .help = "the faces of the boundary that may touch each other",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        SelectionValue<C>()},
       {{.name = "mass",
         .title = "Mass on contact",
         .help = "of implicit steps: the share of their mass that the vertices which may "
                 "touch something keep; the rest moves to vertices inside",
         .range = {.least = 0.0, .most = 1.0, .least_itself = false},
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &C::mass}});
}

}  // namespace tetraction
