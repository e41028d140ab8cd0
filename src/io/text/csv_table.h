// Reads tables of numbers: comma-separated values.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tetraction {

/// A table with the same number of entries in every row.
struct CsvTable {
  struct Row {
    std::size_t line = 0;  ///< in the file, from 1
    std::vector<double> values;
  };
  std::vector<std::string> header;  ///< the names of the columns; empty if the file has none
  std::vector<Row> rows;
};

/// Reads a file of numbers with decimal points, whatever the locale. Columns are separated by commas
/// or semicolons, or else by spaces and tabs. The first line is a header if none of its entries is a
/// number. Empty lines and lines that begin with # are skipped. Throws FileError, which
/// names file and line, for a file that cannot be read, that has no numbers, or in which an entry is
/// not a finite number, a line of numbers has both semicolons and commas (decimal commas), or a line has
/// another number of entries than the first.
CsvTable read_csv(const std::string& path);

}  // namespace tetraction
