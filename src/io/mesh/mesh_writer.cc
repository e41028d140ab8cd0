#include "tetraction/io/mesh_writer.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "io/gmsh/gmsh_writer.h"
#include "io/text/output_file.h"
#include "io/vtk/quiet_vtk.h"
#include "io/vtk/vtk_grid.h"
#include "io/vtk/vtk_header.h"
#include "mesh_files.h"
#include "mesh_text.h"
#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

// Whether VTK files of this program have another array of this name.
bool is_taken(const std::string& name, bool of_cells) {
  return name == (of_cells ? "element_id" : "vertex_id") || (of_cells && name == "region") ||
         name.starts_with("vtkGhost");
}

vtkSmartPointer<vtkUnstructuredGrid> grid_with_data(const TetMesh& mesh) {
  auto grid = make_grid(mesh);
  Matrix regions(1, mesh.tetrahedron_count());
  for (Index e = 0; e < regions.cols(); ++e) {
    regions(0, e) = mesh.region(e);
  }
  grid->GetCellData()->AddArray(make_array("region", regions, true));
  for (const auto& [name, values] : mesh.point_arrays) {
    if (is_taken(name, false)) continue;
    grid->GetPointData()->AddArray(make_array(name, values, false));
  }
  for (const auto& [name, values] : mesh.cell_arrays) {
    if (is_taken(name, true)) continue;
    grid->GetCellData()->AddArray(make_array(name, values, false));
  }
  return grid;
}

// Binary: text would cost digits.
void write_legacy(const TetMesh& mesh, const std::string& path) {
  VtkMessages messages;
  vtkNew<vtkUnstructuredGridWriter> writer;
  messages.watch(writer);
  writer->SetInputData(grid_with_data(mesh));
  writer->SetFileTypeToBinary();
  writer->SetFileVersion(vtkUnstructuredGridWriter::VTK_LEGACY_READER_VERSION_4_2);
  writer->SetHeader(kOwnLegacyTitle);
  writer->WriteToOutputStringOn();
  if (writer->Write() != 1 || !messages.empty()) {
    throw OutputError(path + ": VTK cannot write it: " + messages.first());
  }
  write_text_file(path, writer->GetOutputStdString());
}

std::map<int, std::vector<Index>> tetrahedra_by_region(const TetMesh& mesh) {
  std::map<int, std::vector<Index>> regions;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) regions[mesh.region(e)].push_back(e);
  return regions;
}

// TetGen needs consecutive numbers: from 0 if the file's are so, otherwise from 1.
void write_tetgen(const TetMesh& mesh, const std::string& path) {
  const std::filesystem::path base(path);
  const std::string faces = std::filesystem::path(base).replace_extension(".face").string();
  if (is_entry(faces)) {
    throw OutputError(
        fmt::format("{}: this file is there, and its faces would become groups of the mesh that is "
                    "written beside it. Delete it, or choose another name for the mesh.",
                    faces));
  }
  Index first = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.vertex_id(v) != v) first = 1;
  }
  const bool regions =
      std::any_of(mesh.regions.begin(), mesh.regions.end(), [](int region) { return region != 0; });
  std::string nodes = fmt::format("{} 3 0 0\n", mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    append(nodes, "{} {}\n", v + first, coordinates(mesh.vertices[static_cast<std::size_t>(v)]));
  }
  std::string elements = fmt::format("{} 4 {}\n", mesh.tetrahedron_count(), regions ? 1 : 0);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    append(elements, "{}", e + first);
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      append(elements, " {}", v + first);
    }
    if (regions) append(elements, " {}", mesh.region(e));
    elements += '\n';
  }
  // Neither gets its name before both are complete.
  ReplacementFile node_file(std::filesystem::path(base).replace_extension(".node").string());
  ReplacementFile element_file(std::filesystem::path(base).replace_extension(".ele").string());
  node_file.write(nodes);
  element_file.write(elements);
  node_file.finish();
  element_file.finish();
}

// Elements as a comma-separated set, in the form that Vega writes.
void append_set(std::string& text, const std::string& name, const std::vector<Index>& elements) {
  append(text, "\n*SET {}\n", name);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    append(text, "{}{}", elements[i] + 1,
           i + 1 == elements.size() ? "\n"
           : i % 8 == 7             ? ",\n"
                                    : ", ");
  }
}

// Vega counts from 1 only. Its regions have no numbers; their order determines them.
void write_vega(const TetMesh& mesh, const std::string& path) {
  std::string text = fmt::format("# Vega mesh file.\n\n*VERTICES\n{} 3 0 0\n", mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    append(text, "{} {}\n", v + 1, coordinates(mesh.vertices[static_cast<std::size_t>(v)]));
  }
  append(text, "\n*ELEMENTS\nTET\n{} 4 0\n", mesh.tetrahedron_count());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    append(text, "{}", e + 1);
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) append(text, " {}", v + 1);
    text += '\n';
  }
  std::set<std::string> names;
  for (const Group& group : mesh.groups) {
    if (group.dimension != 3 || group.tetrahedra.empty()) continue;
    // A set has a name of its own.
    std::string name = group.name;
    while (!names.insert(name).second) name += fmt::format(" (tag {})", group.tag);
    append_set(text, name, group.tetrahedra);
  }
  const std::map<int, std::vector<Index>> regions = tetrahedra_by_region(mesh);
  if (regions.size() > 1) {
    // The format requires a material. This program takes its materials from the scene.
    append(text, "\n*MATERIAL {}\nENU, 1000, 1000000, 0.45\n", kPlaceholderMaterial);
    for (const auto& [region, elements] : regions) {
      std::string name = fmt::format("region_{}", region);
      // A set of that name may be there already, with these elements or with others.
      const auto is_written = [&](const Group& group) {
        return group.dimension == 3 && group.name == name && !group.tetrahedra.empty();
      };
      auto same = std::ranges::find_if(mesh.groups, is_written);
      while (same != mesh.groups.end() && same->tetrahedra != elements) {
        name += "_";
        same = std::ranges::find_if(mesh.groups, is_written);
      }
      if (same == mesh.groups.end()) append_set(text, name, elements);
      append(text, "\n*REGION\n{}, {}\n", name, kPlaceholderMaterial);
    }
  }
  write_text_file(path, text);
}

// The groups that are lost in a format that has volume groups only.
std::vector<std::string> lost_groups(const TetMesh& mesh, bool keeps_volumes) {
  std::vector<std::string> names;
  for (const Group& group : mesh.groups) {
    const bool kept = keeps_volumes && group.dimension == 3 && !group.tetrahedra.empty();
    if (!kept) names.push_back(group.name);
  }
  return names;
}

// VTK's formats hold all arrays that have names of their own, the others none.
std::vector<std::string> lost_arrays(const TetMesh& mesh, bool vtk) {
  std::vector<std::string> names;
  for (const auto& [name, values] : mesh.point_arrays) {
    if (!vtk || is_taken(name, false)) names.push_back(name);
  }
  for (const auto& [name, values] : mesh.cell_arrays) {
    if (!vtk || is_taken(name, true)) names.push_back(name);
  }
  return names;
}

// Whether Vega's numbers of regions, from 1 if there are several, differ from those of the mesh.
bool vega_changes_regions(const TetMesh& mesh) {
  int next = 0;
  const auto regions = tetrahedra_by_region(mesh);
  if (regions.size() == 1) return regions.begin()->first != 0;
  return std::ranges::any_of(regions, [&](const auto& region) { return region.first != ++next; });
}

}  // namespace

std::vector<RawCell> group_cells(const RawMesh& raw) {
  std::vector<RawCell> cells;
  std::copy_if(raw.cells.begin(), raw.cells.end(), std::back_inserter(cells),
               [](const RawCell& cell) {
                 return cell.type != CellType::kTetrahedron &&
                        cell.type != CellType::kQuadraticTetrahedron && !cell.groups.empty();
               });
  return cells;
}

MeshWriteReport write_mesh(const TetMesh& mesh, const std::string& path,
                           const std::vector<RawCell>& cells) {
  const std::string ending = mesh_ending(path, "written");
  if (mesh.vertices.empty() || mesh.tetrahedra.empty()) {
    throw InputError(path + ": there is nothing to write: the mesh is empty.");
  }
  if (mesh.is_quadratic() && (ending == ".veg" || ending == ".node" || ending == ".ele")) {
    throw InputError(path + ": " + ending +
                     " files hold linear tetrahedra only, and the mesh has quadratic ones. Write a "
                     ".vtu, .vtk or .msh file.");
  }
  if (ending == ".msh") return write_gmsh(mesh, path, cells);
  if (ending == ".vtu") {
    write_vtu(grid_with_data(mesh), path);
  } else if (ending == ".vtk") {
    write_legacy(mesh, path);
  } else if (ending == ".veg") {
    write_vega(mesh, path);
  } else {
    write_tetgen(mesh, path);
  }
  MeshWriteReport report;
  report.lost_groups = lost_groups(mesh, ending == ".veg");
  report.lost_arrays = lost_arrays(mesh, ending == ".vtu" || ending == ".vtk");
  report.changed_regions = ending == ".veg" && vega_changes_regions(mesh);
  return report;
}

}  // namespace tetraction
