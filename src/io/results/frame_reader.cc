#include "tetraction/io/frame_reader.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <cstdint>

#include "core/quoting.h"
#include "io/text/byte_stream.h"
#include "io/vtk/guarded_grid.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

void encode_arrays(vtkDataSetAttributes* data, const std::vector<std::string>& names,
                   ByteWriter& out) {
  for (const std::string& name : names) {
    vtkDataArray* array = data->GetArray(name.c_str());
    Matrix values;
    if (array != nullptr) {
      values.resize(array->GetNumberOfComponents(), array->GetNumberOfTuples());
      for (Index i = 0; i < values.cols(); ++i) array->GetTuple(i, values.col(i).data());
    }
    out.put<std::int64_t>(values.rows());
    out.put_all(values.data(), static_cast<std::size_t>(values.size()));
  }
}

std::vector<Matrix> decode_arrays(const std::string& path, ByteReader& in,
                                  const std::vector<std::string>& names, Index tuples) {
  std::vector<Matrix> arrays;
  for (const std::string& name : names) {
    const auto rows = in.get<std::int64_t>();
    const auto values = in.get_all<double>();
    if (!in.good() || rows * (rows == 0 ? 0 : tuples) != static_cast<Index>(values.size())) {
      refuse_grid(path, fmt::format("the array {} does not fit", in_quotes(name)));
    }
    arrays.emplace_back(Eigen::Map<const Matrix>(values.data(), rows, rows == 0 ? 0 : tuples));
  }
  return arrays;
}

}  // namespace

StoredFrame read_frame(const std::string& path, const std::vector<std::string>& point_names,
                       const std::vector<std::string>& cell_names) {
  const GridFile file = read_guarded(path, [&](vtkUnstructuredGrid* grid) {
    ByteWriter out;
    out.put<std::int64_t>(grid->GetNumberOfPoints());
    out.put<std::int64_t>(grid->GetNumberOfCells());
    encode_arrays(grid->GetPointData(), point_names, out);
    encode_arrays(grid->GetCellData(), cell_names, out);
    return out.take_bytes();
  });
  ByteReader in(file.bytes);
  StoredFrame frame;
  frame.vertex_count = in.get<std::int64_t>();
  frame.tetrahedron_count = in.get<std::int64_t>();
  check_counts(path, file.header, static_cast<std::size_t>(frame.vertex_count),
               static_cast<std::size_t>(frame.tetrahedron_count));
  frame.point_arrays = decode_arrays(path, in, point_names, frame.vertex_count);
  frame.cell_arrays = decode_arrays(path, in, cell_names, frame.tetrahedron_count);
  return frame;
}

}  // namespace tetraction
