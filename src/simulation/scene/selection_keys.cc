// Keys of selections: select = { … }, [selection.NAME].
#include "sections.h"
#include "setting_values.h"

namespace tetraction {
namespace {

std::string box_conflict(const SelectBox& box) {
  return (box.min.array() > box.max.array()).any()
             ? "must not be below min in any component; exchange them."
             : "";
}

// The selection with one member, such as { nearest = [x, y, z] }.
template <class Part, class T>
class PartValue : public ValueOf<Selection> {
 public:
  explicit PartValue(T Part::*member) : member_(member) {}
  std::string type() const override { return ValueKind<T>::type(); }
  Json json(const void* settings) const override {
    const auto* part = std::get_if<Part>(&of(settings));
    return part != nullptr ? ValueKind<T>::json(part->*member_) : Json();
  }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    ValueKind<T>::read(node, range, refuse, of(settings).emplace<Part>().*member_);
  }

 private:
  T Part::*member_;
};

// The selection with a table of its own, such as { plane = { … } }.
template <class Part>
TableValue<Selection> table_of() {
  return {section_of<Part>, [](const Selection& s) -> const void* { return std::get_if<Part>(&s); },
          [](Selection& s) -> void* { return &s.emplace<Part>(); }};
}

// { surface = true } and the like.
template <class Part>
OwnValue<Selection> flag_of() {
  return {"`true`",
          [](const Selection& s) { return std::holds_alternative<Part>(s) ? Json(true) : Json(); },
          [](const Json& node, const NumberRange& range, const Refusal& refuse, Selection& s) {
            bool chosen = false;
            ValueKind<bool>::read(node, range, refuse, chosen);
            if (!chosen) refuse("can only be true; choose another selection instead.");
            s.emplace<Part>();
          }};
}

// A set of selections, which only the scene reader can read.
class SetValue : public ValueOf<Selection> {
 public:
  explicit SetValue(SetOperation operation) : operation_(operation) {}
  Form form() const override { return Form::kOther; }
  std::string type() const override {
    return operation_ == SetOperation::kNot ? "selection" : "list of selections";
  }
  Json json(const void* settings) const override {
    const auto* set = std::get_if<SelectSet>(&of(settings));
    if (set == nullptr || set->operation != operation_) return {};
    Json parts = Json::array();
    for (const SelectionPart& part : set->of) parts.push_back(selection_json(part.selection));
    return operation_ == SetOperation::kNot ? parts.at(0) : parts;
  }

 private:
  SetOperation operation_;
};

}  // namespace

SceneSection selection_section() {
  using S = Selection;
  return make_section<S>(
      "select",
      {{{.name = "vertices",
         .help = "the vertices with these numbers, as the mesh file counts them; generated meshes "
                 "count from 0"},
        PartValue{&SelectVertices::ids}},
       {{.name = "plane", .help = "those on a plane `{ axis = \"x\", at = 0.0 }`"},
        table_of<SelectPlane>()},
       {{.name = "box",
         .help = "those inside a box `{ min = [x, y, z], max = [x, y, z] }` or on its border"},
        table_of<SelectBox>()},
       {{.name = "sphere",
         .help = "those inside a sphere `{ center = [x, y, z], radius = r }` or on its border"},
        table_of<SelectSphere>()},
       {{.name = "nearest", .unit = "m", .help = "the one that is nearest to the point"},
        PartValue{&SelectNearest::point}},
       {{.name = "group",
         .help = "those of a named group of the mesh file, such as a Gmsh physical group"},
        PartValue{&SelectGroup::name}},
       {{.name = "surface", .help = "those of the boundary"}, flag_of<SelectSurface>()},
       {{.name = "all", .help = "every one"}, flag_of<SelectAll>()},
       {{.name = "faces",
         .help = "those of the boundary's triangles that face in a direction, "
                 "`{ normal = [0, 1, 0], angle = 30 }`"},
        table_of<SelectFaces>()},
       {{.name = "all_of", .help = "those that all of these selections select"},
        SetValue(SetOperation::kAllOf)},
       {{.name = "any_of", .help = "those that one or more of these selections select"},
        SetValue(SetOperation::kAnyOf)},
       {{.name = "not", .help = "those that this selection does not select"},
        SetValue(SetOperation::kNot)}},
      {}, false, SelectNamed{});
}

SceneSection plane_section() {
  using S = SelectPlane;
  return make_section<S>(
      "select.plane",
      {{{.name = "axis",
         .help = "the axis that the plane is normal to",
         .needed = "\"x\", \"y\" or \"z\", the axis that the plane is normal to."},
        Choice<S>{{"x", "y", "z"},
                  [](const S& s) { return std::string(1, static_cast<char>('x' + s.axis)); },
                  [](S& s, const std::string& name) { s.axis = name[0] - 'x'; }}},
       {{.name = "at",
         .unit = "m",
         .help = "the coordinate of the plane along the axis",
         .needed = "the coordinate of the plane along the axis, in m."},
        &S::at},
       {{.name = "tolerance",
         .unit = "m",
         .help = "how far from the plane a vertex may be",
         .range = kNotNegative,
         .absent = "1e-6 of the diagonal of the body's bounding box"},
        &S::tolerance}});
}

SceneSection box_section() {
  using S = SelectBox;
  return make_section<S>("select.box",
                         {{{.name = "min",
                            .unit = "m",
                            .help = "the lower corner",
                            .needed = "the lower corner, [x, y, z] in m."},
                           &S::min},
                          {{.name = "max",
                            .unit = "m",
                            .help = "the upper corner; no component below that of `min`",
                            .needed = "the upper corner, [x, y, z] in m."},
                           &S::max}},
                         {{{"max"}, box_conflict}});
}

SceneSection sphere_section() {
  using S = SelectSphere;
  return make_section<S>("select.sphere", {{{.name = "center",
                                             .unit = "m",
                                             .help = "the centre",
                                             .needed = "the centre, [x, y, z] in m."},
                                            &S::center},
                                           {{.name = "radius",
                                             .unit = "m",
                                             .help = "the radius",
                                             .range = kPositive,
                                             .needed = "the radius in m."},
                                            &S::radius}});
}

SceneSection faces_section() {
  using S = SelectFaces;
  return make_section<S>(
      "select.faces",
      {{{.name = "normal",
         .help = "a direction; any length but zero",
         .needed = "the direction that the triangles face, [nx, ny, nz]."},
        &S::normal},
       {{.name = "angle",
         .unit = "degrees",
         .help = "how far the outward normal of a triangle of the undeformed body may be from it",
         .range = {.least = 0.0, .most = 180.0}},
        &S::angle}},
      {{{"normal"}, [](const S& s) -> std::string {
          return s.normal.isZero(0.0) ? "must not be zero." : "";
        }}});
}

}  // namespace tetraction
