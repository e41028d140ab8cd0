#include "tetraction/io/run_recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "directory_lock.h"
#include "failed_elements.h"
#include "frame_fields.h"
#include "history_rows.h"
#include "input_guard.h"
#include "io/mesh/mesh_files.h"
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
#include "tetraction/simulation/history.h"
#include "write_failures.h"

namespace tetraction {
namespace {

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
  std::optional<HistoryColumns> columns;
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
  bool leaves_out_checkpoints = false;
  std::optional<RunInputs> inputs;  // made when the first checkpoint needs them

  std::string path(const char* name) const { return directory + "/" + name; }

  void write_row(const Session& session) {
    history->add(row_text(*columns, columns->values(session)));
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

  // A frame of the last step that has all digits is final.vtu already, but not one that another run wrote in pieces.
  void write_final(const Session& session) {
    const OutputSettings& output = session.scene().output;
    const std::string final_path = path("final.vtu");
    const bool has_frame = last_frame == session.step_number() && last_frame_path.ends_with(".vtu");
    if (has_frame && output.precision == FramePrecision::kFloat64) {
      copy_file(last_frame_path, final_path);
      return;
    }
    if (!last) last = make_frame(session, output.fields);
    frames->write_single(*last, final_path);
  }

  // Writes what belongs to the end. What cannot be written does not keep the rest from being written.
  // Throws `failure`, or the first one of this function, at the end.
  void finish(const Session& session, std::optional<OutputError> failure) {
    if (is_finished) return;
    is_finished = true;
    const bool has_failed = failure.has_value();
    if (last_row != session.step_number()) attempt(failure, [&] { write_row(session); });
    if (!has_failed) attempt(failure, [&] { write_last_frame(session); });
    attempt(failure, [&] { write_final(session); });
    if (session.failure() != nullptr) {
      attempt(failure, [&] { write_failed_elements(session, path(kFailedElementsFile)); });
    }
    last.reset();
    attempt(failure, [&] { history->close(); });
    if (probes) attempt(failure, [&] { probes->finish(session); });
    const RunEnd end = end_of(session, failure, stop_code);
    summary = summary_json(session, directory, probes ? &probes->traces() : nullptr, &end);
    attempt(failure, [&] { write_text_file(path("summary.json"), summary); });
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

bool RunRecorder::leaves_out_checkpoints() const {
  return impl_->leaves_out_checkpoints;
}

void RunRecorder::on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                                bool is_regular) {
  Impl& s = *impl_;
  if (s.is_finished) return;
  try {
    if (!can_be_stored(checkpoint)) {
      if (!s.leaves_out_checkpoints) remove_checkpoints(s.directory);
      s.leaves_out_checkpoints = true;
      return;
    }
    if (!s.inputs) s.inputs = inputs_of(session);
    StoredCheckpoint stored{
        version(), is_regular, process_count(session), *s.inputs, session.times(), {}, checkpoint};
    stored.files = recorded_tables(*s.history, s.last_row, s.probes.get());
    stored.files.frame_sizes = s.frames->frame_sizes();
    stored.files.last_frame = s.last_frame;
    write_checkpoint_file(s.directory, stored);
  } catch (const OutputError& error) {
    s.finish(session, error);
  }
}

void RunRecorder::resume(const Session& session, const StoredCheckpoint& stored) {
  Impl& s = *impl_;
  const RecordedFiles& files = stored.files;
  s.columns.emplace(session);
  KeptFrames kept = check_kept_files(s.directory, *s.columns, session, files);
  // From here on the files are changed.
  s.probes = kept_probes(s.directory, session, files);
  remove_checkpoints_after(s.directory, stored.checkpoint.state.step, stored.is_regular);
  remove_end_of_run(s.directory);
  const OutputSettings& output = session.scene().output;
  s.last_frame_path = kept.last;
  s.frames = std::make_unique<FrameWriter>(session.system().mesh(), s.directory,
                                           FrameFormat{output.precision, output.compression},
                                           std::move(kept.entries), kept.names, files.frame_sizes);
  s.history.emplace(s.path("history.csv"), static_cast<std::int64_t>(files.history_size),
                    files.history_sum);
  s.last_row = files.last_row;
  s.last_frame = files.last_frame;
  s.is_resumed = true;
}

void RunRecorder::on_start(const Session& session) {
  Impl& s = *impl_;
  if (s.is_resumed) return;
  std::vector<std::string> inputs = input_files(session.scene());
  for (std::string& file : files_of_mesh(session.system().mesh().source)) {
    inputs.push_back(std::move(file));
  }
  refuse_inputs_among_results(inputs, s.directory);
  lock_directory();
  // Results of an earlier run would look like results of this one.
  remove_run(s.directory);
  s.columns.emplace(session);
  s.history.emplace(s.path("history.csv"),
                    header_text(*s.columns) + row_text(*s.columns, s.columns->values(session)));
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
