#include "tetraction/io/run_recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "directory_lock.h"
#include "failed_elements.h"
#include "frame_fields.h"
#include "io/text/output_file.h"
#include "kept_files.h"
#include "probe_file.h"
#include "run_files.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/io/checkpoint_file.h"
#include "tetraction/io/frame_writer.h"
#include "tetraction/io/text_file.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

// The columns beyond those that every run has: the sum of the reactions; of each [[constraint]] the
// tension of a distance, or the resultant of its forces and their moment about the centre of its
// vertices; energies by region where there are several; the energies of a program's own force terms.
std::string history_header(const Session& session) {
  // An equilibrium has no motion, and what entered depends on the way of loading.
  std::string header =
      session.load_path() != nullptr
          ? "step,time,elastic_energy,environment_energy,total_energy,max_constraint_error,"
            "iterations,"
            "reaction_x,reaction_y,reaction_z,time_step,max_displacement,residual"
          : "step,time,kinetic_energy,elastic_energy,environment_energy,total_energy,external_work,"
            "dissipated_energy,constraint_work,edit_work,energy_error,px,py,pz,lx,ly,lz,"
            "max_constraint_error,iterations,reaction_x,reaction_y,reaction_z,time_step";
  if (session.may_invert()) header += ",inverted_elements";
  for (std::size_t i = 0; i < session.scene().constraint.size(); ++i) {
    if (session.scene().constraint[i].kind == ConstraintKind::kDistance) {
      header += fmt::format(",constraint_{}_tension", i);
      continue;
    }
    header += fmt::format(",constraint_{0}_fx,constraint_{0}_fy,constraint_{0}_fz", i);
    header += fmt::format(",constraint_{0}_mx,constraint_{0}_my,constraint_{0}_mz", i);
  }
  for (Index r = 0; r < session.system().region_count() && session.system().region_count() > 1;
       ++r) {
    if (session.load_path() == nullptr) header += fmt::format(",kinetic_energy_{0}", r);
    header += fmt::format(",elastic_energy_{0}", r);
  }
  const Energies& energies = session.balance().energies();
  for (std::size_t i = 0; i < energies.extra_count(); ++i) {
    header += fmt::format(",{}_energy", energies.extra(i).name);
  }
  if (session.may_repeat_steps()) header += ",rejected,substeps";
  if (session.may_adapt(StepAdaptation::kError)) header += ",step_error";
  if (session.may_adapt(StepAdaptation::kEnergy)) header += ",discrete_energy,energy_residual";
  return header + "\n";
}

std::vector<double> constraint_columns(const Session& session) {
  const Vector& reaction = session.reaction_force();
  std::vector<double> values;
  const Vector3 total = resultant(reaction);
  values.insert(values.end(), total.data(), total.data() + 3);
  for (std::size_t i = 0; i < session.scene().constraint.size(); ++i) {
    if (session.scene().constraint[i].kind == ConstraintKind::kDistance) {
      values.push_back(session.tension(i));
      continue;
    }
    const Vector& q = session.state().position;
    const std::vector<Index>& vertices = session.constraint_vertices(i);
    double mass = 0.0;
    Vector3 center = Vector3::Zero();
    for (const Index v : vertices) {
      mass += session.system().mass()[v];
      center += session.system().mass()[v] * vertex_block(q, v);
    }
    if (mass > 0.0) center /= mass;
    Vector3 force = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    for (const Index v : vertices) {
      force += vertex_block(reaction, v);
      moment += (vertex_block(q, v) - center).cross(vertex_block(reaction, v));
    }
    values.insert(values.end(), force.data(), force.data() + 3);
    values.insert(values.end(), moment.data(), moment.data() + 3);
  }
  return values;
}

// Which columns there are besides those that every run has. They are those of the start.
struct OptionalColumns {
  bool inverted = false;
  bool repeated = false;
  bool error = false;
  bool energy = false;
};

std::string history_row(const Session& session, const OptionalColumns& columns) {
  const Balance& balance = session.balance();
  const Energies& e = balance.energies();
  const Momenta& m = balance.momenta();
  const auto g = [](double value) { return fmt::format("{:.17g}", value); };
  std::string row = fmt::format("{},{}", session.step_number(), g(session.time()));
  const LoadPath* path = session.load_path();
  if (path != nullptr) {
    for (const double value : {e.elastic(), e.environment(), e.total()}) row += ',' + g(value);
  } else {
    for (const double value :
         {e.kinetic(), e.elastic(), e.environment(), e.total(), balance.external_work(),
          balance.dissipated_energy(), balance.constraint_work(), balance.edit_work(),
          balance.energy_error(), m.linear.x(), m.linear.y(), m.linear.z(), m.angular.x(),
          m.angular.y(), m.angular.z()}) {
      row += ',' + g(value);
    }
  }
  row += ',' + g(session.constraint_error());
  row += fmt::format(",{}", session.last_iterations());
  const std::vector<double> constraints = constraint_columns(session);
  for (std::size_t i = 0; i < 3; ++i) row += ',' + g(constraints[i]);
  row += ',' + g(session.steps().last);
  if (path != nullptr) {
    row += ',' + g(largest_displacement(session.system(), session.state().position).length);
    row += ',' + g(path->residual);
  }
  if (columns.inverted) row += fmt::format(",{}", session.inverted_elements().now);
  for (std::size_t i = 3; i < constraints.size(); ++i) row += ',' + g(constraints[i]);
  if (session.system().region_count() > 1) {
    const State& state = session.state();
    const Vector kinetic = session.system().kinetic_energies_by_region(state.momentum);
    const Vector elastic = session.system().elastic_energies_by_region(state.position);
    for (Index r = 0; r < kinetic.size(); ++r) {
      if (path == nullptr) row += ',' + g(kinetic[r]);
      row += ',' + g(elastic[r]);
    }
  }
  for (std::size_t i = 0; i < e.extra_count(); ++i) row += ',' + g(e.extra(i).value);
  const StepControl& control = session.step_control();
  if (columns.repeated) {
    row += fmt::format(",{},{}", control.last_rejected, control.last_substeps);
  }
  if (columns.error) row += ',' + g(control.last_error);
  if (columns.energy) row += ',' + g(control.discrete_energy) + ',' + g(control.energy_residual);
  return row + '\n';
}

void copy_file(const std::string& from, const std::string& to) {
  ReplacementFile file(to);
  std::error_code error;
  std::filesystem::copy_file(from, file.temporary(),
                             std::filesystem::copy_options::overwrite_existing, error);
  if (error) fail_to_write(to, error.value());
  file.finish();
}

}  // namespace

void make_output_directory(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  std::string reason;
  if (error) {
    reason = error.message();
  } else if (!std::filesystem::is_directory(directory, error)) {
    reason = "there is a file of that name";
  } else if (access(directory.c_str(), W_OK) != 0) {
    reason = std::strerror(errno);
  }
  if (!reason.empty()) {
    throw OutputError(
        fmt::format("{}: not a directory that can be written to ({}). Choose another one (on the "
                    "command line: --out).",
                    directory, reason));
  }
}

struct RunRecorder::Impl {
  std::string directory;
  int frame_every;
  std::optional<DirectoryLock> lock;
  std::function<int()> stop_code;
  OptionalColumns columns;
  std::optional<RowFile> history;
  Index last_row = -1;
  std::unique_ptr<FrameWriter> frames;
  Index last_frame = -1;
  std::string last_frame_path;
  std::optional<Frame> last;          // the frame of the last step, for final.vtu
  std::unique_ptr<ProbeFile> probes;  // null if the scene has none
  std::string summary;
  bool is_finished = false;
  bool is_resumed = false;
  Index checkpoint_every = -1;
  std::optional<RunInputs> inputs;  // made when the first checkpoint needs them

  std::string path(const char* name) const { return directory + "/" + name; }

  void set_columns(const Session& session) {
    columns = {session.may_invert(), session.may_repeat_steps(),
               session.may_adapt(StepAdaptation::kError),
               session.may_adapt(StepAdaptation::kEnergy)};
  }

  void write_row(const Session& session) {
    history->add(history_row(session, columns));
    last_row = session.step_number();
  }

  void write_frame(const Session& session, const Frame& frame) {
    // Rows come first, so that history and probes have those of every frame that frames.pvd names.
    history->flush();
    if (probes) probes->flush();
    last_frame_path = frames->write(frame);
    last_frame = session.step_number();
  }

  void write_last_frame(const Session& session) {
    if (frame_every <= 0 || last_frame == session.step_number()) return;
    last = make_frame(session, session.scene().output.fields);
    write_frame(session, *last);
  }

  // A frame of the last step that has all digits is final.vtu already.
  void write_final(const Session& session) {
    const OutputSettings& output = session.scene().output;
    const std::string final_path = path("final.vtu");
    const bool has_frame = last_frame == session.step_number();
    if (has_frame && output.precision == FramePrecision::kFloat64) {
      copy_file(last_frame_path, final_path);
      return;
    }
    if (!last) last = make_frame(session, output.fields);
    frames->write_single(*last, final_path);
  }

  RunEnd end_of(const Session& session, const OutputError* failure) const {
    if (failure != nullptr) return {"failed", 4, failure->what()};
    const bool is_stopped = session.status() == RunStatus::kCancelled && stop_code;
    return {to_string(session.status()), is_stopped ? stop_code() : exit_code(session.status()),
            session.message()};
  }

  // Writes what belongs to the end. What cannot be written does not keep the rest from being written.
  // Throws `failure`, or the first one of this function, at the end.
  void finish(const Session& session, std::optional<OutputError> failure) {
    if (is_finished) return;
    is_finished = true;
    const bool has_failed = failure.has_value();
    const auto attempt = [&failure](const auto& work) {
      try {
        work();
      } catch (const OutputError& error) {
        if (!failure) failure = error;
      }
    };
    if (last_row != session.step_number()) attempt([&] { write_row(session); });
    if (!has_failed) attempt([&] { write_last_frame(session); });
    attempt([&] { write_final(session); });
    if (session.failure() != nullptr) {
      attempt([&] { write_failed_elements(session, path(kFailedElementsFile)); });
    }
    last.reset();
    attempt([&] { history->close(); });
    if (probes) attempt([&] { probes->finish(session); });
    const RunEnd end = end_of(session, failure ? &*failure : nullptr);
    summary = summary_json(session, directory, probes ? &probes->traces() : nullptr, &end);
    attempt([&] { write_text_file(path("summary.json"), summary); });
    probes.reset();
    lock.reset();
    if (failure) throw OutputError(*failure);
  }
};

RunRecorder::RunRecorder(std::string directory, int frame_every) : impl_(std::make_unique<Impl>()) {
  impl_->directory = std::move(directory);
  impl_->frame_every = frame_every;
}

RunRecorder::~RunRecorder() = default;

void RunRecorder::lock_directory() {
  Impl& s = *impl_;
  if (s.lock) return;
  make_output_directory(s.directory);
  s.lock.emplace(s.directory);
}

void RunRecorder::set_stop_code(std::function<int()> stop_code) {
  impl_->stop_code = std::move(stop_code);
}

void RunRecorder::keep_checkpoints(Index every) {
  impl_->checkpoint_every = every;
}

Index RunRecorder::checkpoint_every() const {
  return impl_->checkpoint_every;
}

void RunRecorder::on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                                bool is_regular) {
  Impl& s = *impl_;
  if (s.is_finished) return;
  try {
    if (!s.inputs) s.inputs = inputs_of(session);
    StoredCheckpoint stored{version(), is_regular, *s.inputs, session.times(), {}, checkpoint};
    RecordedFiles& files = stored.files;
    files.history_size = static_cast<std::uint64_t>(s.history->flush());
    files.history_sum = s.history->sum();
    files.last_row = s.last_row;
    if (s.probes) {
      files.probes_size = static_cast<std::uint64_t>(s.probes->flush());
      files.probes_sum = s.probes->sum();
      files.last_probe_row = s.probes->last_row();
    }
    files.frame_sizes = s.frames->frame_sizes();
    files.last_frame = s.last_frame;
    write_checkpoint_file(s.directory, stored);
  } catch (const OutputError& error) {
    s.finish(session, error);
  }
}

void RunRecorder::resume(const Session& session, const StoredCheckpoint& stored) {
  Impl& s = *impl_;
  const RecordedFiles& files = stored.files;
  s.set_columns(session);
  const std::string history = s.path("history.csv");
  const std::string probes = s.path("probes.csv");
  const auto history_size = static_cast<std::int64_t>(files.history_size);
  const auto probes_size = static_cast<std::int64_t>(files.probes_size);
  check_kept_table(history, history_header(session), history_size, files.history_sum);
  const bool has_probes = !session.scene().probe.empty();
  if (has_probes) {
    check_kept_table(probes, ProbeFile::header(session.probes()), probes_size, files.probes_sum);
  }
  KeptFrames kept = read_kept_frames(s.directory, files.frame_sizes, files.last_frame);
  // From here on the files are changed.
  if (has_probes)
    s.probes = std::make_unique<ProbeFile>(probes, session, probes_size, files.probes_sum);
  remove_checkpoints_after(s.directory, stored.checkpoint.state.step, stored.is_regular);
  for (const char* name : {"summary.json", "final.vtu", kFailedElementsFile}) {
    remove_output(s.path(name));
  }
  const OutputSettings& output = session.scene().output;
  if (!kept.names.empty()) s.last_frame_path = s.directory + "/frames/" + kept.names.back();
  s.frames = std::make_unique<FrameWriter>(session.system().mesh(), s.directory,
                                           FrameFormat{output.precision, output.compression},
                                           std::move(kept.entries), kept.names, files.frame_sizes);
  s.history.emplace(history, history_size, files.history_sum);
  s.last_row = files.last_row;
  s.last_frame = files.last_frame;
  s.is_resumed = true;
}

void RunRecorder::on_start(const Session& session) {
  Impl& s = *impl_;
  if (s.is_resumed) return;
  lock_directory();
  // Results of an earlier run would look like results of this one.
  remove_run(s.directory);
  s.set_columns(session);
  s.history.emplace(s.path("history.csv"),
                    history_header(session) + history_row(session, s.columns));
  s.last_row = session.step_number();
  const OutputSettings& output = session.scene().output;
  s.frames = std::make_unique<FrameWriter>(session.system().mesh(), s.directory,
                                           FrameFormat{output.precision, output.compression});
  if (!session.scene().probe.empty()) {
    s.probes = std::make_unique<ProbeFile>(s.path("probes.csv"), session);
  }
  if (s.frame_every > 0) s.write_frame(session, make_frame(session, output.fields));
}

bool RunRecorder::on_step(const Session& session) {
  Impl& s = *impl_;
  try {
    const OutputSettings& output = session.scene().output;
    const Index step = session.step_number();
    const bool is_last = session.status() != RunStatus::kRunning;
    if (is_last || step % output.history_every == 0) s.write_row(session);
    if (s.probes) s.probes->write(session, is_last);
    if (s.frame_every > 0 && step % s.frame_every == 0) {
      Frame frame = make_frame(session, output.fields);
      s.write_frame(session, frame);
      if (is_last) s.last = std::move(frame);
    }
  } catch (const OutputError& error) {
    s.finish(session, error);
  }
  return true;
}

void RunRecorder::on_finish(const Session& session) {
  impl_->finish(session, std::nullopt);
}

const std::string& RunRecorder::summary() const {
  return impl_->summary;
}

}  // namespace tetraction
