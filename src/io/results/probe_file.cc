#include "probe_file.h"

#include <cerrno>
#include <cstring>
#include <iterator>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {

ProbeFile::ProbeFile(std::string path, const Session& session)
    : path_(std::move(path)),
      file_(path_, std::ios::binary),
      probes_(session.probes()),
      traces_(probes_, session.step_count() - session.step_number()),
      values_(probes_.value_count()) {
  if (!file_) {
    throw OutputError(
        fmt::format("{}: cannot be written ({}). Choose another directory with --out.", path_,
                    std::strerror(errno)));
  }
  file_ << "step,time";
  for (const ProbeColumns& probe : probes_.probes()) {
    for (const std::string& column : probe.columns) file_ << ',' << column;
  }
  file_ << '\n';
  write_row(session, true);
}

void ProbeFile::write(const Session& session, bool is_last) {
  bool is_due = is_last;
  for (std::size_t i = 0; i < probes_.probes().size() && !is_due; ++i) {
    is_due = probes_.is_due(i, session.step_number());
  }
  if (is_due) write_row(session, is_last);
}

void ProbeFile::write_row(const Session& session, bool all) {
  const Index step = session.step_number();
  row_.clear();
  auto out = std::back_inserter(row_);
  fmt::format_to(out, "{},{:.17g}", step, session.time());
  for (std::size_t i = 0; i < probes_.probes().size(); ++i) {
    const ProbeColumns& columns = probes_.probes()[i];
    const bool is_due = all || probes_.is_due(i, step);
    if (is_due) probes_.evaluate(i, session, values_.data());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      row_.push_back(',');
      if (is_due) fmt::format_to(out, "{}", values_[columns.first + c]);
    }
  }
  row_.push_back('\n');
  file_.write(row_.data(), static_cast<std::streamsize>(row_.size()));
  require_good();
  traces_.add(step, session.time(), values_.data(), all);
  last_row_ = step;
}

void ProbeFile::finish(const Session& session) {
  if (last_row_ != session.step_number()) write_row(session, true);
  file_.close();
  require_good();
}

void ProbeFile::require_good() const {
  if (!file_) throw OutputError(path_ + ": cannot be written. Check the free space of the disk.");
}

}  // namespace tetraction
