// probes.csv of a run.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/text/output_file.h"
#include "tetraction/io/checkpoint_file.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// Writes probes.csv: a header, a row with all values for the state at which it begins, and then a
/// row for each step at which a probe is due. The cells of probes that are not due are empty. It
/// keeps the traces of the probes, too.
class ProbeFile {
 public:
  /// Opens the file and writes the header and the first row. Throws OutputError.
  ProbeFile(std::string path, const Session& session);
  /// Goes on with a file that is there, after its first `kept_size` bytes, which have this check sum and whose
  /// rows give the traces their values. Throws FileError if they are not those of such a file.
  ProbeFile(std::string path, const Session& session, std::int64_t kept_size,
            std::uint32_t kept_sum);

  /// Writes a row if a probe is due at the present step. If `is_last`, all probes are due. Throws
  /// OutputError.
  void write(const Session& session, bool is_last);
  /// See RowFile::flush().
  std::int64_t flush() { return file_->flush(); }
  /// See RowFile::sum().
  std::uint32_t sum() const { return file_->sum(); }
  /// Writes the row of the present state if it has none yet, and closes the file. Throws OutputError.
  void finish(const Session& session);
  const ProbeTraces& traces() const { return traces_; }
  Index last_row() const { return last_row_; }
  /// The header of the file, with its line break.
  static std::string header(const ProbeSet& probes);

 private:
  std::string row(const Session& session, bool all);

  std::optional<RowFile> file_;
  const ProbeSet& probes_;
  ProbeTraces traces_;
  std::vector<double> values_;
  Index last_row_ = -1;
};

/// How far history.csv and probes.csv, which may be null, were written. Their rows are on the disk afterwards.
/// Throws OutputError.
RecordedFiles recorded_tables(RowFile& history, Index last_row, ProbeFile* probes);

/// Goes on with the probes.csv of a run in `directory`. Null if its scene has no probes. Throws FileError.
std::unique_ptr<ProbeFile> kept_probes(const std::string& directory, const Session& session,
                                       const RecordedFiles& files);

}  // namespace tetraction
