// Keys of [mesh].
#include "sections.h"
#include "setting_values.h"

namespace tetraction {
namespace {

constexpr const char* kLinear = "linear";
constexpr const char* kQuadratic = "quadratic";

// Length of an edge, or lengths along x, y and z.
bool has_edge(const GeneratorSettings& generator) {
  return generator.kind == GeneratorKind::kCube || generator.kind == GeneratorKind::kTetrahedron;
}

std::string needed_size(const GeneratorSettings& generator, const HasKey&) {
  return has_edge(generator) ? "" : "the lengths along x, y, z in m, for instance [4, 1, 1].";
}

std::string needed_cells(const GeneratorSettings& generator, const HasKey&) {
  return has_edge(generator) ? "the number of cells along an edge, for instance 8."
                             : "the numbers of cells along x, y, z, for instance [40, 10, 10].";
}

// Reads one number for all three, or three numbers.
template <class Number, class Three>
void read_edge_or_three(const Json& node, const NumberRange& range, const Refusal& refuse,
                        bool is_edge, Three& three) {
  if (!is_edge) return ValueKind<Three>::read(node, range, refuse, three);
  Number number{};
  ValueKind<Number>::read(node, range, refuse, number);
  for (auto& entry : three) entry = number;
}

std::string mesh_conflict(const MeshSettings& mesh) {
  if (!mesh.file.empty() || mesh.generate) return {};
  return "has no mesh: give file = \"…\" or generate = { kind = \"box\", size = [1, 1, 1], cells = "
         "[4, 4, 4] }.";
}

std::string two_meshes_conflict(const MeshSettings& mesh) {
  if (mesh.file.empty() || !mesh.generate) return {};
  return one_key_too_many("mesh.file", "mesh.generate", ", and a scene has one mesh");
}

std::string volume_conflict(const MeshSettings& mesh) {
  if (!mesh.quadratic || mesh.volume != VolumeRule::kNodal) return {};
  return "= \"nodal\" is for linear tetrahedra, and mesh.element is \"quadratic\": leave one of "
         "the two out. Quadratic tetrahedra do not need it.";
}

std::string scale_conflict(const MeshSettings& mesh) {
  if (!mesh.generate || mesh.scale == 1.0) return {};
  return "multiplies the coordinates of a mesh file, and this mesh is generated: leave it out, and "
         "give mesh.generate the size that the mesh shall have.";
}

std::string length_unit_conflict(const MeshSettings& mesh) {
  if (!mesh.generate || mesh.unit == MeshSettings{}.unit) return {};
  return "is that of the coordinates of a mesh file, and this mesh is generated: leave it out, and "
         "give mesh.generate the size in m.";
}

}  // namespace

std::vector<const char*> length_unit_names() {
  std::vector<const char*> names;
  for (const LengthUnit& unit : length_units()) names.push_back(unit.name);
  return names;
}

SceneSection mesh_section() {
  using S = MeshSettings;
  SceneSection section = make_section<S>(
      "mesh",
      {{{.name = "file",
         .help = "a tetrahedral mesh; a relative path starts at the scene's folder. `.vtu`, "
                 "`.vtk`, `.msh` (Gmsh 1, 2 and 4.1), `.node` or `.ele` (TetGen), `.veg` (Vega)"},
        &S::file,
        {.written = [](const S& s) { return !s.generate; }}},
       {{.name = "generate", .help = "a mesh made on the spot, see below"},
        TableValue<S>{section_of<GeneratorSettings>,
                      [](const S& s) -> const void* { return s.generate ? &*s.generate : nullptr; },
                      [](S& s) -> void* { return &s.generate.emplace(); }},
        {.unit = [](const S&) { return "m"; }}},
       {{.name = "scale",
         .help =
             "multiplies the file's coordinates (0.001 for a mesh in millimetres); for files only",
         .range = kModeratePositive,
         .in_file = Written::kUnlessDefault},
        &S::scale},
       {{.name = "element",
         .help = "four-node or ten-node tetrahedra. A linear mesh gets vertices in the middles of "
                 "its edges ([see below](#quadratic-tetrahedra))",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{{kLinear, kQuadratic},
                  [](const S& s) { return std::string(s.quadratic ? kQuadratic : kLinear); },
                  [](S& s, const std::string& name) { s.quadratic = name == kQuadratic; }}},
       {{.name = "unit",
         .help = "of the file's coordinates, which are then multiplied by `scale`; for files only",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        Choice<S>{length_unit_names(), &S::unit}},
       {{.name = "volume",
         .help = "where the volumetric part of the energy is taken: in each tetrahedron, or with "
                 "averages at the vertices, which do not lock where ν is near ½ ([see "
                 "below](#nearly-incompressible-materials))",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::volume},
       {{.name = "copies",
         .help =
             "`[[mesh.copies]]`: further bodies with the same mesh, [see below](#several-bodies)",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        TablesValue<S, MeshCopySettings>{&S::copies}}},
      {{{"file", "generate"}, two_meshes_conflict},
       {{}, mesh_conflict},
       {{"volume"}, volume_conflict},
       {{"scale"}, scale_conflict},
       {{"unit"}, length_unit_conflict}});
  section.needed =
      "under [mesh], give file = \"…\" or generate = { kind = \"box\", size = [1, 1, 1], cells = "
      "[4, 4, 4] }.";
  return section;
}

SceneSection copy_section() {
  using S = MeshCopySettings;
  return make_section<S>(
      "mesh.copies",
      {{{.name = "at", .unit = "m", .help = "its displacement from the place of the mesh"}, &S::at},
       {{.name = "turn",
         .unit = "degrees",
         .help = "a rotation vector: it is turned about this axis through the middle of the mesh's "
                 "bounding box, by its length, and then displaced",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::turn},
       {{.name = "velocity",
         .unit = "m/s",
         .help = "at the start",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::velocity},
       {{.name = "angular_velocity",
         .unit = "rad/s",
         .help = "at the start, about its centre of mass",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::angular_velocity}});
}

SceneSection generator_section() {
  using S = GeneratorSettings;
  return make_section<S>(
      "mesh.generate",
      {{{.name = "kind",
         .help = "the shape",
         .needed = "\"beam\", \"box\", \"cube\" or \"tetrahedron\"."},
        &S::kind},
       {{.name = "size",
         .unit = "m",
         .help = "of `beam` and `box` the lengths along x, y and z, which must be given; of `cube` "
                 "and `tetrahedron` the length of an edge; above 0",
         .absent = "`1` for an edge"},
        OwnValue<S>{"three numbers or one",
                    [](const S& s) {
                      return has_edge(s) ? Json(s.size.x()) : ValueKind<Vector3>::json(s.size);
                    },
                    [](const Json& node, const NumberRange&, const Refusal& refuse, S& s) {
                      read_edge_or_three<double>(node, kModeratePositive, refuse, has_edge(s),
                                                 s.size);
                    }},
        {.needed = needed_size}},
       {{.name = "cells",
         .help = "of `beam` and `box` the numbers of cells along x, y and z, of `cube` the number "
                 "along each edge; 1 or more",
         .absent = "must be given"},
        OwnValue<S>{"three whole numbers or one",
                    [](const S& s) { return has_edge(s) ? Json(s.cells[0]) : Json(s.cells); },
                    [](const Json& node, const NumberRange&, const Refusal& refuse, S& s) {
                      read_edge_or_three<int>(node, kAtLeastOne, refuse, has_edge(s), s.cells);
                    }},
        {.used = [](const S& s) { return s.kind != GeneratorKind::kTetrahedron; },
         .needed = needed_cells}}},
      {}, true);
}

}  // namespace tetraction
