#include "tetraction/io/run_recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "directory_lock.h"
#include "failed_elements.h"
#include "frame_fields.h"
#include "history_rows.h"
#include "input_guard.h"
#include "io/checkpoints/part_checkpoint.h"
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

// How the run ended. `stop_code` may be empty; it gives the exit code of a run that was stopped.
RunEnd end_of(const Session& session, const std::optional<OutputError>& failure,
              const std::function<int()>& stop_code) {
  if (failure) return {"failed", 4, failure->what()};
  // A run without an end, as one in the window, ends where its recording does.
  const bool is_endless = std::isinf(session.time_settings().end);
  if (is_endless && session.status() == RunStatus::kRunning) return {"ok", 0, {}};
  const bool is_stopped = session.status() == RunStatus::kCancelled && stop_code;
  return {to_string(session.status()), is_stopped ? stop_code() : exit_code(session.status()),
          session.message()};
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
  const MeshPart* part = nullptr;
  std::function<int()> stop_code;
  std::optional<HistoryColumns> columns;
  Index last_row = -1;
  std::unique_ptr<FrameWriter> frames;
  Index last_frame = -1;
  std::string last_frame_path;
  std::shared_ptr<const Frame> last;  // the frame of the last step, for final.vtu
  // A thread of its own writes one frame while the run goes on. The path comes from it.
  std::future<std::string> writing;
  Index written_step = -1;
  std::unique_ptr<ProbeFile> probes;  // null if the scene has none
  std::string summary;
  std::optional<OutputError> failure;
  bool is_finished = false;
  bool is_resumed = false;
  Index checkpoint_every = -1;
  bool leaves_out_checkpoints = false;
  std::optional<RunInputs> inputs;  // made when the first checkpoint needs them
  // Only process 0 has these.
  std::optional<DirectoryLock> lock;
  std::optional<RowFile> history;

  std::string path(const char* name) const { return directory + "/" + name; }

  // The values are sums over all processes.
  void write_row(const Session& session) {
    const std::vector<double> values = columns->values(session);
    last_row = session.step_number();
    if (history) history->add(row_text(*columns, values));
  }

  // Writes the frame while the run goes on. Throws the OutputError of the frame before. The processes of a body in
  // parts, which write together, wait for the frame.
  std::shared_ptr<const Frame> write_frame(const Session& session) {
    finish_frame();  // frees its memory
    auto frame = std::make_shared<const Frame>(make_frame(session, session.scene().output.fields));
    // Rows come first, so that history and probes have those of every frame that frames.pvd names.
    write_once(part, [&] {
      history->flush();
      if (probes) probes->file()->flush();
    });
    written_step = session.step_number();
    writing = std::async(part != nullptr ? std::launch::deferred : std::launch::async,
                         [this, frame] { return frames->write(*frame); });
    if (part != nullptr) finish_frame();
    return frame;
  }

  // Waits until the last frame is on the disk. Throws its OutputError.
  void finish_frame() {
    if (!writing.valid()) return;
    last_frame_path = writing.get();
    last_frame = written_step;
  }

  // Throws the OutputError of the last frame if it could not be written.
  void look_at_frame() {
    const auto no_time = std::chrono::seconds(0);
    if (writing.valid() && writing.wait_for(no_time) == std::future_status::ready) finish_frame();
  }

  void write_last_frame(const Session& session) {
    if (frame_every <= 0 || last_frame == session.step_number()) return;
    last = write_frame(session);
    finish_frame();
  }

  // A frame of the last step that has all digits is final.vtu already, but not one in pieces.
  void write_final(const Session& session) {
    const OutputSettings& output = session.scene().output;
    const std::string final_path = path(part != nullptr ? "final.pvtu" : "final.vtu");
    const bool has_frame = last_frame == session.step_number() && last_frame_path.ends_with(".vtu");
    if (part == nullptr && has_frame && output.precision == FramePrecision::kFloat64) {
      copy_file(last_frame_path, final_path);
      return;
    }
    if (!last) last = std::make_shared<const Frame>(make_frame(session, output.fields));
    frames->write_single(*last, final_path);
  }

  // How far the files were written. The rows of the tables are on the disk afterwards.
  RecordedFiles recorded_files() {
    RecordedFiles files;
    files.history_size = static_cast<std::uint64_t>(history->flush());
    files.history_sum = history->sum();
    files.last_row = last_row;
    if (probes) {
      files.probes_size = static_cast<std::uint64_t>(probes->file()->flush());
      files.probes_sum = probes->file()->sum();
      files.last_probe_row = probes->last_row();
    }
    finish_frame();
    files.frame_sizes = frames->frame_sizes();
    files.last_frame = last_frame;
    return files;
  }

  // Several processes do the same work until all of them know of a failure; a single one ends its work with it.
  template <class Work>
  void attempt_in_step(const Work& work) {
    if (part != nullptr || !failure) attempt(failure, work);
  }

  // Writes what belongs to the end. What cannot be written does not keep the rest from being written.
  // Throws the first failure at the end.
  void finish(const Session& session) {
    if (is_finished) return;
    is_finished = true;
    attempt(failure, [&] { finish_frame(); });
    share(part, failure);
    const bool has_failed = failure.has_value();
    const Index step = session.step_number();
    if (last_row != step) attempt(failure, [&] { write_row(session); });
    if (probes && probes->last_row() != step) {
      attempt(failure, [&] { probes->write(session, true); });
    }
    if (!has_failed) attempt(failure, [&] { write_last_frame(session); });
    attempt(failure, [&] { write_final(session); });
    if (session.failure() != nullptr) {
      attempt(failure, [&] { write_failed_elements(session, path(kFailedElementsFile)); });
    }
    last.reset();
    for (RowFile* file : {history ? &*history : nullptr, probes ? probes->file() : nullptr}) {
      if (file != nullptr) attempt(failure, [&] { file->close(); });
    }
    share(part, failure);
    const RunEnd end = end_of(session, failure, stop_code);
    summary = summary_json(session, directory,
                           probes && is_first(part) ? &probes->traces() : nullptr, &end);
    if (is_first(part)) {
      attempt(failure, [&] { write_text_file(path("summary.json"), summary); });
    }
    probes.reset();
    lock.reset();
    throw_together(part, failure);
  }
};

RunRecorder::RunRecorder(std::string directory, int frame_every) : impl_(std::make_unique<Impl>()) {
  impl_->directory = std::move(directory);
  impl_->frame_every = frame_every;
}

RunRecorder::~RunRecorder() = default;

void RunRecorder::lock_directory(const MeshPart* part) {
  Impl& s = *impl_;
  write_once(part, [&] {
    if (s.lock) return;
    make_output_directory(s.directory);
    s.lock.emplace(s.directory);
  });
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
  const bool is_storable = can_be_stored(checkpoint);
  Checkpoint whole;
  if (is_storable) whole = s.part != nullptr ? collected(*s.part, checkpoint) : checkpoint;
  if (is_first(s.part)) {
    attempt(s.failure, [&] {
      if (!is_storable) {
        if (!s.leaves_out_checkpoints) remove_checkpoints(s.directory);
        s.leaves_out_checkpoints = true;
        return;
      }
      if (!s.inputs) s.inputs = inputs_of(session);
      StoredCheckpoint stored{version(),       is_regular, process_count(session), *s.inputs,
                              session.times(), {},         std::move(whole)};
      stored.files = s.recorded_files();
      write_checkpoint_file(s.directory, stored);
    });
  }
  if (s.part == nullptr && s.failure) s.finish(session);
}

void RunRecorder::resume(const Session& session, const StoredCheckpoint& stored) {
  Impl& s = *impl_;
  const RecordedFiles& files = stored.files;
  s.part = session.system().part();
  s.columns.emplace(session);
  KeptFrames kept;
  std::optional<OutputError> failure;
  std::string wrong;
  try {
    if (is_first(s.part)) kept = check_kept_files(s.directory, *s.columns, session, files);
    // From here on the files are changed.
    if (!session.scene().probe.empty()) {
      attempt(failure, [&] {
        s.probes = std::make_unique<ProbeFile>(s.path("probes.csv"), session, files);
      });
    }
  } catch (const FileError& error) {
    wrong = error.what();
  }
  if (take_from_first(s.part, !wrong.empty(), wrong)) throw FileError(wrong);
  throw_together(s.part, failure);
  write_once(s.part, [&] {
    remove_checkpoints_after(s.directory, stored.checkpoint.state.step, stored.is_regular);
    remove_end_of_run(s.directory);
  });
  const OutputSettings& output = session.scene().output;
  s.last_frame_path = kept.last;
  s.frames = std::make_unique<FrameWriter>(session.system().mesh(), s.directory,
                                           FrameFormat{output.precision, output.compression},
                                           std::move(kept.entries), kept.names, files.frame_sizes);
  write_once(s.part, [&] {
    s.history.emplace(s.path("history.csv"), static_cast<std::int64_t>(files.history_size),
                      files.history_sum);
  });
  s.last_row = files.last_row;
  s.last_frame = files.last_frame;
  s.is_resumed = true;
}

void RunRecorder::on_start(const Session& session) {
  Impl& s = *impl_;
  if (s.is_resumed) return;
  s.part = session.system().part();
  if (s.part == nullptr) {
    std::vector<std::string> inputs = input_files(session.scene());
    for (std::string& file : files_of_mesh(session.system().mesh().source)) {
      inputs.push_back(std::move(file));
    }
    refuse_inputs_among_results(inputs, s.directory);
  }
  lock_directory(s.part);
  // Results of an earlier run would look like results of this one.
  write_once(s.part, [&] { remove_run(s.directory); });
  s.columns.emplace(session);
  const std::vector<double> first = s.columns->values(session);
  write_once(s.part, [&] {
    s.history.emplace(s.path("history.csv"), header_text(*s.columns) + row_text(*s.columns, first));
  });
  s.last_row = session.step_number();
  const OutputSettings& output = session.scene().output;
  s.frames = std::make_unique<FrameWriter>(session.system().mesh(), s.directory,
                                           FrameFormat{output.precision, output.compression});
  if (!session.scene().probe.empty()) {
    write_together(s.part,
                   [&] { s.probes = std::make_unique<ProbeFile>(s.path("probes.csv"), session); });
  }
  if (s.frame_every > 0) s.write_frame(session);
}

bool RunRecorder::on_step(const Session& session) {
  Impl& s = *impl_;
  const OutputSettings& output = session.scene().output;
  const Index step = session.step_number();
  const bool is_last = session.status() != RunStatus::kRunning;
  if (is_last || step % output.history_every == 0) {
    s.attempt_in_step([&] { s.write_row(session); });
  }
  if (s.probes) s.attempt_in_step([&] { s.probes->write(session, is_last); });
  if (s.frame_every > 0 && step % s.frame_every == 0) {
    s.attempt_in_step([&] {
      auto frame = s.write_frame(session);
      if (is_last) s.last = std::move(frame);
    });
  }
  s.attempt_in_step([&] { s.look_at_frame(); });
  if (s.part == nullptr && s.failure) s.finish(session);
  return true;
}

void RunRecorder::on_finish(const Session& session) {
  impl_->finish(session);
}

bool RunRecorder::has_failed() const {
  return impl_->failure.has_value();
}

const std::string& RunRecorder::summary() const {
  return impl_->summary;
}

}  // namespace tetraction
