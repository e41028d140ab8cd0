#include "failed_elements.h"

#include <vtkAppendFilter.h>
#include <vtkCellData.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <array>
#include <map>
#include <string>
#include <vector>

#include "frame_fields.h"
#include "io/vtk/vtk_grid.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {
namespace {

// Some elements of a mesh with the vertices that they use.
struct Part {
  TetMesh mesh;
  std::vector<Index> vertices;
  std::vector<Index> elements;

  Part(const TetMesh& whole, const std::vector<Index>& chosen) : elements(chosen) {
    std::map<Index, Index> number;
    const auto renumber = [&](auto nodes) {
      for (Index& v : nodes) {
        const auto [entry, is_new] = number.emplace(v, static_cast<Index>(vertices.size()));
        if (is_new) {
          vertices.push_back(v);
          mesh.vertices.own().push_back(whole.vertices[static_cast<std::size_t>(v)]);
          mesh.vertex_ids.push_back(whole.vertex_id(v));
        }
        v = entry->second;
      }
      return nodes;
    };
    for (const Index e : chosen) {
      const auto i = static_cast<std::size_t>(e);
      mesh.tetrahedra.own().push_back(renumber(whole.tetrahedra[i]));
      if (whole.is_quadratic()) mesh.edge_vertices.push_back(renumber(whole.edge_vertices[i]));
      mesh.tetrahedron_ids.push_back(whole.tetrahedron_id(e));
    }
  }
};

Matrix chosen_columns(const Matrix& values, const std::vector<Index>& columns) {
  Matrix chosen(values.rows(), static_cast<Index>(columns.size()));
  for (Index i = 0; i < chosen.cols(); ++i) {
    chosen.col(i) = values.col(columns[static_cast<std::size_t>(i)]);
  }
  return chosen;
}

// The failed elements of the whole mesh, or of its part. All parts have the same arrays.
vtkSmartPointer<vtkUnstructuredGrid> failed_elements(const Session& session) {
  const StepFailure& failure = *session.failure();
  const MechanicalSystem& system = session.system();
  const Part part(system.mesh(), failure.elements);
  auto grid = make_grid(part.mesh);
  const auto of_points = [&](const std::string& name, const Matrix& values) {
    grid->GetPointData()->AddArray(make_array(name, chosen_columns(values, part.vertices), false));
  };
  const auto of_cells = [&](const std::string& name, const Matrix& values, bool integral) {
    grid->GetCellData()->AddArray(
        make_array(name, chosen_columns(values, part.elements), integral));
  };
  const Frame frame =
      make_frame(session, {"displacement", "velocity", "external_force", "reaction_force", "region",
                           "jacobian", "energy_density"});
  for (const FrameField& field : frame.point_fields) of_points(field.name, field.values);
  for (const FrameField& field : frame.cell_fields) {
    of_cells(field.name, field.values, field.integral);
  }
  double energy = 0.0;
  Vector gradient;
  if (everywhere(
          system.part(),
          system.elastic_energy_and_gradient(session.state().position, energy, gradient).ok())) {
    of_points("elastic_force", -gradient.reshaped(3, system.vertex_count()));
  }
  // Where the step led the vertices, if these are numbers.
  const Vector& trial = failure.attempted_position;
  if (everywhere(system.part(), trial.size() > 0 && trial.allFinite())) {
    const Vector displacement = trial - system.mesh().rest_positions();
    of_points("attempted_displacement", displacement.reshaped(3, system.vertex_count()));
    of_cells("attempted_jacobian", volume_ratios(system, trial).transpose(), false);
  }
  return grid;
}

// On process 0 the cells of all parts, those of the process that has the worst first; elsewhere null. A vertex that parts
// share is a point of each of them.
vtkSmartPointer<vtkUnstructuredGrid> appended(const MeshPart& part, vtkUnstructuredGrid* own,
                                              int worst) {
  std::string text;
  if (own->GetNumberOfCells() > 0) {
    const auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
    writer->SetInputData(own);
    writer->WriteToOutputStringOn();
    writer->Write();
    text = writer->GetOutputString();
  }
  const auto all = vtkSmartPointer<vtkAppendFilter>::New();
  for (int i = 0; i < part.count(); ++i) {
    const int rank = (worst + i) % part.count();
    std::string piece = rank == part.rank() ? text : std::string();
    part.broadcast(piece, rank);
    if (part.rank() != 0 || piece.empty()) continue;
    const auto reader = vtkSmartPointer<vtkXMLUnstructuredGridReader>::New();
    reader->ReadFromInputStringOn();
    reader->SetInputString(piece);
    reader->Update();
    all->AddInputData(reader->GetOutput());
  }
  if (part.rank() != 0) return nullptr;
  all->Update();
  return all->GetOutput();
}

}  // namespace

void write_failed_elements(const Session& session, const std::string& path) {
  vtkSmartPointer<vtkUnstructuredGrid> grid = failed_elements(session);
  const MeshPart* part = session.system().part();
  if (part != nullptr) grid = appended(*part, grid, session.failure()->process);
  if (grid) write_vtu(grid, path);
}

}  // namespace tetraction
