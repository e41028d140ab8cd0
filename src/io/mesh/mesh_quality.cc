#include "tetraction/io/mesh_quality.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkMeshQuality.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>

#include "io/vtk/vtk_grid.h"

namespace tetraction {
namespace {

struct Measure {
  const char* name;
  const char* ideal;
  int id;
  bool large_is_bad;
};

constexpr std::array<Measure, 4> kMeasures{
    {{"scaled Jacobian", "1", VTK_QUALITY_SCALED_JACOBIAN, false},
     {"radius ratio", "1", VTK_QUALITY_RADIUS_RATIO, true},
     {"shape", "1", VTK_QUALITY_SHAPE, false},
     {"edge ratio", "1", VTK_QUALITY_EDGE_RATIO, true}}};

}  // namespace

std::vector<QualityMeasure> mesh_quality(const TetMesh& mesh) {
  if (mesh.tetrahedra.empty()) return {};
  TetMesh corners = mesh;  // the measures are those of straight edges
  corners.edge_vertices.clear();
  const auto grid = make_grid(corners);
  std::vector<QualityMeasure> result;
  for (const Measure& measure : kMeasures) {
    vtkNew<vtkMeshQuality> filter;
    filter->SetInputData(grid);
    filter->SetTetQualityMeasure(measure.id);
    filter->Update();
    vtkDataArray* values = filter->GetOutput()->GetCellData()->GetArray("Quality");
    QualityMeasure q;
    q.name = measure.name;
    q.ideal = measure.ideal;
    double sum = 0.0;
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      q.values.push_back(values->GetTuple1(e));
      sum += q.values.back();
    }
    const auto [low, high] = std::minmax_element(q.values.begin(), q.values.end());
    q.min = *low;
    q.max = *high;
    q.mean = sum / static_cast<double>(q.values.size());
    const auto worst = (measure.large_is_bad ? high : low) - q.values.begin();
    q.worst_element = mesh.tetrahedron_id(worst);
    result.push_back(std::move(q));
  }
  return result;
}

}  // namespace tetraction
