#include "stored_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "io/text/foreign_json.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/mesh_reader.h"

namespace tetraction::viewer {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<StoredMode> modes_of_summary(const std::string& path) {
  constexpr std::size_t kLargest = std::size_t{1} << 28U;
  const ForeignJson summary = parse_foreign_json(read_file(path, kLargest));
  const ForeignJson& list = member_of(summary, "modes");
  if (member_of(summary, "command") != "modes" || !list.is_array() || list.empty()) {
    throw FileError(path + ": it is no summary of natural modes. Compute them again.");
  }
  std::vector<StoredMode> modes;
  for (const ForeignJson& entry : list) {
    const ForeignJson& kind = member_of(entry, "kind");
    StoredMode& mode = modes.emplace_back();
    mode.frequency = number_or(member_of(entry, "frequency"), kUnknown);
    if (!kind.is_string() || !std::isfinite(mode.frequency)) {
      throw FileError(fmt::format(
          "{}: mode {} has no kind or no frequency. Compute the modes again.", path, modes.size()));
    }
    mode.kind = kind.get<std::string>();
    for (std::size_t d = 0; d < 3; ++d) {
      const ForeignJson& part = entry_of(member_of(entry, "effective_mass"), d);
      mode.effective_mass[static_cast<Index>(d)] = number_or(part, kUnknown);
    }
    mode.damping_ratio = number_or(member_of(entry, "damping_ratio"), kUnknown);
  }
  return modes;
}

}  // namespace

Vector ModeMotion::displacement(double phase) const {
  return amplitude * diagonal * std::sin(2.0 * std::numbers::pi * phase) * shape;
}

StoredModes::StoredModes(std::string directory)
    : directory_(std::move(directory)), modes_(modes_of_summary(directory_ + "/summary.json")) {
  mesh_ = read_mesh(file_of(0));
}

// The names have as many digits as the largest number needs, two at least.
std::string StoredModes::file_of(std::size_t mode) const {
  const std::size_t digits = std::max<std::size_t>(2, std::to_string(modes_.size()).size());
  return fmt::format("{}/mode_{:0{}}.vtu", directory_, mode + 1, digits);
}

ModeMotion StoredModes::motion(std::size_t mode) const {
  const std::string path = file_of(mode);
  const StoredFrame frame = read_frame(path, {"mode", "displacement"});
  const Matrix& shape = frame.point_arrays[0];
  const Matrix& offset = frame.point_arrays[1];
  const Index n = mesh_.vertex_count();
  const bool fits = frame.vertex_count == n && frame.tetrahedron_count == mesh_.tetrahedron_count();
  if (!fits || shape.rows() != 3 || !shape.allFinite() ||
      (offset.size() > 0 && offset.rows() != 3) || !offset.allFinite()) {
    throw FileError(path + ": it has no shape of a mode of this body. Compute the modes again.");
  }
  ModeMotion motion;
  motion.middle = mesh_.rest_positions();
  if (offset.size() > 0) motion.middle += offset.reshaped();
  const auto places = motion.middle.reshaped(3, n);
  motion.diagonal = (places.rowwise().maxCoeff() - places.rowwise().minCoeff()).norm();
  const double largest = shape.colwise().norm().maxCoeff();
  motion.shape = shape.reshaped() / (largest > 0.0 ? largest : 1.0);
  return motion;
}

StudyGrid grid_of_modes(const std::vector<StoredMode>& modes) {
  StudyGrid grid;
  grid.column("mode");
  grid.column("kind", true);
  for (const char* head :
       {"frequency [Hz]", "period [s]", "mass x", "mass y", "mass z", "damping"}) {
    grid.column(head);
  }
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const StoredMode& mode = modes[i];
    grid.row();
    grid.number(static_cast<double>(i + 1), "{:.0f}");
    grid.text(mode.kind);
    grid.number(mode.frequency, "{:.6g}");
    // Unstable modes, which have negative numbers, and rigid ones do not come back.
    grid.number(mode.frequency > 0.0 ? 1.0 / mode.frequency : kUnknown, "{:.5g}");
    for (const double part : mode.effective_mass) grid.number(part, "{:.4f}");
    grid.number(mode.damping_ratio, "{:.4g}");
  }
  return grid;
}

}  // namespace tetraction::viewer
