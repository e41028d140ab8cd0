#include "probe_file.h"

#include <iterator>
#include <utility>

#include "kept_files.h"

namespace tetraction {

std::string ProbeFile::header(const ProbeSet& probes) {
  std::string text = "step,time";
  for (const ProbeColumns& probe : probes.probes()) {
    for (const std::string& column : probe.columns) text += ',' + column;
  }
  return text + '\n';
}

ProbeFile::ProbeFile(std::string path, const Session& session)
    : probes_(session.probes()),
      traces_(probes_, session.step_count() - session.step_number()),
      values_(probes_.value_count()) {
  std::string begin = header(probes_);
  begin += row(session, true);
  file_.emplace(std::move(path), begin);
}

ProbeFile::ProbeFile(std::string path, const Session& session, std::int64_t kept_size,
                     std::uint32_t kept_sum)
    : probes_(session.probes()),
      traces_(probes_, session.step_count()),
      values_(probes_.value_count()) {
  for_each_kept_row(path, header(probes_), kept_size, [&](const std::vector<std::string>& cells) {
    const double time = number_of(path, cells[1]);
    bool all = true;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::string& cell = cells[i + 2];
      all = all && !cell.empty();
      values_[i] = cell.empty() ? 0.0 : number_of(path, cell);
    }
    last_row_ = step_of(path, cells[0]);
    traces_.add(last_row_, time, values_.data(), all);
  });
  file_.emplace(std::move(path), kept_size, kept_sum);
}

void ProbeFile::write(const Session& session, bool is_last) {
  bool is_due = is_last;
  for (std::size_t i = 0; i < probes_.probes().size() && !is_due; ++i) {
    is_due = probes_.is_due(i, session.step_number());
  }
  if (is_due) file_->add(row(session, is_last));
}

std::string ProbeFile::row(const Session& session, bool all) {
  const Index step = session.step_number();
  fmt::memory_buffer row;
  auto out = std::back_inserter(row);
  fmt::format_to(out, "{},{:.17g}", step, session.time());
  for (std::size_t i = 0; i < probes_.probes().size(); ++i) {
    const ProbeColumns& columns = probes_.probes()[i];
    const bool is_due = all || probes_.is_due(i, step);
    if (is_due) probes_.evaluate(i, session, values_.data());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      row.push_back(',');
      if (is_due) fmt::format_to(out, "{}", values_[columns.first + c]);
    }
  }
  row.push_back('\n');
  traces_.add(step, session.time(), values_.data(), all);
  last_row_ = step;
  return fmt::to_string(row);
}

void ProbeFile::finish(const Session& session) {
  if (last_row_ != session.step_number()) file_->add(row(session, true));
  file_->close();
}

RecordedFiles recorded_tables(RowFile& history, Index last_row, ProbeFile* probes) {
  RecordedFiles files;
  files.history_size = static_cast<std::uint64_t>(history.flush());
  files.history_sum = history.sum();
  files.last_row = last_row;
  if (probes != nullptr) {
    files.probes_size = static_cast<std::uint64_t>(probes->flush());
    files.probes_sum = probes->sum();
    files.last_probe_row = probes->last_row();
  }
  return files;
}

std::unique_ptr<ProbeFile> kept_probes(const std::string& directory, const Session& session,
                                       const RecordedFiles& files) {
  if (session.scene().probe.empty()) return nullptr;
  return std::make_unique<ProbeFile>(directory + "/probes.csv", session,
                                     static_cast<std::int64_t>(files.probes_size),
                                     files.probes_sum);
}

}  // namespace tetraction
