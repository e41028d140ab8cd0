#include "tetraction/io/checkpoint_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "checkpoint_members.h"
#include "core/fingerprint.h"
#include "io/scene/obstacle_surfaces.h"
#include "io/text/check_sum.h"
#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "simulation/stepping/step_count.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/event_settings.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

// The beginning of a file. It is followed by the size of the numbers, the numbers, and the check sum
// of everything before it.
constexpr std::string_view kMagic = "Tetraction checkpoint\n";
constexpr std::uint32_t kFormat = 8;
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::size_t kBeginSize =
    kMagic.size() + sizeof kFormat + sizeof kByteOrder + sizeof(std::uint64_t);

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw FileError(fmt::format("{}: not a valid checkpoint ({}).", name, what));
}

// Checks the first bytes of a file of this size, and returns the size of the numbers in it.
std::uint64_t checked_size(std::string_view begin, std::uint64_t file_size,
                           const std::string& name) {
  if (!begin.starts_with(kMagic)) refuse(name, "it does not begin as one");
  std::uint32_t format = 0;
  std::uint32_t byte_order = 0;
  std::uint64_t size = 0;
  std::uint64_t sum = 0;
  if (begin.size() < kBeginSize || file_size < kBeginSize + sizeof sum) {
    refuse(name, "it is cut off");
  }
  ArchiveReader in(begin.substr(kMagic.size()));
  in.block(&format, sizeof format);
  in.block(&byte_order, sizeof byte_order);
  in.whole(size);
  if (byte_order != kByteOrder) refuse(name, "it has another byte order, or is damaged");
  if (format != kFormat) {
    refuse(name, fmt::format("it has format {}, and this version of the program reads format {}",
                             format, kFormat));
  }
  if (size != file_size - kBeginSize - sizeof sum) {
    refuse(name, size > file_size ? "it is cut off" : "its size is wrong");
  }
  return size;
}

bool are_finite(std::initializer_list<double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

bool are_counts(std::initializer_list<Index> values) {
  return std::ranges::all_of(
      values, [](Index value) { return value >= 0 && value <= static_cast<Index>(kMostSteps); });
}

bool is_finite(const Momenta& momenta) {
  return momenta.linear.allFinite() && momenta.angular.allFinite();
}

bool is_finite(const Energies& energies) {
  return std::ranges::all_of(energies.entries(),
                             [](const auto& entry) { return std::isfinite(entry.value); });
}

// Any program can write a file with a right check sum. What Session::restore() does not check.
void require_sensible(const Checkpoint& checkpoint) {
  const auto require = [](bool is_right, const char* what) {
    if (!is_right) throw BadBytes{what};
  };
  const State& state = checkpoint.state;
  require(state.velocity.allFinite() && checkpoint.reactions.force.allFinite() &&
              checkpoint.reactions.delay.allFinite() &&
              checkpoint.reactions.configuration_force.allFinite() &&
              checkpoint.progress.external_force.allFinite() &&
              std::ranges::all_of(checkpoint.progress.obstacle_forces,
                                  [](const ObstacleForce& each) {
                                    return each.force.allFinite() && each.moment.allFinite();
                                  }),
          "a velocity or a force is not finite");
  const RunProgress& progress = checkpoint.progress;
  const StepPlan& plan = progress.plan;
  require(are_finite({state.time, plan.time_step, plan.segment_time, progress.first_time_step}) &&
              plan.time_step > 0.0 && progress.first_time_step >= 0.0 &&
              are_counts({state.step, plan.segment_step, plan.segment_count}) &&
              plan.segment_step <= state.step,
          "its steps are out of range");
  const AutomaticStepMemory& automatic = plan.automatic;
  require(
      are_counts({automatic.last, automatic.next, automatic.interval}) &&
          automatic.critical_step >= 0.0 && automatic.modes.stiffness.allFinite() &&
          automatic.modes.damping.allFinite() &&
          are_finite({automatic.rate, automatic.elastic_energy, automatic.sensitivity,
                      automatic.elastic_energy_at_estimate, automatic.largest_change,
                      plan.adaptive.last_error, plan.adaptive.energy, plan.adaptive.half_work}) &&
          std::ranges::none_of(automatic.recent, [](double limit) { return !(limit >= 0.0); }),
      "what it remembers of its steps is out of range");
  const StepControl& control = progress.control;
  require(are_counts({progress.steps.changes, progress.inverted.now, progress.inverted.most,
                      progress.inverted.most_step, progress.total_iterations,
                      progress.total_factorizations, progress.total_cg_iterations, control.retried,
                      control.rejected, control.failed, control.above_tolerance,
                      control.without_solution, control.last_rejected, control.last_substeps,
                      checkpoint.balance.limited_steps}),
          "one of its counts is out of range");
  const BalanceSums& sums = checkpoint.balance;
  require(is_finite(sums.initial_energies) && is_finite(sums.energies) &&
              is_finite(sums.initial_momenta) && is_finite(sums.momenta) &&
              sums.linear_impulse.allFinite() && sums.angular_impulse.allFinite() &&
              are_finite({sums.external_work, sums.dissipated_energy, sums.constraint_work,
                          sums.edit_work, sums.residual_angular_impulse, sums.round_off}),
          "its balance is not finite");
}

// The same for the objects of constraints.
void require_consistent(const Checkpoint& checkpoint) {
  const Index vertex_count = checkpoint.state.position.size() / 3;
  const auto require = [](bool is_right) {
    if (!is_right) throw BadBytes{"its constraints contradict themselves"};
  };
  const auto require_vertices = [&](const std::vector<Index>& vertices, const Matrix& points) {
    require(static_cast<Index>(vertices.size()) == points.cols() && points.allFinite());
    for (const Index v : vertices) require(v >= 0 && v < vertex_count);
  };
  const auto check_held = [&](const PrescribedVertices& held) {
    require_vertices(held.vertices, held.start);
    const PrescribedMotion& motion = held.motion;
    require(are_finite({motion.since, held.penalty}) && held.penalty >= 0.0 &&
            motion.velocity.allFinite() && motion.angular_velocity.allFinite() &&
            motion.center.allFinite() && motion.offset.allFinite());
  };
  for (const BodyObstacle& obstacle : checkpoint.settings.obstacles) {
    const ObstacleStart& start = obstacle.start;
    constexpr double kOrthonormal = 1e-6;
    if (!are_finite({start.time, start.stiffness}) || !start.way.allFinite() ||
        !start.frame.shift.allFinite() || !(start.stiffness >= 0.0) ||
        !start.frame.rotation.isUnitary(kOrthonormal)) {
      throw BadBytes{"its obstacles contradict themselves"};
    }
  }
  const BodyConstraints& constraints = checkpoint.settings.constraints;
  std::ranges::for_each(constraints.fixes, check_held);
  for (const ConstraintObject& object : constraints.others) {
    if (const auto* held = std::get_if<PrescribedVertices>(&object)) check_held(*held);
    if (const auto* guided = std::get_if<GuidedVertices>(&object)) {
      require_vertices(guided->vertices, guided->points);
      const Matrix& d = guided->directions;
      constexpr double kOrthonormal = 1e-6;
      require((d.cols() == 1 || d.cols() == 2) && (d.transpose() * d).isIdentity(kOrthonormal));
    }
    if (const auto* distance = std::get_if<FixedDistance>(&object)) {
      for (const Index v : {distance->a, distance->b}) require(v >= 0 && v < vertex_count);
      require(std::isfinite(distance->length) && distance->length > 0.0);
    }
    if (const auto* handle = std::get_if<RigidHandle>(&object)) {
      require_vertices(handle->vertices, handle->shape);
    }
  }
}

// Adds the paths of the values that differ below a key.
void compare(const ForeignJson& a, const ForeignJson& b, const std::string& key,
             std::vector<std::string>& keys) {
  if (a == b) return;
  if (key == "output" || key == "solver.engine" || key.ends_with(".file")) return;
  const auto below = [&](const std::string& name) { return key.empty() ? name : key + '.' + name; };
  if (a.is_object() && b.is_object()) {
    ForeignJson names = ForeignJson::object();
    for (const auto& [name, value] : a.items()) names[name] = nullptr;
    for (const auto& [name, value] : b.items()) names[name] = nullptr;
    for (const auto& [name, value] : names.items()) {
      compare(a.value(name, ForeignJson()), b.value(name, ForeignJson()), below(name), keys);
    }
  } else if (a.is_array() && b.is_array() && a.size() == b.size() && !a.empty() &&
             a[0].is_structured()) {
    for (std::size_t i = 0; i < a.size(); ++i) compare(a[i], b[i], below(std::to_string(i)), keys);
  } else {
    keys.push_back(key);
  }
}

constexpr const char* kFolder = "checkpoints";
constexpr std::string_view kRegular = "step_";
constexpr std::string_view kStopped = "stop_";
constexpr std::string_view kEnding = ".ckpt";

// A folder that somebody has given the name of a checkpoint is left alone.
bool is_folder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(fs::symlink_status(path, error));
}

}  // namespace

RunInputs inputs_of(const Session& session) {
  const MeshFingerprints mesh = fingerprints_of(session.system().mesh());
  Fingerprint amplitudes;
  for (const AmplitudeSettings& amplitude : session.scene().amplitude) {
    amplitudes.add(amplitude.name);
    for (const auto& [time, value] : amplitude.points) {
      amplitudes.add(time);
      amplitudes.add(value);
    }
  }
  Fingerprint surfaces;
  add_surfaces(session.scene(), surfaces);
  return {session.scene().echo, mesh.numbers, mesh.fields, amplitudes.value(), surfaces.value()};
}

int process_count(const Session& session) {
  const MeshPart* part = session.system().part();
  return part == nullptr ? 1 : part->count();
}

std::vector<std::string> changed_keys(const std::string& scene, const std::string& other) {
  const ForeignJson a = parse_foreign_json(scene);
  const ForeignJson b = parse_foreign_json(other);
  std::vector<std::string> keys;
  if (a.is_discarded() || b.is_discarded()) {
    if (scene != other) keys.emplace_back("the scene");
    return keys;
  }
  compare(a, b, "", keys);
  return keys;
}

bool can_be_stored(const Checkpoint& checkpoint) {
  return checkpoint.progress.edits.size() == checkpoint.progress.next_event;
}

std::string checkpoint_bytes(const StoredCheckpoint& stored) {
  if (!can_be_stored(stored.checkpoint)) {
    throw InputError(
        "A run with other edits than the events of its scene cannot be stored in a checkpoint "
        "file: make the edits events.");
  }
  ArchiveWriter numbers;
  const State& state = stored.checkpoint.state;
  numbers.reserve(static_cast<std::size_t>(8 * state.position.size()) * sizeof(double) + 4096);
  transfer(numbers, stored);
  ArchiveWriter file;
  file.reserve(kBeginSize + numbers.bytes().size() + sizeof(std::uint64_t));
  file.block(kMagic.data(), kMagic.size());
  file.block(&kFormat, sizeof kFormat);
  file.block(&kByteOrder, sizeof kByteOrder);
  file.whole(numbers.bytes().size());
  file.block(numbers.bytes().data(), numbers.bytes().size());
  file.whole(std::uint64_t{check_sum(file.bytes())});
  return file.take();
}

StoredCheckpoint checkpoint_from_bytes(std::string_view bytes, const std::string& name) {
  const std::uint64_t size = checked_size(bytes, bytes.size(), name);
  std::uint64_t sum = 0;
  ArchiveReader(bytes.substr(bytes.size() - sizeof sum)).whole(sum);
  if (sum != check_sum(bytes.substr(0, bytes.size() - sizeof sum))) {
    refuse(name, "it is damaged: its check sum is wrong");
  }
  StoredCheckpoint stored;
  try {
    ArchiveReader numbers(bytes.substr(kBeginSize, size));
    transfer(numbers, stored);
    if (!numbers.at_end()) refuse(name, "there is more in it than it should have");
    require_sensible(stored.checkpoint);
    require_consistent(stored.checkpoint);
    constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (stored.files.history_size > kMost || stored.files.probes_size > kMost) {
      throw BadBytes{"the size of a file is out of range"};
    }
  } catch (const BadBytes& error) {
    refuse(name, error.what);
  }
  return stored;
}

void complete_settings(Checkpoint& checkpoint, const Scene& scene) {
  RunSettings settings = settings_after_events(scene, checkpoint.progress.next_event);
  settings.constraints.fixes = std::move(checkpoint.settings.constraints.fixes);
  settings.constraints.others = std::move(checkpoint.settings.constraints.others);
  complete_constraints(scene, settings);
  if (settings.obstacles.size() != checkpoint.settings.obstacles.size()) {
    throw InputError("The [[obstacle]] of the run are not those of the scene.");
  }
  for (std::size_t i = 0; i < settings.obstacles.size(); ++i) {
    settings.obstacles[i].start = checkpoint.settings.obstacles[i].start;
  }
  checkpoint.settings = std::move(settings);
  if (checkpoint.progress.status == RunStatus::kCancelled) {
    checkpoint.progress.status = RunStatus::kRunning;
    checkpoint.progress.message.clear();
  }
}

std::vector<CheckpointPath> checkpoint_paths(const std::string& directory) {
  std::vector<CheckpointPath> paths;
  std::error_code error;
  for (fs::directory_iterator entry(fs::path(directory) / kFolder, error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const bool is_regular = name.starts_with(kRegular);
    if ((!is_regular && !name.starts_with(kStopped)) || !name.ends_with(kEnding)) continue;
    const std::string digits =
        name.substr(kRegular.size(), name.size() - kRegular.size() - kEnding.size());
    Index step = 0;
    const auto [rest, failure] =
        std::from_chars(digits.data(), digits.data() + digits.size(), step);
    if (failure != std::errc() || rest != digits.data() + digits.size() || step < 0) continue;
    paths.push_back({entry->path().string(), step, is_regular});
  }
  std::ranges::sort(paths, [](const CheckpointPath& a, const CheckpointPath& b) {
    return std::pair(a.step, a.is_regular) > std::pair(b.step, b.is_regular);
  });
  return paths;
}

StoredCheckpoint read_checkpoint_file(const std::string& path) {
  const auto fail = [&path](const std::string& what) {
    throw FileError(fmt::format("{}: cannot be read ({}).", path, what));
  };
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (!fs::is_regular_file(status)) fail(error ? error.message() : "it is no file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(std::strerror(errno));
  const std::uintmax_t file_size = fs::file_size(path, error);
  if (error) fail(error.message());
  // The beginning is checked first, because a file of any size may have this name.
  std::string bytes(std::min<std::uintmax_t>(kBeginSize, file_size), '\0');
  const auto read_from = [&](std::size_t at) {
    file.read(bytes.data() + at, static_cast<std::streamsize>(bytes.size() - at));
    if (!file) fail("reading failed");
  };
  read_from(0);
  checked_size(bytes, file_size, path);
  bytes.resize(file_size);
  read_from(kBeginSize);
  return checkpoint_from_bytes(bytes, path);
}

void write_checkpoint_file(const std::string& directory, const StoredCheckpoint& stored) {
  const fs::path folder = fs::path(directory) / kFolder;
  make_own_directory(folder.string());
  const std::string name = fmt::format("{}{:09}{}", stored.is_regular ? kRegular : kStopped,
                                       stored.checkpoint.state.step, kEnding);
  const std::string path = (folder / name).string();
  if (is_folder(path)) return;
  ReplacementFile file(path);
  file.write(checkpoint_bytes(stored));
  file.finish();
  Index regular_kept = 0;
  bool is_newest = true;
  for (const CheckpointPath& old : checkpoint_paths(directory)) {
    if (is_folder(old.path)) continue;
    const bool is_kept = old.is_regular ? ++regular_kept <= 2 : is_newest;
    is_newest = false;
    if (!is_kept) remove_output(old.path);
  }
}

void remove_checkpoints_after(const std::string& directory, Index step, bool is_regular) {
  const fs::path folder = fs::path(directory) / kFolder;
  if (!is_entry(folder.string())) return;
  make_own_directory(folder.string());  // refuses a link
  for (const CheckpointPath& file : checkpoint_paths(directory)) {
    if (std::pair(file.step, file.is_regular) > std::pair(step, is_regular) &&
        !is_folder(file.path)) {
      remove_output(file.path);
    }
  }
  // Remains of a program that was killed.
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::string path = entry->path().string();
    if (name.ends_with(temporary_name(std::string(kEnding))) && !is_folder(path)) {
      remove_output(path);
    }
  }
}

void remove_checkpoints(const std::string& directory) {
  remove_checkpoints_after(directory, -1, false);
  std::error_code not_empty;  // something else is in it
  fs::remove(fs::path(directory) / kFolder, not_empty);
}

}  // namespace tetraction
