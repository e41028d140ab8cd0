#include "study_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/quoting.h"
#include "study_names.h"

namespace tetraction {
namespace {

constexpr std::size_t kMostInTables = 400;  // characters of a cell of Markdown and LaTeX

std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80;
  }));
}

std::string padded(const std::string& text, std::size_t width, bool is_left) {
  const std::string spaces(width - std::min(width, width_of(text)), ' ');
  return is_left ? text + spaces : spaces + text;
}

// With a backslash before the characters of `marked`, and words for those of `words`.
std::string escaped(const std::string& any_text, std::string_view marked,
                    const std::map<char, std::string>& words) {
  std::string text;
  for (const char c : excerpt(any_text, kMostInTables)) {
    const auto word = words.find(c);
    if (word != words.end()) {
      text += word->second;
    } else {
      text += (marked.find(c) != std::string_view::npos ? "\\" : "") + std::string(1, c);
    }
  }
  return text;
}

std::string escaped_markdown(const std::string& text) {
  return escaped(text, "\\`*_[]<>|&~$#", {});
}

std::string escaped_latex(const std::string& text) {
  return escaped(text, "&%$#_{}",
                 {{'\\', "\\textbackslash{}"},
                  {'~', "\\textasciitilde{}"},
                  {'^', "\\textasciicircum{}"},
                  {'<', "\\textless{}"},
                  {'>', "\\textgreater{}"}});
}

// 7.2e-5 as a power of ten.
std::string latex_number(const std::string& text) {
  const auto power = text.find('e');
  if (power == std::string::npos) return escaped_latex(text);
  const int exponent = std::atoi(text.c_str() + power + 1);
  return fmt::format("${}\\cdot 10^{{{}}}$", text.substr(0, power), exponent);
}

}  // namespace

void StudyGrid::row(std::string rule, std::string run) {
  rows_.push_back({std::move(rule), std::move(run), {}, {}});
}

void StudyGrid::line(std::string text) {
  rows_.push_back({{}, {}, std::move(text), {}});
}

void StudyGrid::text(std::string text) {
  rows_.back().cells.push_back({std::move(text)});
}

void StudyGrid::number(double value, const char* format, const char* mark) {
  if (!std::isfinite(value)) return text("");
  const std::string shown =
      format == nullptr ? short_number(value) : fmt::format(fmt::runtime(format), value);
  rows_.back().cells.push_back({shown + mark, value});
}

StudyGrid::Row StudyGrid::head() const {
  Row row;
  for (const Column& column : heads_) row.cells.push_back({column.head});
  return row;
}

template <class TextOf>
std::string StudyGrid::joined(const Row& row, const char* between, const TextOf& text_of) const {
  std::string text;
  for (std::size_t i = 0; i < heads_.size(); ++i) {
    text += (i > 0 ? between : "") + text_of(heads_[i], row.cells[i]);
  }
  return text;
}

template <class TextOf>
std::string StudyGrid::lines(const char* begin, const char* between, const char* end,
                             const TextOf& text_of) const {
  std::string text;
  for (const Row& row : rows_) {
    if (!row.cells.empty()) text += begin + joined(row, between, text_of) + end;
  }
  return text;
}

std::string StudyGrid::terminal() const {
  const auto shown = [](const Cell& cell) {
    return cell.text.empty() ? std::string("-") : excerpt(cell.text);
  };
  std::vector<Row> rows{head()};
  rows.insert(rows.end(), rows_.begin(), rows_.end());
  std::vector<std::size_t> widths(heads_.size(), 0);
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      widths[i] = std::max(widths[i], width_of(shown(row.cells[i])));
    }
  }
  std::string text;
  for (const Row& row : rows) {
    std::string line = row.line;
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      line += (i > 0 ? "  " : "") + padded(shown(row.cells[i]), widths[i], heads_[i].is_text);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string StudyGrid::markdown() const {
  const auto cell = [](const Column&, const Cell& each) { return escaped_markdown(each.text); };
  const auto rule = [](const Column& column, const Cell&) {
    return std::string(column.is_text ? "---" : "---:");
  };
  return "| " + joined(head(), " | ", cell) + " |\n| " + joined(head(), " | ", rule) + " |\n" +
         lines("| ", " | ", " |\n", cell);
}

std::string StudyGrid::latex() const {
  const auto cell = [](const Column&, const Cell& each) {
    return std::isfinite(each.value) ? latex_number(each.text) : escaped_latex(each.text);
  };
  const auto place = [](const Column& column, const Cell&) {
    return std::string(column.is_text ? "l" : "r");
  };
  return "\\begin{tabular}{" + joined(head(), "", place) + "}\n\\hline\n" +
         joined(head(), " & ", cell) + " \\\\\n\\hline\n" + lines("", " & ", " \\\\\n", cell) +
         "\\hline\n\\end{tabular}\n";
}

std::string StudyGrid::html(const std::string& id) const {
  const auto kind = [](const Column& column) { return column.is_text ? " class=\"text\"" : ""; };
  const bool is_plain = id.empty();
  std::string text =
      is_plain ? "<table>" : fmt::format("<div class=\"scroll\"><table id=\"{}\">", id);
  text += "\n<thead><tr>";
  text += joined(head(), "", [&](const Column& column, const Cell&) {
    const std::string name = escaped_html(column.head);
    return fmt::format("<th scope=\"col\"{}>{}</th>", kind(column),
                       is_plain ? name : "<button type=\"button\">" + name + "</button>");
  });
  text += "</tr></thead>\n<tbody>\n";
  for (const Row& row : rows_) {
    if (row.cells.empty()) continue;
    text += fmt::format("<tr data-rule=\"{}\"", escaped_html(row.rule));
    text += row.run.empty() ? ">" : fmt::format(" data-run=\"{}\">", escaped_html(row.run));
    text += joined(row, "", [&](const Column& column, const Cell& cell) {
      const std::string value = std::isfinite(cell.value) ? fmt::format("{:.10g}", cell.value)
                                : column.is_text          ? escaped_html(cell.text)
                                                          : "";
      return fmt::format("<td{} data-value=\"{}\">{}</td>", kind(column), value,
                         cell.text.empty() && !column.is_text ? "–" : escaped_html(cell.text));
    });
    text += "</tr>\n";
  }
  return text + "</tbody>\n</table>" + (is_plain ? "\n" : "</div>\n");
}

std::string escaped_html(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t size = byte < 0x80 ? 1 : byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : 2;
    const std::string_view character = text.substr(i, size);
    const bool is_whole = byte < 0x80 || (byte >= 0xC2 && byte <= 0xF4 &&
                                          character.size() == size && width_of(character) == 1);
    if (!is_whole) {
      result += "\xEF\xBF\xBD";
      ++i;
      continue;
    }
    const char c = text[i];
    result += c == '&'                      ? "&amp;"
              : c == '<'                    ? "&lt;"
              : c == '>'                    ? "&gt;"
              : c == '"'                    ? "&quot;"
              : byte < 0x20 || byte == 0x7F ? " "
                                            : std::string(character);
    i += size;
  }
  return result;
}

}  // namespace tetraction
