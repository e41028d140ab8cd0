#include "tetraction/io/mode_writer.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "io/text/output_file.h"
#include "io/vtk/vtk_grid.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

constexpr int kPictures = 24;        // of one period
constexpr double kAmplitude = 0.05;  // of the diagonal of the body, in the pictures
constexpr const char* kSwing = "swing";

double largest_displacement(const Vector& shape) {
  return shape.reshaped(3, shape.size() / 3).colwise().norm().maxCoeff();
}

double diagonal_of(const Vector& q) {
  const auto points = q.reshaped(3, q.size() / 3);
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

// The boundary of the body with its own numbering of vertices.
struct Surface {
  std::vector<Index> vertices;
  vtkSmartPointer<vtkUnstructuredGrid> grid = vtkSmartPointer<vtkUnstructuredGrid>::New();

  explicit Surface(const TetMesh& mesh) {
    std::vector<vtkIdType> number(mesh.vertices.size(), -1);
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    for (const std::array<Index, 3>& face : EdgeVertices(mesh).divide(boundary_faces(mesh))) {
      std::array<vtkIdType, 3> ids{};
      for (std::size_t i = 0; i < 3; ++i) {
        vtkIdType& id = number[static_cast<std::size_t>(face[i])];
        if (id < 0) {
          id = points->InsertNextPoint(mesh.vertices[static_cast<std::size_t>(face[i])].data());
          vertices.push_back(face[i]);
        }
        ids[i] = id;
      }
      cells->InsertNextCell(3, ids.data());
    }
    grid->SetPoints(points);
    grid->SetCells(VTK_TRIANGLE, cells);
  }

  void write(const Vector& displacement, const std::string& path) const {
    auto array = vtkSmartPointer<vtkFloatArray>::New();
    array->SetName("displacement");
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(static_cast<vtkIdType>(vertices.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      array->SetTuple(static_cast<vtkIdType>(i), displacement.data() + 3 * vertices[i]);
    }
    auto picture = vtkSmartPointer<vtkUnstructuredGrid>::New();
    picture->ShallowCopy(grid);
    picture->GetPointData()->AddArray(array);
    write_vtu(picture, path);
  }
};

// "07": as many digits as the largest number needs, two at least.
std::string number_text(std::size_t number, std::size_t count) {
  const std::size_t digits = std::max<std::size_t>(2, std::to_string(count).size());
  return fmt::format("{:0{}}", number, digits);
}

std::string modes_csv(const NormalModes& modes) {
  std::string text =
      "mode,frequency,omega_squared,effective_mass_x,effective_mass_y,effective_mass_z,modal_mass,"
      "kind,damping_ratio,growth_rate\n";
  for (std::size_t i = 0; i < modes.modes.size(); ++i) {
    const NormalMode& mode = modes.modes[i];
    const Vector3 part = mass_fractions(mode, modes);
    const double largest = largest_displacement(mode.shape);
    // A damped rigid mode has no critical damping to compare with.
    const std::string damping =
        std::isfinite(mode.damping_ratio) ? fmt::format("{:.17g}", mode.damping_ratio) : "";
    text += fmt::format("{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.17g}\n", i + 1,
                        signed_frequency(mode), mode.omega_squared, part.x(), part.y(), part.z(),
                        1.0 / (largest * largest), to_string(mode.kind), damping, mode.growth_rate);
  }
  return text;
}

}  // namespace

Vector3 mass_fractions(const NormalMode& mode, const NormalModes& modes) {
  Vector3 part = Vector3::Zero();
  for (int d = 0; d < 3; ++d) {
    if (modes.moved_mass[d] > 0.0) part[d] = mode.effective_mass[d] / modes.moved_mass[d];
  }
  return part;
}

double signed_frequency(const NormalMode& mode) {
  return mode.kind == ModeKind::kUnstable ? -mode.frequency() : mode.frequency();
}

void remove_modes(const std::string& directory) {
  const fs::path root(directory);
  const std::string swing = (root / kSwing).string();
  if (is_entry(swing)) make_own_directory(swing);  // refuses a link
  try {
    std::vector<fs::path> old;
    for (const fs::path& folder : {root, root / kSwing}) {
      std::error_code error;
      if (!fs::is_directory(folder, error)) continue;
      for (const auto& entry : fs::directory_iterator(folder)) {
        fs::path file = entry.path();
        if (file.extension() == ".part") file.replace_extension();
        const std::string ending = file.extension().string();
        if (file.filename().string().rfind("mode_", 0) == 0 &&
            (ending == ".vtu" || (ending == ".pvd" && folder == root))) {
          old.push_back(entry.path());
        }
      }
    }
    for (const fs::path& file : old) fs::remove(file);
    for (const char* name : {"modes.csv", "summary.json"}) remove_output((root / name).string());
    std::error_code not_empty;  // something else is in it
    fs::remove(root / kSwing, not_empty);
  } catch (const fs::filesystem_error& error) {
    throw OutputError(
        fmt::format("{}: the earlier modes cannot be removed ({}). Choose another directory.",
                    directory, error.code().message()));
  }
}

void write_modes(const MechanicalSystem& system, const Vector& q, const NormalModes& modes,
                 const std::string& directory) {
  remove_modes(directory);
  const TetMesh& mesh = system.mesh();
  const Vector offset = q - mesh.rest_positions();
  const double amplitude = kAmplitude * diagonal_of(q);
  const auto whole = make_grid(mesh);
  const Surface surface(mesh);
  make_own_directory(directory + "/" + kSwing);
  for (std::size_t i = 0; i < modes.modes.size(); ++i) {
    const NormalMode& mode = modes.modes[i];
    const std::string name = "mode_" + number_text(i + 1, modes.modes.size());
    const Vector shape = mode.shape / largest_displacement(mode.shape);
    auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
    grid->ShallowCopy(whole);
    grid->GetPointData()->AddArray(
        make_array("mode", Matrix(shape.reshaped(3, mesh.vertex_count())), false));
    if (!offset.isZero(0.0)) {
      grid->GetPointData()->AddArray(
          make_array("displacement", Matrix(offset.reshaped(3, mesh.vertex_count())), false));
    }
    write_vtu(grid, directory + "/" + name + ".vtu");

    // Each displacement is passed twice in a period, except the two largest ones. Pictures of the
    // same displacement share a file.
    constexpr int kQuarter = kPictures / 4;
    for (int k = -kQuarter; k <= kQuarter; ++k) {
      const double phase = 2.0 * std::numbers::pi * k / kPictures;
      const Vector moved = offset + amplitude * std::sin(phase) * shape;
      surface.write(moved,
                    fmt::format("{}/{}/{}_{:02}.vtu", directory, kSwing, name, k + kQuarter));
    }
    const double period = is_vibration(mode.kind) ? 1.0 / mode.frequency() : 1.0;
    std::string entries;
    for (int k = 0; k < kPictures; ++k) {
      int level = k;  // sin(2πk/24) = sin(2π level/24) with a level from −6 to 6
      if (k > 3 * kQuarter) {
        level = k - kPictures;
      } else if (k > kQuarter) {
        level = 2 * kQuarter - k;
      }
      entries += collection_entry(period * k / kPictures,
                                  fmt::format("{}/{}_{:02}.vtu", kSwing, name, level + kQuarter));
    }
    write_collection(entries, directory + "/" + name + ".pvd");
  }
  write_text_file(directory + "/modes.csv", modes_csv(modes));
}

std::string modes_summary_json(const MechanicalSystem& system, const NormalModes& modes,
                               const std::string& echo, const std::string& directory,
                               double seconds) {
  const TetMesh& mesh = system.mesh();
  nlohmann::ordered_json json;
  json["version"] = version();
  json["command"] = "modes";
  json["mesh"] = {{"source", mesh.source},
                  {"vertices", mesh.vertex_count()},
                  {"tetrahedra", mesh.tetrahedron_count()},
                  {"volume", mesh.total_volume()}};
  json["mass"] = system.total_mass();
  json["degrees_of_freedom"] = {{"all", system.dof_count()},
                                {"free", system.coordinates().count()}};
  json["modes_of_the_body"] = modes.total;
  json["moved_mass"] = {modes.moved_mass.x(), modes.moved_mass.y(), modes.moved_mass.z()};
  json["modes"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < modes.modes.size(); ++i) {
    const NormalMode& mode = modes.modes[i];
    const Vector3 part = mass_fractions(mode, modes);
    json["modes"].push_back({{"mode", i + 1},
                             {"kind", to_string(mode.kind)},
                             {"frequency", signed_frequency(mode)},
                             {"effective_mass", {part.x(), part.y(), part.z()}}});
    if (is_vibration(mode.kind)) json["modes"].back()["damping_ratio"] = mode.damping_ratio;
    if (mode.growth_rate > 0.0) json["modes"].back()["growth_rate"] = mode.growth_rate;
    if (mode.round_off > 0.0) json["modes"].back()["round_off"] = mode.round_off;
  }
  json["seconds"] = seconds;
  if (!echo.empty()) {
    json["scene"] = nlohmann::ordered_json::parse(echo);
    json["scene"]["output"]["directory"] = directory;
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace tetraction
