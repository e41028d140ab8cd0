#include "tetraction/io/mesh_writer.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "quiet_vtk.h"
#include "tetraction/core/error.h"
#include "text_file.h"
#include "vtk_grid.h"
#include "vtk_header.h"

namespace tetraction {
namespace {

vtkSmartPointer<vtkUnstructuredGrid> grid_with_data(const TetMesh& mesh) {
  auto grid = make_grid(mesh);
  Matrix regions(1, mesh.tetrahedron_count());
  for (Index e = 0; e < regions.cols(); ++e) {
    regions(0, e) = mesh.region(e);
  }
  grid->GetCellData()->AddArray(make_array("region", regions, true));
  for (const auto& [name, values] : mesh.point_arrays) {
    grid->GetPointData()->AddArray(make_array(name, values, false));
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

// The file's own numbers if they are all at least 1, else numbers from 1. id(i): the number of item i.
template <class Id>
std::vector<std::int64_t> positive_ids(Index count, const Id& id) {
  std::vector<std::int64_t> ids;
  ids.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) ids.push_back(id(i));
  const std::int64_t least = *std::min_element(ids.begin(), ids.end());
  if (least < 1) {
    for (std::int64_t& number : ids) number += 1 - least;
  }
  return ids;
}

std::map<int, std::vector<Index>> tetrahedra_by_region(const TetMesh& mesh) {
  std::map<int, std::vector<Index>> regions;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) regions[mesh.region(e)].push_back(e);
  return regions;
}

std::string coordinates(const Vector3& x) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", x.x(), x.y(), x.z());
}

template <class... Args>
void append(std::string& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

// One volume entity a region; a region's number becomes its physical tag.
void write_gmsh(const TetMesh& mesh, const std::string& path) {
  const std::vector<std::int64_t> nodes =
      positive_ids(mesh.vertex_count(), [&](Index v) { return mesh.vertex_id(v); });
  const std::vector<std::int64_t> elements =
      positive_ids(mesh.tetrahedron_count(), [&](Index e) { return mesh.tetrahedron_id(e); });
  const std::map<int, std::vector<Index>> regions = tetrahedra_by_region(mesh);
  std::map<int, std::string> names;
  for (const Group& group : mesh.groups) {
    if (group.dimension == 3 && group.tag > 0 && regions.count(group.tag) > 0) {
      names[group.tag] = group.name;
      std::replace(names[group.tag].begin(), names[group.tag].end(), '"', '\'');
    }
  }
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  if (!names.empty()) {
    append(text, "$PhysicalNames\n{}\n", names.size());
    for (const auto& [tag, name] : names) append(text, "3 {} \"{}\"\n", tag, name);
    text += "$EndPhysicalNames\n";
  }
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3 x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  append(text, "$Entities\n0 0 0 {}\n", regions.size());
  int entity = 0;
  for (const auto& [region, members] : regions) {
    append(text, "{} {} {} ", ++entity, coordinates(low), coordinates(high));
    text += region > 0 ? fmt::format("1 {} 0\n", region) : "0 0\n";
  }
  text += "$EndEntities\n";
  const auto [first_node, last_node] = std::minmax_element(nodes.begin(), nodes.end());
  append(text, "$Nodes\n1 {0} {1} {2}\n3 1 0 {0}\n", nodes.size(), *first_node, *last_node);
  for (const std::int64_t id : nodes) append(text, "{}\n", id);
  for (const Vector3 x : mesh.vertices) append(text, "{}\n", coordinates(x));
  const auto [first, last] = std::minmax_element(elements.begin(), elements.end());
  append(text, "$EndNodes\n$Elements\n{} {} {} {}\n", regions.size(), elements.size(), *first,
         *last);
  entity = 0;
  for (const auto& [region, members] : regions) {
    append(text, "3 {} 4 {}\n", ++entity, members.size());
    for (const Index e : members) {
      append(text, "{}", elements[static_cast<std::size_t>(e)]);
      for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)])
        append(text, " {}", nodes[static_cast<std::size_t>(v)]);
      text += '\n';
    }
  }
  write_text_file(path, text + "$EndElements\n");
}

// TetGen wants numbers in a row: from 0 if the file's are that, else from 1.
void write_tetgen(const TetMesh& mesh, const std::string& path) {
  const std::filesystem::path base(path);
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
  write_text_file(std::filesystem::path(base).replace_extension(".node").string(), nodes);
  write_text_file(std::filesystem::path(base).replace_extension(".ele").string(), elements);
}

// Elements as a comma-separated set, the way Vega writes them.
void append_set(std::string& text, const std::string& name, const std::vector<Index>& elements) {
  append(text, "\n*SET {}\n", name);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    append(text, "{}{}", elements[i] + 1,
           i + 1 == elements.size() ? "\n"
           : i % 8 == 7             ? ",\n"
                                    : ", ");
  }
}

// Vega has numbers from 1 only, and regions without numbers: their order stands for them.
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
  for (const Group& group : mesh.groups) {
    if (group.dimension == 3 && !group.tetrahedra.empty()) {
      append_set(text, group.name, group.tetrahedra);
    }
  }
  const std::map<int, std::vector<Index>> regions = tetrahedra_by_region(mesh);
  if (regions.size() > 1) {
    // The format demands a material; this program takes its materials from the scene.
    text += "\n*MATERIAL placeholder\nENU, 1000, 1000000, 0.45\n";
    for (const auto& [region, elements] : regions) {
      const std::string name = fmt::format("region_{}", region);
      append_set(text, name, elements);
      append(text, "\n*REGION\n{}, placeholder\n", name);
    }
  }
  write_text_file(path, text);
}

}  // namespace

void write_mesh(const TetMesh& mesh, const std::string& path) {
  if (mesh.vertices.empty() || mesh.tetrahedra.empty()) {
    throw InputError(path + ": there is nothing to write: the mesh is empty.");
  }
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".vtu") {
    write_vtu(grid_with_data(mesh), path);
  } else if (extension == ".vtk") {
    write_legacy(mesh, path);
  } else if (extension == ".msh") {
    write_gmsh(mesh, path);
  } else if (extension == ".node" || extension == ".ele") {
    write_tetgen(mesh, path);
  } else if (extension == ".veg") {
    write_vega(mesh, path);
  } else {
    throw InputError(
        fmt::format("{}: the ending \"{}\" is not that of a mesh; .vtu .vtk .msh .node "
                    ".ele .veg are written.",
                    path, extension));
  }
}

}  // namespace tetraction
