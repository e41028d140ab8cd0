#include "probe_file.h"

#include <iterator>
#include <utility>

namespace tetraction {

ProbeFile::ProbeFile(std::string path, const Session& session)
    : probes_(session.probes()),
      traces_(probes_, session.step_count() - session.step_number()),
      values_(probes_.value_count()) {
  std::string begin = "step,time";
  for (const ProbeColumns& probe : probes_.probes()) {
    for (const std::string& column : probe.columns) begin += ',' + column;
  }
  begin += '\n';
  begin += row(session, true);
  file_.emplace(std::move(path), begin);
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

}  // namespace tetraction
