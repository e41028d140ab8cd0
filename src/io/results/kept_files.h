// The files of a run that goes on from a checkpoint, as far as they belong to it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

class HistoryColumns;
class Session;
struct RecordedFiles;

/// The cells of each row in the first `kept_size` bytes of a table, in their order. Throws FileError,
/// which names the file, if they are not whole rows after this header, with as many cells as it has.
void for_each_kept_row(const std::string& path, const std::string& header, std::int64_t kept_size,
                       const std::function<void(const std::vector<std::string>& cells)>& visit);

/// The number in a cell of such a row. Throws FileError.
double number_of(const std::string& path, const std::string& cell);
/// The step in the first cell.
Index step_of(const std::string& path, const std::string& cell);

/// The frames of a run up to a checkpoint.
struct KeptFrames {
  std::string entries;  ///< of the collection, with line breaks
  /// Of the files in `frames`, with those of the pieces of frames, and of obstacles in the order of the collection.
  std::vector<std::string> names;
  std::string last;  ///< the last file that the collection names, or empty
};
/// Checks all files of a run that goes on from a checkpoint. Throws FileError if one of them is not as it was then: tables
/// by their header, size and check sum, frames by their names and sizes, those in pieces with their pieces.
KeptFrames check_kept_files(const std::string& directory, const HistoryColumns& columns,
                            const Session& session, const RecordedFiles& files);

}  // namespace tetraction
