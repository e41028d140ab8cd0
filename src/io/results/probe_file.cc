#include "probe_file.h"

#include <iterator>
#include <utility>

#include "kept_files.h"
#include "write_failures.h"

namespace tetraction {

std::string ProbeFile::header(const ProbeSet& probes) {
  std::string text = "step,time";
  for (const ProbeColumns& probe : probes.probes()) {
    for (const std::string& column : probe.columns) text += ',' + column;
  }
  return text + '\n';
}

ProbeFile::ProbeFile(std::string path, const Session& session)
    : part_(session.system().part()),
      probes_(session.probes()),
      traces_(probes_, session.step_count() - session.step_number()),
      values_(probes_.value_count()) {
  const std::string begin = header(probes_) + row(session, true);
  if (is_first(part_)) file_.emplace(std::move(path), begin);
}

ProbeFile::ProbeFile(std::string path, const Session& session, const RecordedFiles& kept)
    : part_(session.system().part()),
      probes_(session.probes()),
      traces_(probes_, session.step_count()),
      values_(probes_.value_count()),
      last_row_(kept.last_probe_row) {
  if (!is_first(part_)) return;
  const auto size = static_cast<std::int64_t>(kept.probes_size);
  for_each_kept_row(path, header(probes_), size, [&](const std::vector<std::string>& cells) {
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
  file_.emplace(std::move(path), size, kept.probes_sum);
}

void ProbeFile::write(const Session& session, bool all) {
  bool is_due = all;
  for (std::size_t i = 0; i < probes_.probes().size() && !is_due; ++i) {
    is_due = probes_.is_due(i, session.step_number());
  }
  if (!is_due) return;
  const std::string text = row(session, all);
  if (file_) file_->add(text);
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
  if (is_first(part_)) traces_.add(step, session.time(), values_.data(), all);
  last_row_ = step;
  return fmt::to_string(row);
}

}  // namespace tetraction
