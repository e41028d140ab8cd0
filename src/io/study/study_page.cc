#include "study_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_conclusions.h"
#include "study_plots.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --line: #8886; --soft: #8882; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2rem; } h3 { font-size: 1.05rem; margin-bottom: 0.2rem; }
h1, h2 { border-bottom: 1px solid var(--line); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.1rem 1rem; }
dt { font-weight: 600; } dd { margin: 0; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; }
#messages { display: block; font-size: 0.85rem; } #messages dd { margin: 0 0 0.4rem 1.5rem; }
table { border-collapse: collapse; font-size: 0.8rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.2rem 0.4rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th.text, td.text { text-align: left; }
th { vertical-align: bottom; border-bottom-width: 2px; }
th button { font: inherit; font-weight: 600; color: inherit; background: none; border: 0; padding: 0; cursor: pointer; white-space: pre-line; text-align: inherit; }
th button:hover { text-decoration: underline; }
th[aria-sort=ascending] button::after { content: " \25B2"; }
th[aria-sort=descending] button::after { content: " \25BC"; }
tbody tr:nth-child(even) { background: var(--soft); }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 1rem; align-items: start; grid-auto-flow: dense; }
figure { margin: 0; }
figure.wide { grid-column: 1 / -1; }
figure img { background: #fff; width: 100%; height: auto; max-width: 60rem; border: 1px solid var(--line); box-sizing: border-box; }
figcaption { font-size: 0.85rem; }
.bar { display: flex; width: 14rem; height: 0.9rem; }
.bar span, .key { display: inline-block; height: 100%; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
.key { width: 0.8rem; height: 0.8rem; margin: 0 0.3rem 0 0.8rem; }
@media print {
  body { max-width: none; font-size: 10pt; padding: 0; }
  figure, tr { break-inside: avoid; } h2, h3 { break-after: avoid; }
  .scroll { overflow: visible; } table { font-size: 6.5pt; } th, td { padding: 0.1rem 0.2rem; }
  .figures { grid-template-columns: 1fr 1fr; }
}
)";

// Cells without a number come last in both directions.
constexpr const char* kScript = R"(
for (const table of document.querySelectorAll("table")) {
  table.querySelectorAll("th").forEach((head, column) => head.querySelector("button").addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") === "ascending";
    table.querySelectorAll("th").forEach(other => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const key = row => row.cells[column].dataset.value;
    const rows = [...table.tBodies[0].rows].sort((a, b) => {
      const x = key(a), y = key(b);
      if (x === "" || y === "") return (x === "") - (y === "");
      const order = isNaN(x) || isNaN(y) ? x.localeCompare(y) : x - y;
      return down ? -order : order;
    });
    table.tBodies[0].append(...rows);
  }));
}
)";

struct Phase {
  const char* name;
  double RunPhases::*seconds;
  const char* color;
};
constexpr Phase kPhases[] = {{"mesh", &RunPhases::mesh, "#999999"},
                             {"setup", &RunPhases::setup, "#56B4E9"},
                             {"stability limit", &RunPhases::stability, "#F0E442"},
                             {"time steps", &RunPhases::stepping, "#0072B2"},
                             {"output", &RunPhases::output, "#D55E00"}};

// Text for an element or an attribute. Bytes that are not UTF-8, as in names of files, and control
// characters are replaced.
std::string escaped(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x80) {
      switch (text[i]) {
        case '&':
          result += "&amp;";
          break;
        case '<':
          result += "&lt;";
          break;
        case '>':
          result += "&gt;";
          break;
        case '"':
          result += "&quot;";
          break;
        default:
          result += byte < 0x20 || byte == 0x7F ? ' ' : text[i];
      }
      ++i;
      continue;
    }
    const std::size_t size = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : 2;
    const bool is_whole =
        byte >= 0xC2 && byte <= 0xF4 && i + size <= text.size() &&
        std::all_of(text.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                    text.begin() + static_cast<std::ptrdiff_t>(i + size),
                    [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80; });
    result += is_whole ? std::string(text.substr(i, size)) : "\xEF\xBF\xBD";
    i += is_whole ? size : 1;
  }
  return result;
}

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

// A table whose columns can be sorted.
class Table {
 public:
  explicit Table(std::string id) : id_(std::move(id)) {}

  void column(const char* name, bool is_text = false) {
    head_ += fmt::format("<th scope=\"col\"{}><button type=\"button\">{}</button></th>",
                         is_text ? " class=\"text\"" : "", escaped_lines(name));
  }
  void row() { body_ += body_.empty() ? "<tr>" : "</tr>\n<tr>"; }
  void text(const std::string& value) {
    body_ +=
        fmt::format("<td class=\"text\" data-value=\"{}\">{}</td>", escaped(value), escaped(value));
  }
  void number(double value) { number(value, short_number(value)); }
  void number(double value, const char* format) {
    number(value, fmt::format(fmt::runtime(format), value));
  }
  void number(double value, const std::string& shown) {
    if (!std::isfinite(value)) {
      body_ += "<td data-value=\"\">–</td>";
      return;
    }
    body_ += fmt::format("<td data-value=\"{:.10g}\">{}</td>", value, shown);
  }
  // A cell of HTML that is sorted by a number.
  void html(double value, const std::string& content) {
    body_ += fmt::format("<td data-value=\"{:.10g}\">{}</td>", value, content);
  }
  std::string finish() const {
    return fmt::format(
        "<div class=\"scroll\"><table id=\"{}\">\n<thead><tr>{}</tr></thead>\n<tbody>\n{}{}\n"
        "</tbody>\n</table></div>\n",
        id_, head_, body_, body_.empty() ? "" : "</tr>");
  }

 private:
  // A name may have a line break, which the button keeps.
  static std::string escaped_lines(const std::string& name) {
    const auto end = name.find('\n');
    return end == std::string::npos
               ? escaped(name)
               : escaped(name.substr(0, end)) + "\n" + escaped(name.substr(end + 1));
  }

  std::string id_;
  std::string head_;
  std::string body_;
};

template <class Predicate>
bool any_row(const StudyResult& result, const Predicate& predicate) {
  return std::any_of(result.rows.begin(), result.rows.end(), predicate);
}

// Values of the rows without repeats, in their order.
template <class Getter>
std::string different(const StudyResult& result, const Getter& get) {
  std::vector<std::string> values;
  for (const StudyRow& row : result.rows) {
    const std::string value = get(row);
    if (!value.empty() && std::find(values.begin(), values.end(), value) == values.end()) {
      values.push_back(value);
    }
  }
  return fmt::format("{}", fmt::join(values, "; "));
}

std::string provenance_html(const StudyResult& result, const StudyPageContents& contents) {
  std::string text = "<dl id=\"provenance\">\n";
  const auto entry = [&](const char* name, const std::string& value) {
    if (!value.empty()) text += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escaped(value));
  };
  entry("Program", "Tetraction " + version());
  entry("Machine", different(result, [](const StudyRow& row) {
          return row.processor.empty() ? std::string()
                                       : fmt::format("{}, {} logical core{}", row.processor,
                                                     row.cores, row.cores == 1 ? "" : "s");
        }));
  entry("Threads", different(result, [](const StudyRow& row) {
          return row.threads > 0 ? fmt::format("{}", row.threads) : std::string();
        }));
  entry("Date", contents.provenance.date);
  if (!contents.provenance.command.empty()) {
    text += fmt::format("<dt>Command</dt><dd><code>{}</code></dd>\n",
                        escaped(contents.provenance.command));
  }
  entry("End of the motion", short_number(result.end) + " s");
  const auto reference_entry = [&](const std::string& of, const StudyResult& part) {
    entry(("Reference" + of).c_str(),
          fmt::format("{} ({})", reference_name(part), to_string(part.reference_status)));
    if (std::isfinite(part.reference_error)) {
      entry(("Error of the reference" + of).c_str(),
            short_number(part.reference_error) + " (estimated)");
    }
  };
  if (result.references.empty()) reference_entry("", result);
  const std::vector<StudyResult> parts = parts_of_study(result);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    reference_entry(escaped(" of " + enumeration(result.references[i].variants)), parts[i]);
  }
  if (std::isfinite(result.stable_step)) {
    entry("Stability limit", fmt::format("h_crit = {} s (explicit, at the initial state)",
                                         short_number(result.stable_step)));
  }
  return text + "</dl>\n";
}

std::string conclusions_html(const StudyResult& result) {
  std::string text;
  for (const StudyConclusion& conclusion : study_conclusions(result)) {
    text += fmt::format("<h3>{}</h3>\n<ul>\n", escaped(conclusion.topic));
    for (const std::string& sentence : conclusion.sentences) {
      text += fmt::format("<li>{}</li>\n", escaped(sentence));
    }
    text += "</ul>\n";
  }
  if (!result.remarks.empty()) {
    text += "<h3>Remarks</h3>\n<ul>\n";
    for (const std::string& remark : result.remarks) {
      text += fmt::format("<li>{}</li>\n", escaped(remark));
    }
    text += "</ul>\n";
  }
  return text;
}

std::string pictures_html(const StudyPageContents& contents) {
  if (contents.pictures.empty()) {
    return fmt::format("<p id=\"no-plots\">{}</p>\n", escaped(contents.why_no_pictures));
  }
  std::string text = "<div class=\"figures\">\n";
  for (const StudyPicture& picture : contents.pictures) {
    // Pictures with several panels get the whole width.
    const bool is_wide = picture.heading.find("over time") != std::string::npos;
    text += fmt::format(
        "<figure{}><h3>{}</h3>\n<img alt=\"{}\" src=\"data:image/svg+xml;base64,{}\">\n"
        "<figcaption>{}</figcaption></figure>\n",
        is_wide ? " class=\"wide\"" : "", escaped(picture.heading), escaped(picture.heading),
        base64(picture.svg), escaped(picture.caption));
  }
  return text + "</div>\n";
}

std::string phases_html(const std::vector<RunPhases>& phases) {
  if (phases.empty()) return "<p>No run has a summary with its wall times.</p>\n";
  std::string text =
      "<p>Wall time of each run by phase. Of these, the table of all runs and the "
      "plots count the time steps alone.";
  // The mesh of a study is read once, before its runs.
  std::vector<Phase> shown;
  for (const Phase& phase : kPhases) {
    const bool has_time = std::any_of(phases.begin(), phases.end(), [&](const RunPhases& run) {
      return run.*phase.seconds > 0.0;
    });
    if (has_time) shown.push_back(phase);
  }
  for (const Phase& phase : shown) {
    text += fmt::format(" <span class=\"key\" style=\"background:{}\"></span>{}", phase.color,
                        phase.name);
  }
  text += "</p>\n";
  Table table("phases");
  table.column("run", true);
  table.column("h [s]");
  for (const Phase& phase : shown) table.column(fmt::format("{}\n[s]", phase.name).c_str());
  table.column("total\n[s]");
  table.column("share of each phase");
  for (const RunPhases& run : phases) {
    table.row();
    table.text(run.label);
    table.number(run.step);
    std::string bar = "<div class=\"bar\">";
    for (const Phase& phase : shown) {
      table.number(run.*phase.seconds);
      const double share = run.total() > 0.0 ? run.*phase.seconds / run.total() : 0.0;
      bar +=
          fmt::format("<span style=\"width:{:.2f}%;background:{}\" title=\"{} {:.1f} %\"></span>",
                      100.0 * share, phase.color, phase.name, 100.0 * share);
    }
    table.number(run.total());
    table.html(run.total() > 0.0 ? run.stepping / run.total() : 0.0, bar + "</div>");
  }
  return text + table.finish();
}

// What the runs that did not reach the end say themselves.
std::string messages_html(const StudyResult& result) {
  std::string text;
  for (const StudyRow& row : result.rows) {
    if (row.message.empty()) continue;
    text += fmt::format("<dt>{}, h = {} s</dt><dd>{}</dd>\n", escaped(run_label(row)),
                        short_number(row.step), escaped(row.message));
  }
  return text.empty() ? text : "<h3>Messages</h3>\n<dl id=\"messages\">\n" + text + "</dl>\n";
}

std::string runs_html(const StudyResult& result) {
  const bool has_variants =
      any_row(result, [](const StudyRow& row) { return !row.variant.empty(); });
  const bool has_solvers = any_row(result, [](const StudyRow& row) { return !row.solver.empty(); });
  const bool has_probe = !result.error_probe.empty();
  Table table("runs");
  if (has_variants) table.column("variant", true);
  table.column("integrator", true);
  if (has_solvers) table.column("solver", true);
  for (const char* name : {"h [s]", "h/h_crit"}) table.column(name);
  for (const char* name : {"status", "role"}) table.column(name, true);
  for (const char* name :
       {"steps", "wall time\n[s]", "iterations\nper step", "energy\nerror", "linear\nmomentum",
        "angular\nmomentum", "position\nerror", "position\nerror, rms"}) {
    table.column(name);
  }
  if (has_probe) table.column("probe\nerror");
  table.column("observed\norder");
  for (const StudyRow& row : result.rows) {
    // The reference's differences from itself are no errors.
    const auto error = [&](double value) {
      table.number(row.is_reference ? std::nan("") : value, "{:.2e}");
    };
    table.row();
    if (has_variants) table.text(row.variant);
    table.text(to_string(row.integrator));
    if (has_solvers) table.text(row.solver);
    table.number(row.step);
    table.number(row.step / row.stable_step);
    table.text(to_string(row.status));
    table.text(to_string(row.role));
    table.number(static_cast<double>(row.steps), "{:.0f}");
    table.number(row.wall_seconds,
                 short_number(row.wall_seconds) + (row.shares_machine ? "*" : ""));
    table.number(is_implicit(row.integrator) ? row.iterations_per_step : std::nan(""), "{:.2f}");
    table.number(row.max_relative_energy_drift, "{:.1e}");
    table.number(row.linear_momentum_drift, "{:.1e}");
    table.number(row.angular_momentum_drift, "{:.1e}");
    error(row.position_error);
    error(row.position_error_rms);
    if (has_probe) error(row.probe_error);
    table.number(row.observed_order, "{:.2f}");
  }
  return "<p>A click on the head of a column sorts the table. Energy errors are relative to the "
         "energy that entered. The momenta are their changes that no impulse explains, relative to "
         "the momentum. Position errors are relative to the displacement of the reference." +
         std::string(any_row(result, [](const StudyRow& row) { return row.shares_machine; })
                         ? " Wall times with * do not count: these runs shared the cores of the "
                           "machine with others, or had more threads than cores."
                         : "") +
         "</p>\n" + table.finish() + messages_html(result);
}

std::vector<RunPhases> read_phases(const StudyResult& result, const std::string& directory) {
  std::vector<RunPhases> phases;
  const auto add = [&](const std::string& run, const std::string& label, double step) {
    const auto json = parse_foreign_json(read_output(directory + "/" + run + "/summary.json"));
    const auto& times = member_of(json, "wall_seconds");
    if (times.is_null()) return;
    const auto seconds = [&](const char* key) { return number_or(member_of(times, key), 0.0); };
    phases.push_back({label, step, seconds("mesh"), seconds("setup"), seconds("stability"),
                      seconds("stepping"), seconds("output")});
  };
  std::set<std::string> rows;
  for (const StudyRow& row : result.rows) {
    add(row.directory, run_label(row), row.step);
    rows.insert(row.directory);
  }
  if (result.references.empty() && !rows.contains(result.reference_directory)) {
    add(result.reference_directory, to_string(result.reference_integrator) + " (reference)",
        result.reference_step);
  }
  for (const VariantReference& reference : result.references) {
    if (rows.contains(reference.directory)) continue;
    add(reference.directory,
        fmt::format("{} (reference of {})", to_string(result.reference_integrator),
                    reference.variant),
        result.reference_step);
  }
  return phases;
}

std::vector<StudyPicture> read_pictures(const StudyResult& result, const std::string& directory) {
  std::vector<StudyPicture> pictures;
  const auto add = [&](const std::string& name, const std::string& heading,
                       const std::string& caption) {
    std::string svg = read_output(directory + "/" + name + ".svg");
    if (!svg.empty()) pictures.push_back({heading, caption, std::move(svg)});
  };
  for (const StudyPlot& plot : kStudyPlots) add(plot.name, plot.heading, plot.caption);
  for (const ProbeColumns& probe : result.probes) {
    if (probe.name.find('/') != std::string::npos) continue;
    add("probe_" + probe.name, fmt::format("Probe {} over time", probe.name),
        result.extrapolation && result.extrapolation->is_valid
            ? "Left: the values. Right: the magnitude of their difference from the finest run of "
              "the "
              "reference, before the extrapolation."
            : "Left: the values. Right: the magnitude of their difference from the reference.");
  }
  return pictures;
}

}  // namespace

std::string study_page(const StudyResult& result, const StudyPageContents& contents) {
  const std::string title = "Step-size study: " + contents.scene_name;
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<h1>{}</h1>\n",
      escaped(title), kStyle, escaped(title));
  page += provenance_html(result, contents);
  page += "<h2>Summary</h2>\n" + conclusions_html(result);
  page += "<h2>Plots</h2>\n" + pictures_html(contents);
  page += "<h2>Cost by phase</h2>\n" + phases_html(contents.phases);
  page += "<h2>All runs</h2>\n" + runs_html(result);
  page += fmt::format("<script>{}</script>\n</body>\n</html>\n", kScript);
  return page;
}

void write_study_page(const StudyResult& result, const std::string& scene_name,
                      const std::string& directory, const StudyProvenance& provenance,
                      const std::string& why_no_pictures) {
  StudyPageContents contents;
  contents.scene_name = scene_name;
  contents.provenance = provenance;
  contents.why_no_pictures = why_no_pictures;
  if (why_no_pictures.empty()) contents.pictures = read_pictures(result, directory);
  if (contents.pictures.empty() && why_no_pictures.empty()) {
    contents.why_no_pictures = "There are no plots, because no run has an error above zero.";
  }
  contents.phases = read_phases(result, directory);
  write_text_file(directory + "/" + kStudyPage, study_page(result, contents));
}

}  // namespace tetraction
