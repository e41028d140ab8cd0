#include "vtk_reader.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/quoting.h"
#include "guarded_grid.h"
#include "io/mesh/groups_by_number.h"
#include "io/text/byte_stream.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The cell type that a number of VTK's stands for. The number of vertices tells the order of cells of any order.
CellType vtk_cell_type(int vtk, std::size_t vertices) {
  switch (vtk) {
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
      return CellType::kVertex;
    case VTK_LINE:
    case VTK_POLY_LINE:
    case VTK_QUADRATIC_EDGE:
      return CellType::kLine;
    case VTK_TRIANGLE:
    case VTK_TRIANGLE_STRIP:
    case VTK_QUADRATIC_TRIANGLE:
      return CellType::kTriangle;
    case VTK_QUAD:
    case VTK_PIXEL:
    case VTK_QUADRATIC_QUAD:
      return CellType::kQuadrilateral;
    case VTK_TETRA:
      return CellType::kTetrahedron;
    case VTK_QUADRATIC_TETRA:
      return CellType::kQuadraticTetrahedron;
    case VTK_HIGHER_ORDER_TETRAHEDRON:
    case VTK_LAGRANGE_TETRAHEDRON:
    case VTK_BEZIER_TETRAHEDRON:
      return vertices == 4 ? CellType::kTetrahedron : CellType::kQuadraticTetrahedron;
    case VTK_LAGRANGE_TRIANGLE:
    case VTK_BEZIER_TRIANGLE:
      return CellType::kTriangle;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
    case VTK_QUADRATIC_HEXAHEDRON:
      return CellType::kHexahedron;
    case VTK_WEDGE:
    case VTK_QUADRATIC_WEDGE:
      return CellType::kWedge;
    case VTK_PYRAMID:
    case VTK_QUADRATIC_PYRAMID:
      return CellType::kPyramid;
    default:
      return CellType::kOther;
  }
}

// How many vertices such a cell has; 0 where the number is free.
std::size_t vtk_cell_size(int vtk) {
  switch (vtk) {
    case VTK_VERTEX:
      return 1;
    case VTK_LINE:
      return 2;
    case VTK_QUADRATIC_EDGE:
    case VTK_TRIANGLE:
      return 3;
    case VTK_QUAD:
    case VTK_PIXEL:
    case VTK_TETRA:
      return 4;
    case VTK_PYRAMID:
      return 5;
    case VTK_QUADRATIC_TRIANGLE:
    case VTK_WEDGE:
      return 6;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return 8;
    case VTK_QUADRATIC_TETRA:
      return 10;
    default:
      return 0;
  }
}

// ---- in the child ------------------------------------------------------------------------------

bool is_real(vtkDataArray* array) {
  return array->GetDataType() == VTK_FLOAT || array->GetDataType() == VTK_DOUBLE;
}

// Whether an array has one integer for each of that many items.
bool has_integers(vtkDataArray* array, vtkIdType count) {
  return array != nullptr && array->GetNumberOfComponents() == 1 &&
         array->GetNumberOfTuples() == count && !is_real(array);
}

// The integers of an array, if it has that many.
std::vector<std::int64_t> integers(vtkDataArray* array, vtkIdType count) {
  if (!has_integers(array, count)) return {};
  vtkNew<vtkTypeInt64Array> whole;  // a double would lose digits of large numbers
  whole->DeepCopy(array);
  return {whole->GetPointer(0), whole->GetPointer(0) + count};
}

// Cell data `region`; other programs may store it as real numbers.
std::vector<std::int64_t> regions(vtkDataArray* array, vtkIdType cells) {
  std::vector<std::int64_t> values;
  if (array == nullptr) return values;
  if (array->GetNumberOfComponents() != 1 || array->GetNumberOfTuples() != cells) {
    throw FileError("its cell data \"region\" are not one number a cell");
  }
  for (vtkIdType c = 0; c < cells; ++c) {
    const double value = array->GetTuple1(c);
    if (!(value == std::floor(value)) || std::abs(value) > std::numeric_limits<int>::max()) {
      throw FileError(
          fmt::format("the region {} of cell {} is not an integer that fits 32 bits", value, c));
    }
    values.push_back(static_cast<std::int64_t>(value));
  }
  return values;
}

// The numbers of groups of triangles: 0 for other cells and for triangles of no group. They come from
// the first of these cell data that there is: those of other programs, or `region`.
std::vector<std::int64_t> triangle_groups(vtkUnstructuredGrid* grid) {
  const vtkIdType cells = grid->GetNumberOfCells();
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(cells), 0);
  for (const char* name : {"gmsh:physical", "medit:ref", "CellEntityIds", "region"}) {
    vtkDataArray* array = grid->GetCellData()->GetArray(name);
    if (array == nullptr || array->GetNumberOfComponents() != 1 ||
        array->GetNumberOfTuples() != cells) {
      continue;
    }
    for (vtkIdType c = 0; c < cells; ++c) {
      const int type = grid->GetCellType(c);
      if (type != VTK_TRIANGLE && type != VTK_QUADRATIC_TRIANGLE && type != VTK_LAGRANGE_TRIANGLE) {
        continue;
      }
      const double value = array->GetTuple1(c);
      if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
        throw FileError(
            fmt::format("the number {} of triangle {} in its cell data \"{}\" is not an "
                        "integer that fits 32 bits",
                        value, c, name));
      }
      numbers[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(value);
    }
    break;
  }
  return numbers;
}

// Cells or points of other parts of a mesh, which a part has a copy of, and cells that are hidden.
void refuse_ghosts(vtkDataSetAttributes* data, const char* item) {
  for (const char* name : {"vtkGhostType", "vtkGhostLevels"}) {
    vtkDataArray* marks = data->GetArray(name);
    for (vtkIdType i = 0; marks != nullptr && i < marks->GetNumberOfTuples(); ++i) {
      if (marks->GetComponent(i, 0) == 0.0) continue;
      throw FileError(fmt::format(
          "{0} {1} is marked as a ghost or as hidden by its array \"{2}\", so that the body "
          "could be meant with it or without it. Write the mesh without ghost {0}s",
          item, i, name));
    }
  }
}

// Sorts the arrays of points or of cells into those that are read, of up to 9 components: those of real
// numbers, and for cells whole numbers, too, from which a material may take a parameter; and into the names of
// those that are not used. Some arrays are used by themselves.
class ReadArrays {
 public:
  ReadArrays(vtkDataSetAttributes* data, vtkIdType tuples, bool of_cells) : tuples_(tuples) {
    for (int a = 0; a < data->GetNumberOfArrays(); ++a) sort(data->GetAbstractArray(a), of_cells);
  }

  void encode(ByteWriter& out) const {
    out.put<std::uint64_t>(arrays_.size());
    for (vtkDataArray* array : arrays_) {
      out.put_text(array->GetName());
      const int components = array->GetNumberOfComponents();
      out.put<std::int32_t>(components);
      std::vector<double> values(static_cast<std::size_t>(components * tuples_));
      for (vtkIdType i = 0; i < tuples_; ++i) {
        array->GetTuple(i, values.data() + static_cast<std::size_t>(components * i));
      }
      out.put_all(values.data(), values.size());
    }
    out.put<std::uint64_t>(unused_.size());
    for (const std::string& name : unused_) out.put_text(name);
  }

 private:
  void sort(vtkAbstractArray* any, bool of_cells) {
    const std::string name = any->GetName() != nullptr ? any->GetName() : "";
    vtkDataArray* array = vtkDataArray::SafeDownCast(any);
    const bool numbers_items = name == (of_cells ? "element_id" : "vertex_id");
    if (numbers_items && has_integers(array, tuples_)) return;
    if ((of_cells && name == "region") || name.starts_with("vtkGhost")) return;
    const bool readable = array != nullptr && !name.empty() &&
                          array->GetNumberOfTuples() == tuples_ &&
                          array->GetNumberOfComponents() <= 9;
    const bool is_read = readable && !numbers_items && (is_real(array) || of_cells);
    if (is_read) arrays_.push_back(array);
    if (!is_read) unused_.push_back(name);
  }

  vtkIdType tuples_;
  std::vector<vtkDataArray*> arrays_;
  std::vector<std::string> unused_;
};

std::string encode(vtkUnstructuredGrid* grid) {
  refuse_ghosts(grid->GetPointData(), "point");
  refuse_ghosts(grid->GetCellData(), "cell");
  ByteWriter out;
  const vtkIdType points = grid->GetNumberOfPoints();
  const vtkIdType cells = grid->GetNumberOfCells();
  std::vector<double> coordinates(3 * static_cast<std::size_t>(points));
  for (vtkIdType i = 0; i < points; ++i) {
    grid->GetPoint(i, coordinates.data() + 3 * static_cast<std::size_t>(i));
  }
  out.put_all(coordinates.data(), coordinates.size());
  std::vector<std::int32_t> types;
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> ends;
  types.reserve(static_cast<std::size_t>(cells));
  ends.reserve(static_cast<std::size_t>(cells));
  connectivity.reserve(4 * static_cast<std::size_t>(cells));  // of tetrahedra
  vtkNew<vtkIdList> ids;
  if (cells > 0 && !grid->GetCells()->IsValid()) {
    throw FileError("the offsets of its cells do not fit their connectivity");
  }
  for (vtkIdType c = 0; c < cells; ++c) {
    types.push_back(grid->GetCellType(c));
    grid->GetCellPoints(c, ids);
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) connectivity.push_back(ids->GetId(i));
    ends.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  out.put_all(types.data(), types.size());
  out.put_all(connectivity.data(), connectivity.size());
  out.put_all(ends.data(), ends.size());
  vtkPointData* point_data = grid->GetPointData();
  vtkCellData* cell_data = grid->GetCellData();
  for (const auto& values :
       {integers(point_data->GetArray("vertex_id"), points),
        integers(cell_data->GetArray("element_id"), cells),
        regions(cell_data->GetArray("region"), cells), triangle_groups(grid)}) {
    out.put_all(values.data(), values.size());
  }
  ReadArrays(point_data, points, false).encode(out);
  ReadArrays(cell_data, cells, true).encode(out);
  return out.take_bytes();
}

// ---- in the parent -----------------------------------------------------------------------------

class Decoder {
 public:
  Decoder(const std::string& path, std::string bytes)
      : path_(path), bytes_(std::move(bytes)), in_(bytes_) {}

  RawMesh decode(const VtkHeader& announced, std::vector<std::string>& unused) {
    const auto coordinates = in_.get_all<double>();
    const auto types = in_.get_all<std::int32_t>();
    const auto connectivity = in_.get_all<std::int64_t>();
    const auto ends = in_.get_all<std::int64_t>();
    const auto vertex_ids = in_.get_all<std::int64_t>();
    const auto element_ids = in_.get_all<std::int64_t>();
    const auto region_numbers = in_.get_all<std::int64_t>();
    const auto group_numbers = in_.get_all<std::int64_t>();
    const std::size_t points = coordinates.size() / 3;
    if (!in_.good() || ends.size() != types.size() || group_numbers.size() != types.size()) {
      refuse("its parts do not fit together");
    }
    check_counts(path_, announced, points, types.size());

    RawMesh mesh;
    mesh.source = path_;
    read_arrays(mesh.point_arrays, points, "point", unused);
    read_arrays(mesh.cell_arrays, types.size(), "cell", unused);
    std::string().swap(bytes_);  // as large as the mesh
    mesh.vertices.reserve(points);
    mesh.vertex_ids.reserve(points);
    for (std::size_t i = 0; i < points; ++i) {
      mesh.vertices.emplace_back(coordinates[3 * i], coordinates[3 * i + 1],
                                 coordinates[3 * i + 2]);
      mesh.vertex_ids.push_back(static_cast<std::int64_t>(i));
    }
    // The file's own numbers, should it carry them.
    check_distinct(vertex_ids, "point data \"vertex_id\"");
    check_distinct(element_ids, "cell data \"element_id\"");
    if (vertex_ids.size() == points) mesh.vertex_ids = vertex_ids;
    const bool own_elements = element_ids.size() == types.size();
    GroupsByNumber groups(mesh, 2);
    mesh.cells.reserve(types.size());
    std::int64_t begin = 0;
    for (std::size_t c = 0; c < types.size(); ++c) {
      RawCell cell;
      cell.vertices.reserve(vtk_cell_size(types[c]));
      cell.type = vtk_cell_type(
          types[c], static_cast<std::size_t>(std::max<std::int64_t>(ends[c] - begin, 0)));
      cell.id = own_elements ? element_ids[c] : static_cast<std::int64_t>(c);
      if (region_numbers.size() == types.size()) cell.region = static_cast<int>(region_numbers[c]);
      for (std::int64_t i = begin; i < ends[c]; ++i) {
        const std::int64_t point = connectivity.at(static_cast<std::size_t>(i));
        if (point < 0 || point >= static_cast<std::int64_t>(points)) {
          refuse(fmt::format("cell {} refers to point {}, but there are only {} points", cell.id,
                             point, points));
        }
        cell.vertices.push_back(mesh.vertex_ids[static_cast<std::size_t>(point)]);
      }
      const std::size_t wanted = vtk_cell_size(types[c]);
      if (wanted != 0 && cell.vertices.size() != wanted) {
        refuse(fmt::format("cell {} is a {} with {} vertices", cell.id, to_string(cell.type),
                           cell.vertices.size()));
      }
      if (types[c] == VTK_BEZIER_TETRAHEDRON && cell.type == CellType::kQuadraticTetrahedron) {
        refuse(fmt::format(
            "cell {} is a Bezier tetrahedron of order 2 or more, whose control points do "
            "not lie on its edges. Write it with Lagrange or quadratic tetrahedra",
            cell.id));
      }
      begin = ends[c];
      if (cell.type == CellType::kTriangle) groups.add(cell, group_numbers[c]);
      mesh.cells.push_back(std::move(cell));
    }
    return mesh;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { refuse_grid(path_, what); }

  // One number for two things says nothing of either.
  void check_distinct(std::vector<std::int64_t> ids, const char* what) const {
    std::sort(ids.begin(), ids.end());
    const auto twice = std::adjacent_find(ids.begin(), ids.end());
    if (twice == ids.end()) return;
    refuse(fmt::format("its {} have the number {} twice, so that it is ambiguous", what, *twice));
  }

  void read_arrays(std::map<std::string, Matrix>& target, std::size_t tuples, const char* what,
                   std::vector<std::string>& unused) {
    const auto arrays = in_.get<std::uint64_t>();
    for (std::uint64_t a = 0; a < arrays && in_.good(); ++a) {
      const std::string name = in_.get_text();
      const auto components = in_.get<std::int32_t>();
      const auto values = in_.get_all<double>();
      if (!in_.good() || components < 1 ||
          values.size() != static_cast<std::size_t>(components) * tuples) {
        refuse(fmt::format("its {} data do not fit", what));
      }
      target[name] =
          Eigen::Map<const Matrix>(values.data(), components, static_cast<Index>(tuples));
    }
    std::vector<std::string> names(
        std::min<std::uint64_t>(in_.get<std::uint64_t>(), bytes_.size()));
    for (std::string& name : names) name = in_.get_text();
    if (names.empty()) return;
    unused.push_back(
        fmt::format("the {} data {}", what, quoted_list({names.begin(), names.end()})));
  }

  const std::string& path_;
  std::string bytes_;
  ByteReader in_;
};

}  // namespace

RawMesh read_vtk_mesh(const std::string& path, std::vector<std::string>& unused) {
  GridFile file = read_guarded(path, encode);
  return Decoder(path, std::move(file.bytes)).decode(file.header, unused);
}

}  // namespace tetraction
