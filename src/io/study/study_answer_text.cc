// The answer of a study as a table with a line for each rule.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/quoting.h"
#include "study_answer.h"
#include "study_grid.h"
#include "study_names.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The table and the sentences, with what the program says besides: where the results are, for instance.
constexpr std::size_t kMostLines = 40;
constexpr std::size_t kOtherLines = 8;

bool has_equal_runs(const TargetAnswer& a, const TargetAnswer& b) {
  return std::equal(a.rules.begin(), a.rules.end(), b.rules.begin(), b.rules.end(),
                    [](const RuleAnswer& x, const RuleAnswer& y) {
                      return x.verdict == y.verdict && x.run == y.run;
                    });
}

// `value` is the heading of a peak or a frequency; empty without one.
void add_columns(StudyGrid& grid, const std::string& value) {
  grid.column("step [s]");
  grid.column("h/h_crit");
  if (!value.empty()) grid.column(value);
  for (const char* head : {"error", "cost"}) grid.column(head);
}

void add_cells(StudyGrid& grid, const RuleAnswer* rule, double cost, bool has_value) {
  const double none = std::nan("");
  const bool has_run = rule != nullptr && rule->run != nullptr;
  grid.number(has_run ? rule->run->step : none);
  grid.number(has_run ? rule->run->step / rule->run->stable_step : none, "{:.3g}");
  if (has_value) grid.number(has_run ? rule->run->probe_value : none, "{:.6g}");
  grid.number(has_run ? rule->error : none);
  grid.number(cost, "{:.3g}");
}

// A line for each rule and target. Targets with the same lines are named together.
StudyGrid grid_of_rules(const StudyAnswer& answer, const std::string& value, bool repeats) {
  StudyGrid grid;
  grid.column("error below", true);
  grid.column("rule", true);
  add_columns(grid, value);
  grid.column("energy");
  grid.column("verdict", true);
  for (std::size_t i = 0; i < answer.targets.size(); ++i) {
    const TargetAnswer& target = answer.targets[i];
    const auto named = [](const TargetAnswer& each) {
      return short_number(100.0 * each.target) + " %";
    };
    std::string name = named(target);
    while (i + 1 < answer.targets.size() && has_equal_runs(answer.targets[i + 1], target)) {
      name += ", " + named(answer.targets[++i]);
    }
    for (const RuleAnswer& rule : target.rules) {
      grid.row(rule.rule);
      grid.text(repeats || &rule == &target.rules.front() ? name : " ");
      grid.text(rule.rule);
      add_cells(grid, &rule, rule.relative_cost, !value.empty());
      grid.number(rule.run != nullptr ? rule.run->max_relative_energy_drift : std::nan(""));
      grid.text(to_string(rule.verdict));
    }
  }
  return grid;
}

// A line for each variant with its cheapest rule. Costs are relative to those of the first variant.
StudyGrid grid_of_variants(const StudyAnswer& answer, const std::string& value) {
  StudyGrid grid;
  grid.column("variant", true);
  grid.column("difference");
  grid.column("h_crit [s]");
  grid.column("rule", true);
  add_columns(grid, value);
  grid.column("verdict", true);
  const RuleAnswer* first = answer.variants.front().answer.best();
  for (const VariantAnswer& variant : answer.variants) {
    const RuleAnswer* rule = variant.answer.best();
    grid.row();
    grid.text(variant.name);
    grid.number(&variant == &answer.variants.front() ? 0.0 : variant.difference);
    grid.number(variant.stable_step);
    grid.text(rule != nullptr ? rule->rule : "");
    const bool is_measured = rule != nullptr && first != nullptr;
    add_cells(grid, rule, is_measured ? rule->cost / first->cost : variant.least_cost_ratio,
              !value.empty());
    const bool is_own = !variant.answer.rules.empty();
    const StudyVerdict verdict = rule != nullptr ? StudyVerdict::kMet : StudyVerdict::kNotMet;
    grid.text(is_own ? fmt::format("{}: {} %", to_string(verdict),
                                   short_number(100 * variant.answer.target))
                     : "the reference of another one");
  }
  return grid;
}

StudyGrid answer_grid(const StudyResult& result, const StudyAnswer& answer, bool repeats) {
  // Whether each variant has an answer of its own.
  const bool is_sweep = result.references.size() > 1 && !answer.variants.empty();
  const std::string value = value_heading(result);
  return is_sweep ? grid_of_variants(answer, value) : grid_of_rules(answer, value, repeats);
}

// At most so many lines, of which the last one then says how many there are besides.
std::string first_lines(const std::string& text, std::size_t most) {
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  if (lines <= most) return text;
  std::size_t end = 0;
  for (std::size_t i = 1; i < most; ++i) end = text.find('\n', end) + 1;
  return text.substr(0, end) +
         fmt::format("… and {} more lines, with --table markdown\n", lines + 1 - most);
}

}  // namespace

AnswerFormat answer_format_from_string(const std::string& name) {
  if (name == "markdown") return AnswerFormat::kMarkdown;
  if (name == "latex") return AnswerFormat::kLatex;
  throw InputError(fmt::format(
      "--table {}: there are no such tables; there are markdown and latex.", in_quotes(name)));
}

std::string answer_text(const StudyResult& result, AnswerFormat format) {
  const StudyAnswer answer = study_answer(result);
  const bool is_terminal = format == AnswerFormat::kTerminal;
  const StudyGrid grid = answer_grid(result, answer, !is_terminal);
  if (format == AnswerFormat::kMarkdown) return grid.markdown();
  if (format == AnswerFormat::kLatex) return grid.latex();
  const std::vector<std::string> sentences = answer_sentences(result, answer);
  std::string text;
  if (!grid.is_empty()) {
    text = first_lines(grid.terminal(), kMostLines - kOtherLines - sentences.size()) + '\n';
  }
  for (const std::string& sentence : sentences) text += printable_message(sentence) + '\n';
  return text;
}

std::string answer_html(const StudyResult& result, const StudyAnswer& answer,
                        const std::string& id) {
  return answer_grid(result, answer, true).html(id);
}

}  // namespace tetraction
