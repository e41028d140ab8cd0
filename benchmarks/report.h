// Tables: printed row by row while the program runs, and kept for a JSON file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::benchmarks {

/// A column of a table: its heading, and how many digits of its numbers are worth printing.
struct Column {
  std::string name;
  std::size_t width = 8;
  int digits = 3;
};

/// NaN stands for "not measured".
using Cell = std::variant<std::string, double, Index>;

class Report {
 public:
  /// Begins a table; `notes` are lines below its title.
  void table(const std::string& title, std::vector<Column> columns,
             const std::vector<std::string>& notes = {});
  /// Text on the left of its column, numbers on the right. One cell for each column.
  void row(const std::vector<Cell>& cells);
  /// Throws OutputError.
  void write_json(const std::string& path) const;

 private:
  std::vector<Column> columns_;
  nlohmann::ordered_json tables_ = nlohmann::ordered_json::array();
};

}  // namespace tetraction::benchmarks
