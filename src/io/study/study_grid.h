// A table that is written once and shown on the terminal, in Markdown, LaTeX and HTML.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace tetraction {

class StudyGrid {
 public:
  struct Column {
    std::string head;
    bool is_text;
  };
  struct Cell {
    std::string text;
    double value = std::numeric_limits<double>::quiet_NaN();  ///< to sort by
  };
  struct Row {
    std::string rule;
    std::string run;   ///< its folder
    std::string line;  ///< instead of cells
    std::vector<Cell> cells;
  };

  void column(std::string head, bool is_text = false) { heads_.push_back({head, is_text}); }
  /// Begins a row. On the page, the rows of a rule can be left out together, and the row of a run hides its points.
  void row(std::string rule = {}, std::string run = {});
  /// A line of its own, on the terminal only.
  void line(std::string text);
  void text(std::string text);
  /// Empty if the number is not finite. Without a format it is short_number().
  void number(double value, const char* format = nullptr, const char* mark = "");

  bool is_empty() const { return rows_.empty(); }
  const std::vector<Column>& columns() const { return heads_; }
  const std::vector<Row>& rows() const { return rows_; }
  std::string terminal() const;
  std::string markdown() const;
  std::string latex() const;
  /// A table whose heads are buttons, which sort.
  std::string html(const std::string& id) const;

 private:
  Row head() const;
  // The cells of a row with `between` between them. `text_of` makes the text of a cell of a column.
  template <class TextOf>
  std::string joined(const Row& row, const char* between, const TextOf& text_of) const;
  // The same of all rows.
  template <class TextOf>
  std::string lines(const char* begin, const char* between, const char* end,
                    const TextOf& text_of) const;

  std::vector<Column> heads_;
  std::vector<Row> rows_;
};

/// Text for an element or an attribute of HTML. Bytes that are not UTF-8, as in names of files, and
/// control characters are replaced.
std::string escaped_html(std::string_view text);

}  // namespace tetraction
