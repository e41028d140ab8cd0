#include "study_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

std::string escaped_markdown(const std::string& any_text) {
  std::string text;
  for (const char c : excerpt(any_text, kMostInTables)) {
    if (std::string_view("\\`*_[]<>|&~$#").find(c) != std::string_view::npos) text += '\\';
    text += c;
  }
  return text;
}

std::string escaped_latex(const std::string& any_text) {
  std::string text;
  for (const char c : excerpt(any_text, kMostInTables)) {
    switch (c) {
      case '\\':
        text += "\\textbackslash{}";
        break;
      case '~':
        text += "\\textasciitilde{}";
        break;
      case '^':
        text += "\\textasciicircum{}";
        break;
      case '<':
        text += "\\textless{}";
        break;
      case '>':
        text += "\\textgreater{}";
        break;
      default:
        if (std::string_view("&%$#_{}").find(c) != std::string_view::npos) text += '\\';
        text += c;
    }
  }
  return text;
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

std::string StudyGrid::terminal() const {
  const auto shown = [](const Cell& cell) {
    return cell.text.empty() ? std::string("-") : excerpt(cell.text);
  };
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < heads_.size(); ++i) {
    widths.push_back(width_of(heads_[i].head));
    for (const Row& row : rows_) {
      if (!row.cells.empty()) widths[i] = std::max(widths[i], width_of(shown(row.cells[i])));
    }
  }
  const auto line_of = [&](const auto& text_of) {
    std::string line;
    for (std::size_t i = 0; i < heads_.size(); ++i) {
      line += (i > 0 ? "  " : "") + padded(text_of(i), widths[i], heads_[i].is_text);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line + '\n';
  };
  std::string text = line_of([&](std::size_t i) { return heads_[i].head; });
  for (const Row& row : rows_) {
    text += row.cells.empty() ? row.line + '\n'
                              : line_of([&](std::size_t i) { return shown(row.cells[i]); });
  }
  return text;
}

std::string StudyGrid::markdown() const {
  std::string text = "|";
  for (const Column& column : heads_) text += ' ' + escaped_markdown(column.head) + " |";
  text += "\n|";
  for (const Column& column : heads_) text += column.is_text ? " --- |" : " ---: |";
  text += '\n';
  for (const Row& row : rows_) {
    if (row.cells.empty()) continue;
    text += '|';
    for (const Cell& cell : row.cells) text += ' ' + escaped_markdown(cell.text) + " |";
    text += '\n';
  }
  return text;
}

std::string StudyGrid::latex() const {
  std::string columns;
  std::string heads;
  for (const Column& column : heads_) {
    columns += column.is_text ? 'l' : 'r';
    heads += (heads.empty() ? "" : " & ") + escaped_latex(column.head);
  }
  std::string text =
      fmt::format("\\begin{{tabular}}{{{}}}\n\\hline\n{} \\\\\n\\hline\n", columns, heads);
  for (const Row& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const Cell& cell = row.cells[i];
      line += (i > 0 ? " & " : "") +
              (std::isfinite(cell.value) ? latex_number(cell.text) : escaped_latex(cell.text));
    }
    if (!line.empty()) text += line + " \\\\\n";
  }
  return text + "\\hline\n\\end{tabular}\n";
}

std::string StudyGrid::html(const std::string& id) const {
  std::string text = fmt::format("<div class=\"scroll\"><table id=\"{}\">\n<thead><tr>", id);
  for (const Column& column : heads_) {
    text += fmt::format("<th scope=\"col\"{}><button type=\"button\">{}</button></th>",
                        column.is_text ? " class=\"text\"" : "", escaped_html(column.head));
  }
  text += "</tr></thead>\n<tbody>\n";
  for (const Row& row : rows_) {
    if (row.cells.empty()) continue;
    text += fmt::format("<tr data-rule=\"{}\"", escaped_html(row.rule));
    text += row.run.empty() ? ">" : fmt::format(" data-run=\"{}\">", escaped_html(row.run));
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const Cell& cell = row.cells[i];
      const bool is_number = std::isfinite(cell.value);
      text +=
          fmt::format("<td{} data-value=\"{}\">{}</td>", heads_[i].is_text ? " class=\"text\"" : "",
                      is_number           ? fmt::format("{:.10g}", cell.value)
                      : heads_[i].is_text ? escaped_html(cell.text)
                                          : "",
                      cell.text.empty() && !heads_[i].is_text ? "–" : escaped_html(cell.text));
    }
    text += "</tr>\n";
  }
  return text + "</tbody>\n</table></div>\n";
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
