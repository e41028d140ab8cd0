#include "replay.h"

#include <fmt/format.h>

#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QXmlStreamReader>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "core/quoting.h"
#include "io/results/run_files.h"
#include "io/text/text_scanner.h"
#include "io/vtk/obstacle_grid.h"
#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/mesh_reader.h"
#include "viewer/snapshot_maker.h"

namespace tetraction::viewer {
namespace {

namespace fs = std::filesystem;

// Three values per vertex. They are zero if the frame does not have the array.
Vector vectors(const Matrix& array, Index vertices) {
  if (array.rows() != 3) return Vector::Zero(3 * vertices);
  return array.reshaped();
}

// Whether there is a file of that name. What cannot be read, such as a link to itself, counts as one: its
// reader says what is wrong.
bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) || error;
}

// A message that says why a directory without frames.pvd cannot be replayed and what to open instead.
std::string why_no_frames(const fs::path& directory) {
  if (is_there(directory / "history.csv")) {
    return "this run of a study has written no frames. Repeat the study with --frames all, or with "
           "--frames and the name of this folder.";
  }
  return "there is no frames.pvd in it. Give the output directory of a run, or a scene.";
}

constexpr std::size_t kLargestTable = std::size_t{1} << 30U;

// A whole number of a table; −1 for what is none.
Index whole_number(double value) {
  constexpr double kLargest = 9e15;
  return std::abs(value) <= kLargest && value == std::floor(value) ? static_cast<Index>(value) : -1;
}

// The numbers of a CSV file. Empty cells and texts are NaN.
struct Table {
  std::string path;
  std::map<std::string, std::size_t> place;  // of the columns, by their names
  std::vector<std::vector<double>> rows;

  std::size_t column(const std::string& name) const {
    const auto found = place.find(name);
    if (found != place.end()) return found->second;
    throw FileError(fmt::format("{}:1: there is no column \"{}\".", path, name));
  }
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return cells;
}

Table read_table(const std::string& path) {
  Table table;
  table.path = path;
  std::istringstream in(read_file(path, kLargestTable));
  std::string line;
  std::getline(in, line);
  for (const std::string& name : cells_of(line)) table.place.emplace(name, table.place.size());
  for (int number = 2; std::getline(in, line); ++number) {
    std::vector<double> values;
    for (const std::string& cell : cells_of(line)) {
      values.push_back(std::numeric_limits<double>::quiet_NaN());
      // Not by strtod(), for which Qt chooses the user's decimal separator.
      std::from_chars(cell.data(), cell.data() + cell.size(), values.back());
    }
    if (values.size() < table.place.size()) {
      if (in.eof()) break;  // the incomplete last line of a run that was killed
      throw FileError(fmt::format("{}:{}: it has {} columns of {}.", path, number, values.size(),
                                  table.place.size()));
    }
    table.rows.push_back(std::move(values));
  }
  return table;
}

// The probes of the scene in summary.json: their names and quantities. None if the file is missing.
std::vector<ProbeSettings> probes_of_summary(const std::string& path) {
  std::string text;
  try {
    text = read_file(path, kLargestTable);
  } catch (const FileError&) {
    return {};
  }
  const QJsonObject summary =
      QJsonDocument::fromJson(QByteArray::fromRawData(text.data(), static_cast<int>(text.size())))
          .object();
  const QJsonObject scene = summary[QLatin1String("scene")].toObject();
  const QJsonArray entries = scene[QLatin1String("probe")].toArray();
  std::vector<ProbeSettings> probes;
  for (const QJsonValue& entry : entries) {
    ProbeSettings probe;
    probe.name = entry[QLatin1String("name")].toString().toStdString();
    const std::string quantity = entry[QLatin1String("quantity")].toString().toStdString();
    probe.quantity = find_named<ProbeQuantity>(quantity).value_or(probe.quantity);
    probes.push_back(std::move(probe));
  }
  return probes;
}

HistoryRow row_without_history(Index step, double time) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  HistoryRow row;
  for (double* number : numbers_of(row)) *number = kNaN;
  row.step = step;
  row.time = time;
  return row;
}

}  // namespace

Replay::Replay(const std::string& path) {
  fs::path collection = path;
  std::error_code error;
  if (fs::is_directory(collection, error)) collection /= "frames.pvd";
  directory_ = fs::absolute(collection).parent_path().string();
  if (!is_there(collection)) throw FileError(path + ": " + why_no_frames(path));
  read_collection(collection.string());
  mesh_ = read_mesh(files_.front());
  rest_ = mesh_.rest_positions();
  const fs::path history = fs::path(directory_) / "history.csv";
  if (is_there(history)) read_history(history.string());
  const fs::path probes = fs::path(directory_) / "probes.csv";
  if (is_there(probes)) read_probes(probes.string());
}

void Replay::read_collection(const std::string& path) {
  const std::string text = read_file(path, kLargestTable);
  QXmlStreamReader xml(QByteArray::fromRawData(text.data(), static_cast<int>(text.size())));
  while (!xml.atEnd()) {
    if (xml.readNext() != QXmlStreamReader::StartElement ||
        xml.name() != QLatin1String("DataSet")) {
      continue;
    }
    bool is_number = false;
    const double time = xml.attributes().value(QLatin1String("timestep")).toDouble(&is_number);
    const std::string name = xml.attributes().value(QLatin1String("file")).toString().toStdString();
    if (!is_number || !std::isfinite(time) || name.empty()) {
      throw FileError(
          fmt::format("{}:{}: an entry without a time or a file.", path, xml.lineNumber()));
    }
    const fs::path file = fs::path(directory_) / name;
    if (is_obstacle_frame_name(file.filename().string())) {
      // They follow the frame that they belong to.
      if (!obstacle_files_.empty()) obstacle_files_.back() = file.string();
      continue;
    }
    times_.push_back(time);
    files_.push_back(file.string());
    obstacle_files_.emplace_back();
  }
  if (xml.hasError()) {
    throw FileError(
        fmt::format("{}:{}: {}", path, xml.lineNumber(), excerpt(xml.errorString().toStdString())));
  }
  if (files_.empty()) throw FileError(fmt::format("{}: it lists no frames.", path));
}

void Replay::read_history(const std::string& path) {
  const Table table = read_table(path);
  // The history of an equilibrium has no columns of a motion (docs/outputs.md).
  if (table.place.count("max_displacement") > 0) kind_ = RunKind::kEquilibrium;
  const auto column = [&](const std::string& name) {
    const bool is_absent = kind_ == RunKind::kEquilibrium && table.place.count(name) == 0;
    return is_absent ? std::nullopt : std::optional(table.column(name));
  };
  const auto step = column("step");
  std::vector<std::optional<std::size_t>> columns;
  for (const std::string& name : cells_of(kHistoryNumbers)) columns.push_back(column(name));
  const auto iterations = column("iterations");
  for (const std::vector<double>& values : table.rows) {
    const auto at = [&](const std::optional<std::size_t>& place) {
      return place ? values[*place] : std::numeric_limits<double>::quiet_NaN();
    };
    HistoryRow row;
    row.step = whole_number(at(step));
    const auto numbers = numbers_of(row);
    for (std::size_t i = 0; i < numbers.size(); ++i) *numbers[i] = at(columns[i]);
    row.iterations =
        static_cast<int>(std::clamp<Index>(whole_number(at(iterations)), 0, 1'000'000));
    history_.push_back(row);
  }
}

// Adds the values to the rows of the history with the same step.
void Replay::read_probes(const std::string& path) {
  const Table table = read_table(path);
  probes_ = chart_probes(probes_of_summary(directory_ + "/summary.json"));
  const auto is_there = [&](const ChartProbe& probe) {
    return std::all_of(probe.columns.begin(), probe.columns.end(),
                       [&](const std::string& name) { return table.place.count(name) > 0; });
  };
  if (probes_.empty() || !std::all_of(probes_.begin(), probes_.end(), is_there)) {
    // The summary of a run that was killed is missing: each column is shown alone.
    probes_.clear();
    std::vector<std::string> names(table.place.size());
    for (const auto& [name, place] : table.place) names[place] = name;
    for (const std::string& name : names) {
      if (name == "step" || name == "time") continue;
      probes_.push_back({name, name, "", probes_.size(), {name}});
    }
  }
  std::vector<std::size_t> columns;
  for (const ChartProbe& probe : probes_) {
    for (const std::string& name : probe.columns) columns.push_back(table.column(name));
  }
  const std::size_t step_column = table.column("step");
  const std::size_t time_column = table.column("time");
  std::vector<HistoryRow> merged;
  auto old = history_.begin();
  for (const std::vector<double>& values : table.rows) {
    const Index step = whole_number(values[step_column]);
    while (old != history_.end() && old->step < step) merged.push_back(std::move(*old++));
    HistoryRow row = old != history_.end() && old->step == step
                         ? std::move(*old++)
                         : row_without_history(step, values[time_column]);
    for (const std::size_t column : columns) row.probes.push_back(values[column]);
    merged.push_back(std::move(row));
  }
  merged.insert(merged.end(), old, history_.end());
  history_ = std::move(merged);
}

// Without the positions and forces of the body.
Snapshot Replay::snapshot_at(std::size_t i) const {
  Snapshot snapshot;
  snapshot.generation = i + 1;
  snapshot.body = 1;
  snapshot.time = times_[i];
  snapshot.step = static_cast<Index>(i);
  return snapshot;
}

std::shared_ptr<const ObstacleSurface> Replay::obstacles_at(std::size_t i) const {
  const std::string& path = obstacle_files_[i];
  if (path.empty()) return nullptr;
  if (path != obstacles_from_) {
    obstacles_ = read_obstacle_file(path);
    obstacles_from_ = path;
  }
  return obstacles_;
}

std::size_t Replay::frame_at(double time) const {
  const auto next = std::lower_bound(times_.begin(), times_.end(), time);
  const auto i = static_cast<std::size_t>(next - times_.begin());
  if (i == 0) return 0;
  return next == times_.end() || time - times_[i - 1] < *next - time ? i - 1 : i;
}

std::shared_ptr<const Snapshot> Replay::frame(std::size_t i, ColorField field) const {
  if (motion_) return frame_of_mode(i, field);
  const std::string& path = files_[i];
  std::vector<std::string> point_names{"displacement",   "velocity",       "momentum",
                                       "external_force", "reaction_force", "fixed",
                                       "contact_force"};
  std::vector<std::string> cell_names;
  const Quantity* drawn =
      field != nullptr ? &drawn_quantity(*field, mesh_.is_quadratic()) : nullptr;
  if (drawn != nullptr && drawn->domain == ValueDomain::kVertices) {
    point_names.emplace_back(drawn->name);
  }
  if (drawn != nullptr && field->domain == ValueDomain::kTetrahedra) {
    cell_names.emplace_back(field->name);
  }
  const StoredFrame frame = read_frame(path, point_names, cell_names);
  const Index n = mesh_.vertex_count();
  const Index m = mesh_.tetrahedron_count();
  if (frame.vertex_count != n || frame.tetrahedron_count != m) {
    throw FileError(
        fmt::format("{}: {} vertices and {} tetrahedra, but the first frame has {} and "
                    "{}: the frames are not of one run.",
                    path, frame.vertex_count, frame.tetrahedron_count, n, m));
  }
  if (frame.point_arrays[0].rows() != 3) {
    throw FileError(fmt::format(
        "{}: it has no displacements, so that the motion cannot be drawn. Run the scene "
        "again with \"displacement\" in output.fields.",
        path));
  }
  if (!frame.point_arrays[0].allFinite()) {
    throw FileError(path + ": a displacement is not finite, so that the body cannot be drawn.");
  }
  auto snapshot = std::make_shared<Snapshot>(snapshot_at(i));
  const auto row = std::find_if(history_.begin(), history_.end(), [&](const HistoryRow& r) {
    return r.time >= times_[i] - 1e-9 * (1.0 + std::abs(times_[i]));
  });
  if (row != history_.end()) snapshot->step = row->step;
  const Vector displacement = vectors(frame.point_arrays[0], n);
  snapshot->position = rest_ + displacement;
  snapshot->velocity = vectors(frame.point_arrays[1], n);
  snapshot->momentum = vectors(frame.point_arrays[2], n);
  snapshot->external_force = vectors(frame.point_arrays[3], n);
  snapshot->reaction_force = vectors(frame.point_arrays[4], n);
  if (frame.point_arrays[6].rows() == 3)
    snapshot->contact_force = vectors(frame.point_arrays[6], n);
  snapshot->obstacles = obstacles_at(i);
  const Matrix& fixed = frame.point_arrays[5];
  snapshot->fixed.assign(static_cast<std::size_t>(n), 0);
  for (Index v = 0; v < fixed.cols(); ++v) {
    snapshot->fixed[static_cast<std::size_t>(v)] = fixed(0, v) != 0.0;
  }
  snapshot->field = field;
  if (drawn == nullptr) return snapshot;
  // Frames without the values of the vertices are drawn with those of the tetrahedra.
  const bool has_points =
      drawn->domain == ValueDomain::kVertices && frame.point_arrays.back().rows() > 0;
  snapshot->field_on_cells = !has_points && !cell_names.empty();
  if (has_points) snapshot->field_values = color_values(frame.point_arrays.back(), field.component);
  if (snapshot->field_on_cells)
    snapshot->field_values = color_values(frame.cell_arrays[0], field.component);
  return snapshot;
}

}  // namespace tetraction::viewer
