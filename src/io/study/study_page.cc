#include "study_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_answer.h"
#include "study_fields.h"
#include "study_grid.h"
#include "study_names.h"
#include "study_page_files.h"
#include "study_plots.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

struct Phase {
  const char* name;
  double RunPhases::*seconds;
  const char* key;  // in summary.json
};
constexpr Phase kPhases[] = {{"mesh", &RunPhases::mesh, "mesh"},
                             {"setup", &RunPhases::setup, "setup"},
                             {"stability limit", &RunPhases::stability, "stability"},
                             {"time steps", &RunPhases::stepping, "stepping"},
                             {"output", &RunPhases::output, "output"}};

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      group = group << 8U | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j <= bytes.size() ? kDigits[group >> (18U - 6U * j) & 63U] : '=';
    }
  }
  return text;
}

// The digest of the script as a Content-Security-Policy has it.
std::string script_digest() {
  const std::string_view hex = kStudyPageScriptDigest;
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return "sha256-" + base64(bytes);
}

// The template with {{name}} replaced. Values are not searched for further names.
std::string filled(std::string_view page, const std::map<std::string_view, std::string>& values) {
  std::string text;
  while (true) {
    const auto begin = page.find("{{");
    text += page.substr(0, begin);
    if (begin == std::string_view::npos) return text;
    const auto end = page.find("}}", begin);
    text += values.at(page.substr(begin + 2, end - begin - 2));
    page.remove_prefix(end + 2);
  }
}

std::string list_html(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += "<li>" + escaped_html(sentence) + "</li>\n";
  return text.empty() ? text : "<ul>\n" + text + "</ul>\n";
}

void remove_parts(std::string& text, std::string_view begin, std::string_view end) {
  for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    const auto last = text.find(end, at + begin.size());
    if (last == std::string::npos) return;
    text.erase(at, last + end.size() - at);
  }
}

// The drawing for the middle of a page, without what could act on the page or load anything. Empty if something of
// that kind is left: then the page shows it as an image, in which nothing runs.
std::string inline_svg(const std::string& file) {
  const auto begin = file.find("<svg");
  const auto end = file.rfind("</svg>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  std::string svg = file.substr(begin, end + 6 - begin);
  remove_parts(svg, "<!--", "-->");
  remove_parts(svg, "<metadata", "</metadata>");
  remove_parts(svg, "<style", "</style>");
  std::string lower = svg;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  for (const char* part : {"<script", "<foreignobject", "<iframe", "<!", "<?", "<a ", "<style",
                           "<animate", "<set", "</div", "</figure", "javascript:", "data:text"}) {
    if (lower.find(part) != std::string::npos) return {};
  }
  // Attributes: no handlers, and links within the drawing or to pictures in itself only.
  for (std::size_t at = lower.find('='); at != std::string::npos; at = lower.find('=', at + 1)) {
    const auto is_name = [&](std::size_t i) {
      return std::isalpha(static_cast<unsigned char>(lower[i])) != 0;
    };
    std::size_t last = at;
    while (last > 0 && std::isspace(static_cast<unsigned char>(lower[last - 1])) != 0) --last;
    std::size_t name = last;
    while (name > 0 && is_name(name - 1)) --name;
    const std::string_view key = std::string_view(lower).substr(name, last - name);
    const std::string_view value = std::string_view(lower).substr(at + 1, 12);
    const bool is_link = key == "href" || key == "src";
    if (key.starts_with("on") ||
        (is_link && !value.starts_with("\"#") && value != "\"data:image/")) {
      return {};
    }
  }
  return svg;
}

// Drawings wider than a column of a journal get the whole width of the page.
bool is_wide(const std::string& svg) {
  const auto at = svg.find("width=\"");
  return at != std::string::npos && std::atof(svg.c_str() + at + 7) > 300.0;
}

// A plot with its heading and caption.
std::string figure_html(const StudyPicture& picture) {
  std::string drawing = inline_svg(picture.svg);
  if (drawing.empty()) {
    drawing = fmt::format("<img alt=\"{}\" src=\"data:image/svg+xml;base64,{}\">",
                          escaped_html(picture.heading), base64(picture.svg));
  }
  return fmt::format("<figure{}><h3>{}</h3>\n{}\n<figcaption>{}</figcaption></figure>\n",
                     is_wide(picture.svg) ? " class=\"wide\"" : "", escaped_html(picture.heading),
                     drawing, escaped_html(picture.caption));
}

// All plots but that of the answer.
std::string plots_html(const StudyPageContents& contents) {
  std::string text;
  for (const StudyPicture& picture : contents.pictures) text += figure_html(picture);
  return text.empty() ? "<p>There are none.</p>\n"
                      : "<div class=\"figures\">\n" + text + "</div>\n";
}

// What stands beside the answer: the plot of the errors, and why plots are missing.
std::string answer_picture_html(const StudyPageContents& contents) {
  std::string text = contents.answer_picture ? figure_html(*contents.answer_picture) : "";
  if (!contents.why_no_pictures.empty()) {
    text += fmt::format("<p id=\"no-plots\">{}</p>\n", escaped_html(contents.why_no_pictures));
  }
  return text;
}

std::string findings_html(const StudyResult& result) {
  std::string text;
  for (const StudyConclusion& conclusion : study_conclusions(result)) {
    text += fmt::format("<h3>{}</h3>\n", escaped_html(conclusion.topic)) +
            list_html(conclusion.sentences);
  }
  return text + (result.remarks.empty() ? "" : "<h3>Remarks</h3>\n" + list_html(result.remarks));
}

std::string phases_html(const std::vector<RunPhases>& phases) {
  if (phases.empty()) return "<p>No run has a summary with its wall times.</p>\n";
  StudyGrid grid;
  grid.column("run", true);
  grid.column("step [s]");
  for (const Phase& phase : kPhases) grid.column(fmt::format("{} [s]", phase.name));
  grid.column("total [s]");
  for (const RunPhases& run : phases) {
    grid.row(run.rule);
    grid.text(run.label);
    grid.number(run.step);
    for (const Phase& phase : kPhases) grid.number(run.*phase.seconds);
    grid.number(run.total());
  }
  return grid.html("phases");
}

std::string provenance_html(const StudyResult& result, const StudyProvenance& provenance) {
  std::string text = "<dl id=\"provenance\">\n";
  const auto entry = [&](const char* name, const std::string& value) {
    if (!value.empty()) text += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escaped_html(value));
  };
  // Values of the rows without repeats.
  const auto different = [&](const auto& value_of) {
    std::set<std::string> values;
    for (const StudyRow& row : result.rows) {
      if (!row.processor.empty()) values.insert(value_of(row));
    }
    return fmt::format("{}", fmt::join(values, "; "));
  };
  entry("Program", "Tetraction " + version());
  entry("Machine", different([](const StudyRow& row) {
          return fmt::format("{}, {} logical core{}", row.processor, row.cores,
                             row.cores == 1 ? "" : "s");
        }));
  entry("Threads", different([](const StudyRow& row) { return fmt::format("{}", row.threads); }));
  entry("Date", provenance.date);
  entry("Command", provenance.command);
  entry("End of the motion", short_number(result.end) + " s");
  entry("Reference",
        fmt::format("{} ({}){}", reference_name(result), to_string(result.reference_status),
                    result.references.empty() ? ""
                                              : fmt::format(", and {} more of other variants",
                                                            result.references.size() - 1)));
  if (std::isfinite(result.reference_error)) {
    entry("Error of the reference", short_number(result.reference_error) + " (estimated)");
  }
  if (std::isfinite(result.stable_step)) {
    entry("Stability limit", fmt::format("h_crit = {} s (explicit, at the initial state)",
                                         short_number(result.stable_step)));
  }
  return text + "</dl>\n";
}

std::vector<RunPhases> read_phases(const StudyResult& result, const std::string& directory) {
  std::vector<RunPhases> phases;
  std::set<std::string> known;
  const auto add = [&](const std::string& run, const std::string& rule, const std::string& label,
                       double step) {
    if (!known.insert(run).second) return;
    const auto json = parse_foreign_json(read_output(directory + "/" + run + "/summary.json"));
    const auto& times = member_of(json, "wall_seconds");
    if (times.is_null()) return;
    RunPhases found{rule, label, step};
    for (const Phase& phase : kPhases) {
      found.*phase.seconds = number_or(member_of(times, phase.key), 0.0);
    }
    phases.push_back(found);
  };
  for (const StudyRow& row : result.rows) {
    add(row.directory, rule_name(row), run_label(row), row.step);
  }
  const std::string rule = to_string(result.reference_integrator);
  add(result.reference_directory, rule, rule + " (reference)", result.reference_step);
  for (const VariantReference& reference : result.references) {
    add(reference.directory, rule, fmt::format("{} (reference of {})", rule, reference.variant),
        result.reference_step);
  }
  return phases;
}

void read_pictures(const StudyResult& result, const std::string& directory,
                   StudyPageContents& contents) {
  const auto add = [&](const std::string& name, const std::string& heading,
                       const std::string& caption) {
    StudyPicture picture{heading, caption, read_output(directory + "/" + name + ".svg")};
    if (picture.svg.empty()) return;
    if (name == "error_over_step") {
      contents.answer_picture = std::move(picture);
    } else {
      contents.pictures.push_back(std::move(picture));
    }
  };
  for (const StudyPlot& plot : kStudyPlots) add(plot.name, plot.heading, plot.caption);
  for (const ProbeColumns& probe : result.probes) {
    if (probe.name.find('/') != std::string::npos) continue;
    add("probe_" + probe.name, fmt::format("Probe {} over time", probe.name),
        "Left: the values. Right: the magnitude of their difference from the (finest run of the) "
        "reference.");
  }
}

}  // namespace

StudyGrid grid_of_all_runs(const StudyResult& result) {
  std::vector<const StudyField*> fields = shown_fields(kOnPage);
  // Columns that are empty in all rows are left out.
  std::erase_if(fields, [&](const StudyField* field) {
    return std::all_of(result.rows.begin(), result.rows.end(), [&](const StudyRow& row) {
      const auto value = field_value(*field, row);
      return value.is_null() || value == "";
    });
  });
  StudyGrid grid;
  for (const StudyField* field : fields) {
    grid.column(heading_of(*field, result), !field->is_number());
  }
  for (const StudyRow& row : result.rows) {
    grid.row(rule_name(row), row.directory);
    for (const StudyField* field : fields) add_field(grid, *field, row);
  }
  return grid;
}

std::string study_page(const StudyResult& result, const StudyPageContents& contents) {
  const StudyAnswer answer = study_answer(result);
  const bool has_shared = std::any_of(result.rows.begin(), result.rows.end(),
                                      [](const StudyRow& row) { return row.shares_machine; });
  const std::string question =
      fmt::format("Which rule and step reach {} {} of {} % at the least cost?",
                  result.error_probe.empty() ? "a" : "an", error_name(result),
                  result.target ? short_number(100.0 * *result.target) : "10, 1 and 0.1");
  return filled(
      kStudyPageHtml,
      {{"script_digest", script_digest()},
       {"title", escaped_html("Step-size study: " + contents.scene_name)},
       {"style", kStudyPageStyle},
       {"question", escaped_html(question)},
       {"sentences", list_html(answer_sentences(result, answer))},
       {"picture", answer_picture_html(contents)},
       {"answer", answer_html(result, answer)},
       {"plots", plots_html(contents)},
       {"findings", findings_html(result)},
       {"shared", has_shared
                      ? " Wall times with * do not count: these runs shared the cores of the "
                        "machine with others, or had more threads than cores."
                      : ""},
       {"runs", grid_of_all_runs(result).html("runs")},
       {"phases", phases_html(contents.phases)},
       {"provenance", provenance_html(result, contents.provenance)},
       {"script", kStudyPageScript}});
}

void write_study_page(const StudyResult& result, const std::string& scene_name,
                      const std::string& directory, const StudyProvenance& provenance,
                      const std::string& why_no_pictures) {
  StudyPageContents contents;
  contents.scene_name = scene_name;
  contents.provenance = provenance;
  contents.why_no_pictures = why_no_pictures;
  read_pictures(result, directory, contents);
  if (contents.pictures.empty() && !contents.answer_picture && why_no_pictures.empty()) {
    contents.why_no_pictures = "There are no plots, because no run has an error above zero.";
  }
  contents.phases = read_phases(result, directory);
  write_text_file(directory + "/" + kStudyPage, study_page(result, contents));
}

}  // namespace tetraction
