#include "polygon_reader.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLPolyDataReader.h>

#include <cstdlib>
#include <utility>
#include <vector>

#include "core/quoting.h"
#include "guarded_process.h"
#include "io/text/byte_stream.h"
#include "io/text/text_scanner.h"
#include "quiet_vtk.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr const char* kNoPolygons = "the file cannot be read as VTK polygons";

// The corners of all triangles, one after the other.
std::vector<Index> triangles_of_polygons(vtkPolyData* data) {
  const vtkIdType points = data->GetNumberOfPoints();
  std::vector<Index> corners;
  const auto add_cells = [&](vtkCellArray* cells, bool strips) {
    if (cells == nullptr) return;
    const auto cell = vtk::TakeSmartPointer(cells->NewIterator());
    for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
      vtkIdType size = 0;
      const vtkIdType* ids = nullptr;
      cell->GetCurrentCell(size, ids);
      for (vtkIdType k = 0; k < size; ++k) {
        if (ids[k] < 0 || ids[k] >= points) {
          throw FileError(
              fmt::format("a polygon has the point {}, but there are {} points", ids[k], points));
        }
      }
      if (size < 3) throw FileError("a polygon has fewer than three points");
      for (vtkIdType k = 2; k < size; ++k) {
        // Every other triangle of a strip is turned.
        const bool turned = strips && k % 2 == 1;
        corners.push_back(strips ? ids[k - 2] : ids[0]);
        corners.push_back(turned ? ids[k] : ids[k - 1]);
        corners.push_back(turned ? ids[k - 1] : ids[k]);
      }
    }
  };
  add_cells(data->GetPolys(), false);
  add_cells(data->GetStrips(), true);
  return corners;
}

// An error's text, empty if there is none, then coordinates and corners.
std::string polygons_in_child(const std::string& path) {
  // Threads of the parent do not exist here; a pool that waits for them would hang.
  setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
  ByteWriter out;
  try {
    VtkMessages messages;
    vtkNew<vtkXMLPolyDataReader> reader;
    messages.watch(reader);
    reader->SetFileName(path.c_str());
    reader->Update();
    if (!messages.empty()) throw FileError("VTK: " + excerpt(messages.first(), 300));
    vtkPolyData* data = reader->GetOutput();
    std::vector<double> coordinates;
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
      double x[3];
      data->GetPoint(i, x);
      coordinates.insert(coordinates.end(), x, x + 3);
    }
    const std::vector<Index> corners = triangles_of_polygons(data);
    out.put_text("");
    out.put_all(coordinates.data(), coordinates.size());
    out.put_all(corners.data(), corners.size());
    return out.take_bytes();
  } catch (const FileError& error) {
    ByteWriter failed;
    failed.put_text(error.what());
    return failed.take_bytes();
  }
}

}  // namespace

TriangleFile read_vtp(const std::string& path) {
  const std::string text = read_file(path);
  const auto refuse = [&](const std::string& what) {
    throw FileError(fmt::format("{}: {}: {}.", path, kNoPolygons, what));
  };
  constexpr std::size_t kHead = 4096;
  const std::string_view head = std::string_view(text).substr(0, kHead);
  const auto tag = head.find("<VTKFile");
  if (tag == head.npos) refuse("it has no element VTKFile");
  const std::string_view opening = head.substr(tag, head.substr(tag).find('>'));
  if (opening.find("\"PolyData\"") == opening.npos && opening.find("'PolyData'") == opening.npos) {
    refuse("its type is not PolyData");
  }
  if (text.find("</VTKFile>") == text.npos) refuse("its end is missing");
  GuardLimits limits;
  limits.processor_seconds = 5.0 + static_cast<double>(text.size()) / 1e6;
  limits.seconds = 20.0 + 2.0 * limits.processor_seconds;
  limits.memory = (std::size_t{1} << 30U) + 100 * text.size();
  const GuardResult result = run_guarded([&] { return polygons_in_child(path); }, limits);
  if (!result.finished) {
    refuse("VTK's reader " + result.failure + " on it. The file is broken; write it anew");
  }
  ByteReader in(result.bytes);
  const std::string error = in.get_text();
  if (!error.empty()) refuse(error);
  const auto coordinates = in.get_all<double>();
  const auto corners = in.get_all<Index>();
  if (!in.good()) refuse("its parts do not fit together");
  TriangleFile file;
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
    file.points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  }
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    file.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
  return file;
}

}  // namespace tetraction
