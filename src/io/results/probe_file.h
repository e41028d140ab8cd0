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
/// keeps the traces of the probes, too. Of a body in parts each process has one: all of them evaluate the probes,
/// and process 0 writes.
class ProbeFile {
 public:
  /// Opens the file and writes the header and the first row. Throws OutputError.
  ProbeFile(std::string path, const Session& session);
  /// Goes on with a file that is there, whose kept rows give the traces their values. Throws FileError if they are
  /// not those of such a file.
  ProbeFile(std::string path, const Session& session, const RecordedFiles& kept);

  /// Writes a row if a probe is due at the present step, or if all are to be written. Throws OutputError.
  void write(const Session& session, bool all);
  /// Null on all processes but the first.
  RowFile* file() { return file_ ? &*file_ : nullptr; }
  const ProbeTraces& traces() const { return traces_; }
  /// The step of the last row.
  Index last_row() const { return last_row_; }
  /// The header of the file, with its line break.
  static std::string header(const ProbeSet& probes);

 private:
  std::string row(const Session& session, bool all);

  const MeshPart* part_;
  std::optional<RowFile> file_;
  const ProbeSet& probes_;
  ProbeTraces traces_;
  std::vector<double> values_;
  Index last_row_ = -1;
};

}  // namespace tetraction
