// Text files with columns of numbers.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The rows of a text file, each with this number of columns. Columns are separated by a comma or a
/// semicolon, or by spaces and tabs. Empty lines, lines that begin with #, and a first line that
/// does not begin with a number are left out. The decimal separator is a point, whatever the
/// locale. Throws FileError, with path and line, for a file that is missing, a line with another
/// number of columns, a text that is not a finite number, and a file without rows.
std::vector<std::vector<double>> read_number_table(const std::string& path, std::size_t columns);

}  // namespace tetraction
