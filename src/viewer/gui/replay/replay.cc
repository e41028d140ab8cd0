#include "replay.h"

#include <fmt/format.h>

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

#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/mesh_reader.h"

namespace tetraction::viewer {
namespace {

namespace fs = std::filesystem;

// Three values per vertex. They are zero if the frame does not have the array.
Vector vectors(const Matrix& array, Index vertices) {
  if (array.rows() != 3) return Vector::Zero(3 * vertices);
  return array.reshaped();
}

// The name of the cell array of a frame that contains a field. Null for fields of vertices, which are
// computed from positions and velocities.
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

// A message that says why a directory without frames.pvd cannot be replayed and what to open instead.
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
      if (in.eof()) break;  // the incomplete last line of a run that was killed
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
  const char* cell_array = cell_array_name(field);
  const StoredFrame frame = read_frame(
      path, {"displacement", "velocity", "momentum", "external_force", "reaction_force", "fixed"},
      cell_array != nullptr ? std::vector<std::string>{cell_array} : std::vector<std::string>{});
  const Index n = mesh_.vertex_count();
  const Index m = mesh_.tetrahedron_count();
  if (frame.vertex_count != n || frame.tetrahedron_count != m) {
    throw FileError(
        fmt::format("{}: {} vertices and {} tetrahedra, but the first frame has {} and "
                    "{}: the frames are not of one run.",
                    path, frame.vertex_count, frame.tetrahedron_count, n, m));
  }
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->generation = i + 1;
  snapshot->body = 1;
  snapshot->time = times_[i];
  const auto row = std::find_if(history_.begin(), history_.end(), [&](const HistoryRow& r) {
    return r.time >= times_[i] - 1e-9 * (1.0 + std::abs(times_[i]));
  });
  snapshot->step = row == history_.end() ? static_cast<Index>(i) : row->step;
  const Vector displacement = vectors(frame.point_arrays[0], n);
  snapshot->position = rest_ + displacement;
  snapshot->velocity = vectors(frame.point_arrays[1], n);
  snapshot->momentum = vectors(frame.point_arrays[2], n);
  snapshot->external_force = vectors(frame.point_arrays[3], n);
  snapshot->reaction_force = vectors(frame.point_arrays[4], n);
  const Matrix& fixed = frame.point_arrays[5];
  snapshot->fixed.assign(static_cast<std::size_t>(n), 0);
  for (Index v = 0; v < fixed.cols(); ++v) {
    snapshot->fixed[static_cast<std::size_t>(v)] = fixed(0, v) != 0.0;
  }
  snapshot->field = field;
  if (field == ColorField::kDisplacement) set_magnitudes(*snapshot, displacement);
  if (field == ColorField::kSpeed) set_magnitudes(*snapshot, snapshot->velocity);
  if (cell_array != nullptr) {
    snapshot->field_on_cells = true;
    const Matrix& values = frame.cell_arrays[0];
    for (Index e = 0; e < values.cols(); ++e) {
      snapshot->field_values.push_back(static_cast<float>(values(0, e)));
    }
  }
  return snapshot;
}

}  // namespace tetraction::viewer
