#include "tetraction/io/part_recorder.h"

#include <optional>
#include <utility>
#include <vector>

#include "directory_lock.h"
#include "failed_elements.h"
#include "frame_fields.h"
#include "history_rows.h"
#include "io/checkpoints/part_checkpoint.h"
#include "io/text/output_file.h"
#include "kept_files.h"
#include "part_frames.h"
#include "probe_file.h"
#include "run_files.h"
#include "tetraction/core/version.h"
#include "tetraction/io/checkpoint_file.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/text_file.h"
#include "write_failures.h"

namespace tetraction {

struct PartRecorder::Impl {
  std::string directory;
  int frame_every;
  std::function<int()> stop_code;
  std::optional<HistoryColumns> columns;
  Index last_row = -1;
  std::unique_ptr<PartFrames> frames;
  Index last_frame = -1;
  Index last_probe_row = -1;
  std::vector<double> probe_values;
  bool is_resumed = false;
  Index checkpoint_every = -1;
  std::optional<RunInputs> inputs;  // made when the first checkpoint needs them
  std::string summary;
  std::optional<OutputError> failure;
  bool is_finished = false;
  // Only process 0 has it.
  std::optional<DirectoryLock> lock;
  std::optional<RowFile> history;
  std::unique_ptr<ProbeFile> probes;

  std::string path(const char* name) const { return directory + "/" + name; }

  // The values are sums over all processes.
  void write_row(const Session& session) {
    const std::vector<double> values = columns->values(session);
    if (history) attempt(failure, [&] { history->add(row_text(*columns, values)); });
    last_row = session.step_number();
  }

  // Other processes compute their shares of the values that process 0 writes.
  void share_probes(const Session& session, bool all) {
    const ProbeSet& set = session.probes();
    for (std::size_t i = 0; i < set.probes().size(); ++i) {
      if (all || set.is_due(i, session.step_number())) {
        set.evaluate(i, session, probe_values.data());
      }
    }
  }
  void write_probes(const Session& session, bool all) {
    const ProbeSet& set = session.probes();
    if (set.probes().empty()) return;
    bool is_due = all;
    for (std::size_t i = 0; i < set.probes().size(); ++i) {
      is_due = is_due || set.is_due(i, session.step_number());
    }
    if (!is_due) return;
    if (probes) {
      attempt(failure, [&] { probes->write(session, all); });
    } else {
      share_probes(session, all);
    }
    last_probe_row = session.step_number();
  }

  void write_frame(const Session& session) {
    if (history) attempt(failure, [&] { history->flush(); });
    if (probes) attempt(failure, [&] { probes->flush(); });
    frames->write(make_frame(session, session.scene().output.fields));
    last_frame = session.step_number();
  }

  // As RunRecorder: what cannot be written does not keep the rest from being written.
  void finish(const Session& session) {
    if (is_finished) return;
    is_finished = true;
    const MeshPart& part = *session.system().part();
    share(part, failure);
    const bool has_failed = failure.has_value();
    if (last_row != session.step_number()) write_row(session);
    if (last_probe_row != session.step_number()) write_probes(session, true);
    if (!has_failed && frame_every > 0 && last_frame != session.step_number()) {
      attempt(failure, [&] { write_frame(session); });
    }
    const Frame last = make_frame(session, session.scene().output.fields);
    attempt(failure, [&] { frames->write_final(last); });
    if (session.failure() != nullptr) {
      attempt(failure, [&] { write_failed_elements(session, path(kFailedElementsFile)); });
    }
    if (history) attempt(failure, [&] { history->close(); });
    if (probes) attempt(failure, [&] { probes->finish(session); });
    share(part, failure);
    const RunEnd end = end_of(session, failure, stop_code);
    summary = summary_json(session, directory, probes ? &probes->traces() : nullptr, &end);
    if (lock) attempt(failure, [&] { write_text_file(path("summary.json"), summary); });
    probes.reset();
    lock.reset();
    throw_together(part, failure);
  }
};

PartRecorder::PartRecorder(std::string directory, int frame_every)
    : impl_(std::make_unique<Impl>()) {
  impl_->directory = std::move(directory);
  impl_->frame_every = frame_every;
}

PartRecorder::~PartRecorder() = default;

void PartRecorder::set_stop_code(std::function<int()> stop_code) {
  impl_->stop_code = std::move(stop_code);
}

void PartRecorder::lock_directory(const MeshPart& part) {
  Impl& s = *impl_;
  if (part.rank() == 0 && !s.lock) {
    attempt(s.failure, [&] {
      make_output_directory(s.directory);
      s.lock.emplace(s.directory);
    });
  }
  throw_together(part, s.failure);
}

void PartRecorder::keep_checkpoints(Index every) {
  impl_->checkpoint_every = every;
}

Index PartRecorder::checkpoint_every() const {
  return impl_->checkpoint_every;
}

void PartRecorder::on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                                 bool is_regular) {
  Impl& s = *impl_;
  if (s.is_finished) return;
  const MeshPart& part = *session.system().part();
  Checkpoint whole = collected(part, checkpoint);
  if (part.rank() != 0) return;
  attempt(s.failure, [&] {
    if (!s.inputs) s.inputs = inputs_of(session);
    StoredCheckpoint stored{version(),       is_regular, process_count(session), *s.inputs,
                            session.times(), {},         std::move(whole)};
    stored.files = recorded_tables(*s.history, s.last_row, s.probes.get());
    stored.files.frame_sizes = s.frames->frame_sizes();
    stored.files.last_frame = s.last_frame;
    write_checkpoint_file(s.directory, stored);
  });
}

void PartRecorder::resume(const Session& session, const StoredCheckpoint& stored) {
  Impl& s = *impl_;
  const MeshPart& part = *session.system().part();
  const bool is_first = part.rank() == 0;
  const RecordedFiles& files = stored.files;
  s.columns.emplace(session);
  KeptFrames kept;
  std::string wrong;
  if (is_first) {
    try {
      kept = check_kept_files(s.directory, *s.columns, session, files);
      attempt(s.failure, [&] { s.probes = kept_probes(s.directory, session, files); });
    } catch (const FileError& error) {
      wrong = error.what();
    }
  }
  if (take_from_first(&part, !wrong.empty(), wrong)) throw FileError(wrong);
  // From here on the files are changed.
  if (is_first) {
    attempt(s.failure, [&] {
      remove_checkpoints_after(s.directory, stored.checkpoint.state.step, stored.is_regular);
      remove_end_of_run(s.directory);
      s.history.emplace(s.path("history.csv"), static_cast<std::int64_t>(files.history_size),
                        files.history_sum);
    });
  }
  throw_together(part, s.failure);
  const OutputSettings& output = session.scene().output;
  s.frames = std::make_unique<PartFrames>(session.system().mesh(), s.directory,
                                          FrameFormat{output.precision, output.compression}, kept,
                                          files.frame_sizes);
  s.probe_values.resize(session.probes().value_count());
  s.last_row = files.last_row;
  s.last_probe_row = files.last_probe_row;
  s.last_frame = files.last_frame;
  s.is_resumed = true;
}

void PartRecorder::on_start(const Session& session) {
  Impl& s = *impl_;
  if (s.is_resumed) return;
  const MeshPart& part = *session.system().part();
  const bool is_first = part.rank() == 0;
  lock_directory(part);
  if (is_first) attempt(s.failure, [&] { remove_run(s.directory); });
  throw_together(part, s.failure);
  s.columns.emplace(session);
  const std::vector<double> first = s.columns->values(session);
  if (is_first) {
    attempt(s.failure, [&] {
      s.history.emplace(s.path("history.csv"),
                        header_text(*s.columns) + row_text(*s.columns, first));
    });
  }
  throw_together(part, s.failure);
  s.last_row = s.last_probe_row = session.step_number();
  const OutputSettings& output = session.scene().output;
  s.frames = std::make_unique<PartFrames>(session.system().mesh(), s.directory,
                                          FrameFormat{output.precision, output.compression});
  s.probe_values.resize(session.probes().value_count());
  if (!session.scene().probe.empty()) {
    if (is_first) {
      attempt(s.failure,
              [&] { s.probes = std::make_unique<ProbeFile>(s.path("probes.csv"), session); });
    } else {
      s.share_probes(session, true);
    }
    throw_together(part, s.failure);
  }
  if (s.frame_every > 0) s.write_frame(session);
}

bool PartRecorder::on_step(const Session& session) {
  Impl& s = *impl_;
  const Index step = session.step_number();
  const bool is_last = session.status() != RunStatus::kRunning;
  if (is_last || step % session.scene().output.history_every == 0) s.write_row(session);
  s.write_probes(session, is_last);
  if (s.frame_every > 0 && step % s.frame_every == 0) {
    // All processes fail together.
    attempt(s.failure, [&] { s.write_frame(session); });
  }
  return true;
}

void PartRecorder::on_finish(const Session& session) {
  impl_->finish(session);
}

bool PartRecorder::has_failed() const {
  return impl_->failure.has_value();
}

const std::string& PartRecorder::summary() const {
  return impl_->summary;
}

}  // namespace tetraction
