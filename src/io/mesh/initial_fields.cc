#include "tetraction/io/initial_fields.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/quoting.h"
#include "io/text/csv_table.h"
#include "io/text/formula.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/mesh/mesh_copies.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

Matrix field_of_file(const std::string& path, const TetMesh& mesh) {
  const CsvTable table = read_csv(path);
  const std::size_t columns = table.rows.front().values.size();
  const std::vector<std::string> with_vertices{"vertex", "x", "y", "z"};
  const std::vector<std::string> without{"x", "y", "z"};
  const bool header_fits =
      table.header.empty() || table.header == (columns == 4 ? with_vertices : without);
  if ((columns != 3 && columns != 4) || !header_fits) {
    throw FileError(fmt::format(
        "{}:{}: the columns must be vertex,x,y,z or x,y,z, and be named so if the file has a line "
        "with their names.",
        path, table.header.empty() ? table.rows.front().line : 1));
  }
  Matrix field = Matrix::Zero(3, mesh.vertex_count());
  const auto vector_of = [](const CsvTable::Row& row) -> Vector3 {
    return Eigen::Map<const Vector3>(row.values.data() + row.values.size() - 3);
  };
  if (columns == 3) {
    if (static_cast<Index>(table.rows.size()) != mesh.vertex_count()) {
      throw FileError(fmt::format(
          "{}:{}: the file has {} lines of three numbers, and the mesh has {} vertices{}. Give one "
          "line for each vertex, or put the number of the vertex before the three.",
          path, table.rows.back().line, table.rows.size(), mesh.vertex_count(),
          mesh.report.dropped_vertices > 0 ? " (those that no tetrahedron uses were dropped)"
                                           : ""));
    }
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      field.col(v) = vector_of(table.rows[static_cast<std::size_t>(v)]);
    }
    return field;
  }
  std::unordered_map<std::int64_t, Index> index_of;
  for (Index v = 0; v < mesh.vertex_count(); ++v) index_of.emplace(mesh.vertex_id(v), v);
  std::unordered_map<Index, std::size_t> line_of;
  for (const CsvTable::Row& row : table.rows) {
    const double number = row.values.front();
    const bool is_whole = std::abs(number) < 9e15 && number == std::floor(number);
    const auto vertex = index_of.find(is_whole ? static_cast<std::int64_t>(number) : -1);
    if (!is_whole || vertex == index_of.end()) {
      throw FileError(fmt::format(
          "{}:{}: the mesh has no vertex {}{}.", path, row.line, number,
          mesh.report.dropped_vertices > 0 ? "; those that no tetrahedron uses were dropped" : ""));
    }
    const auto [first, is_new] = line_of.emplace(vertex->second, row.line);
    if (!is_new) {
      throw FileError(fmt::format("{}:{}: vertex {} is given a second time, after line {}.", path,
                                  row.line, number, first->second));
    }
    field.col(vertex->second) = vector_of(row);
  }
  return field;
}

Matrix field_of_formulas(const FieldSettings& settings, const TetMesh& mesh, const char* key) {
  const std::string place = settings.where.empty() ? key + std::string(".formula") : settings.where;
  Matrix field(3, mesh.vertex_count());
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& text = settings.formula[i];
    try {
      const Formula formula(text, {"X", "Y", "Z"});
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
        const double value = formula({x[0], x[1], x[2]});
        if (!std::isfinite(value)) {
          throw InputError(fmt::format("{} is {} at vertex {}, X = {:.6g}, Y = {:.6g}, Z = {:.6g}.",
                                       in_quotes(text), value, mesh.vertex_id(v), x[0], x[1],
                                       x[2]));
        }
        field(static_cast<Index>(i), v) = value;
      }
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: the formula of {}, {}", place, "xyz"[i], error.what()));
    }
  }
  return field;
}

}  // namespace

void add_initial_fields(const InitialSettings& initial, TetMesh& mesh) {
  const auto add = [&](const FieldSettings& settings, const char* name) {
    if (settings.empty()) return;
    mesh.point_arrays[name] = settings.file.empty() ? field_of_formulas(settings, mesh, name)
                                                    : field_of_file(settings.file, mesh);
  };
  add(initial.displacement_field, kInitialDisplacement);
  add(initial.velocity_field, kInitialVelocity);
}

TetMesh read_scene_mesh(const Scene& scene) {
  std::vector<std::string> unused;
  return read_scene_mesh(scene, unused);
}

TetMesh read_scene_mesh(const Scene& scene, std::vector<std::string>& unused) {
  TetMesh mesh;
  if (scene.mesh.generate) {
    mesh = generate_mesh(*scene.mesh.generate);
  } else {
    std::error_code error;
    if (!std::filesystem::exists(scene.mesh.file, error) && !error) {
      throw FileError(scene.mesh.file +
                      ": no such file. Check mesh.file; it is relative to the scene's folder.");
    }
    mesh = read_mesh(scene.mesh.file, coordinate_scale(scene.mesh), unused);
    if (mesh.is_quadratic() && !scene.mesh.quadratic) {
      throw FileError(
          scene.mesh.file +
          ": the mesh has quadratic (ten-node) tetrahedra. Set mesh.element = \"quadratic\" to "
          "compute with them, or write the mesh with first-order elements (Gmsh: -order 1).");
    }
  }
  if (scene.mesh.quadratic) mesh = with_edge_vertices(std::move(mesh));
  std::vector<MeshPlace> places;
  for (const MeshCopySettings& copy : scene.mesh.copies) places.push_back({copy.at, copy.turn});
  mesh = with_copies(std::move(mesh), places);
  add_initial_fields(scene.initial, mesh);
  return mesh;
}

}  // namespace tetraction
