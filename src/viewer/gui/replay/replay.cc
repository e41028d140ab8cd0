#include "replay.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <QFile>
#include <QXmlStreamReader>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "io/text/text_scanner.h"
#include "io/vtk/quiet_vtk.h"
#include "io/vtk/vtk_header.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"

namespace tetraction::viewer {
namespace {

namespace fs = std::filesystem;

// 3 per vertex; zeros where the frame has no such array.
Vector point_vectors(vtkUnstructuredGrid* grid, const char* name, Index vertices) {
  Vector values = Vector::Zero(3 * vertices);
  vtkDataArray* array = grid->GetPointData()->GetArray(name);
  if (array == nullptr || array->GetNumberOfComponents() != 3) return values;
  for (Index v = 0; v < vertices; ++v) array->GetTuple(v, values.data() + 3 * v);
  return values;
}

// The cell array of a frame that holds a field; null for fields of vertices, which follow from what a
// frame has anyway.
const char* cell_array_name(ColorField field) {
  switch (field) {
    case ColorField::kVonMises:
      return "von_mises";
    case ColorField::kEnergyDensity:
      return "energy_density";
    case ColorField::kJacobian:
      return "jacobian";
    case ColorField::kRegion:
      return "region";
    default:
      return nullptr;
  }
}

// Why a directory without frames.pvd cannot be replayed, and what can.
std::string why_no_frames(const fs::path& directory) {
  if (fs::exists(directory / "study.json")) {
    std::vector<std::string> runs;
    for (const auto& entry : fs::directory_iterator(directory)) {
      if (fs::exists(entry.path() / "frames.pvd")) runs.push_back(entry.path().string());
    }
    std::sort(runs.begin(), runs.end());
    if (runs.empty()) {
      return "this study has written no frames. Repeat it with --frames all, or with the names of "
             "the runs to look at.";
    }
    return fmt::format(
        "this is a study of several runs. Give the folder of one that has frames: {}.",
        fmt::join(runs, ", "));
  }
  if (fs::exists(directory / "history.csv")) {
    return "this run of a study has written no frames. Repeat the study with --frames and the name "
           "of this folder.";
  }
  return "there is no frames.pvd in it. Give the output directory of a run, or a scene.";
}

void set_magnitudes(Snapshot& snapshot, const Vector& field) {
  for (Index v = 0; v < field.size() / 3; ++v) {
    snapshot.field_values.push_back(static_cast<float>(field.segment<3>(3 * v).norm()));
  }
}

}  // namespace

Replay::Replay(const std::string& path) {
  fs::path collection = path;
  if (fs::is_directory(collection)) collection /= "frames.pvd";
  directory_ = fs::absolute(collection).parent_path().string();
  if (!fs::exists(collection)) throw FileError(path + ": " + why_no_frames(path));
  read_collection(collection.string());
  mesh_ = read_mesh(files_.front());
  rest_ = mesh_.rest_positions();
  const fs::path history = fs::path(directory_) / "history.csv";
  if (fs::exists(history)) read_history(history.string());
}

void Replay::read_collection(const std::string& path) {
  QFile file(QString::fromStdString(path));
  if (!file.open(QIODevice::ReadOnly)) {
    throw FileError(
        fmt::format("{}: cannot be read ({}).", path, file.errorString().toStdString()));
  }
  QXmlStreamReader xml(&file);
  while (!xml.atEnd()) {
    if (xml.readNext() != QXmlStreamReader::StartElement ||
        xml.name() != QLatin1String("DataSet")) {
      continue;
    }
    bool is_number = false;
    times_.push_back(xml.attributes().value(QLatin1String("timestep")).toDouble(&is_number));
    const std::string name = xml.attributes().value(QLatin1String("file")).toString().toStdString();
    if (!is_number || name.empty()) {
      throw FileError(
          fmt::format("{}:{}: an entry without a time or a file.", path, xml.lineNumber()));
    }
    files_.push_back((fs::path(directory_) / name).string());
  }
  if (xml.hasError()) {
    throw FileError(
        fmt::format("{}:{}: {}.", path, xml.lineNumber(), xml.errorString().toStdString()));
  }
  if (files_.empty()) throw FileError(fmt::format("{}: it lists no frames.", path));
}

void Replay::read_history(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  std::map<std::string, std::size_t> place;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) place.emplace(name, place.size());
  const char* const needed[] = {"step",
                                "time",
                                "kinetic_energy",
                                "elastic_energy",
                                "environment_energy",
                                "total_energy",
                                "external_work",
                                "constraint_work",
                                "dissipated_energy",
                                "edit_work",
                                "energy_error",
                                "px",
                                "py",
                                "pz",
                                "lx",
                                "ly",
                                "lz",
                                "iterations"};
  std::vector<std::size_t> columns;
  for (const char* name : needed) {
    const auto found = place.find(name);
    if (found == place.end()) {
      throw FileError(fmt::format("{}:1: there is no column \"{}\".", path, name));
    }
    columns.push_back(found->second);
  }
  for (int number = 2; std::getline(in, line); ++number) {
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      char* end = nullptr;
      values.push_back(std::strtod(cell.c_str(), &end));
      if (end == cell.c_str()) values.back() = std::numeric_limits<double>::quiet_NaN();
    }
    if (values.size() < place.size()) {
      if (in.eof()) break;  // the last line of a run that was cut off
      throw FileError(fmt::format("{}:{}: it has {} columns of {}.", path, number, values.size(),
                                  place.size()));
    }
    const auto at = [&](std::size_t i) { return values[columns[i]]; };
    HistoryRow row;
    row.step = static_cast<Index>(at(0));
    row.time = at(1);
    row.kinetic = at(2);
    row.elastic = at(3);
    row.environment = at(4);
    row.total = at(5);
    row.external_work = at(6);
    row.constraint_work = at(7);
    row.dissipated_energy = at(8);
    row.edit_work = at(9);
    row.energy_error = at(10);
    row.linear_momentum = {at(11), at(12), at(13)};
    row.angular_momentum = {at(14), at(15), at(16)};
    row.iterations = static_cast<int>(at(17));
    history_.push_back(row);
  }
}

std::shared_ptr<const Snapshot> Replay::frame(std::size_t i, ColorField field) const {
  const std::string& path = files_[i];
  // What VTK's reader would crash on is refused before it sees the file.
  check_xml_header(path, read_file(path));
  VtkMessages messages;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  messages.watch(reader);
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  const Index n = mesh_.vertex_count();
  const Index m = mesh_.tetrahedron_count();
  if (!messages.empty()) throw FileError(fmt::format("{}: {}", path, messages.first()));
  if (grid->GetNumberOfPoints() != n || grid->GetNumberOfCells() != m) {
    throw FileError(
        fmt::format("{}: {} vertices and {} tetrahedra, but the first frame has {} and "
                    "{}: the frames are not of one run.",
                    path, grid->GetNumberOfPoints(), grid->GetNumberOfCells(), n, m));
  }
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->generation = i + 1;
  snapshot->body = 1;
  snapshot->time = times_[i];
  const auto row = std::find_if(history_.begin(), history_.end(), [&](const HistoryRow& r) {
    return r.time >= times_[i] - 1e-9 * (1.0 + std::abs(times_[i]));
  });
  snapshot->step = row == history_.end() ? static_cast<Index>(i) : row->step;
  const Vector displacement = point_vectors(grid, "displacement", n);
  snapshot->position = rest_ + displacement;
  snapshot->velocity = point_vectors(grid, "velocity", n);
  snapshot->momentum = point_vectors(grid, "momentum", n);
  snapshot->external_force = point_vectors(grid, "external_force", n);
  snapshot->reaction_force = point_vectors(grid, "reaction_force", n);
  snapshot->fixed.assign(static_cast<std::size_t>(n), 0);
  if (vtkDataArray* fixed = grid->GetPointData()->GetArray("fixed")) {
    for (Index v = 0; v < n; ++v) {
      snapshot->fixed[static_cast<std::size_t>(v)] = fixed->GetComponent(v, 0) != 0.0;
    }
  }
  snapshot->field = field;
  if (field == ColorField::kDisplacement) set_magnitudes(*snapshot, displacement);
  if (field == ColorField::kSpeed) set_magnitudes(*snapshot, snapshot->velocity);
  if (const char* name = cell_array_name(field)) {
    snapshot->field_on_cells = true;
    if (vtkDataArray* array = grid->GetCellData()->GetArray(name)) {
      for (Index e = 0; e < m; ++e) {
        snapshot->field_values.push_back(static_cast<float>(array->GetComponent(e, 0)));
      }
    }
  }
  return snapshot;
}

}  // namespace tetraction::viewer
