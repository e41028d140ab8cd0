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

// With the head of the table and the sentences the terminal shows at most 40 lines.
constexpr std::size_t kMostLines = 26;

bool has_equal_runs(const TargetAnswer& a, const TargetAnswer& b) {
  return std::equal(a.rules.begin(), a.rules.end(), b.rules.begin(), b.rules.end(),
                    [](const RuleAnswer& x, const RuleAnswer& y) {
                      return x.verdict == y.verdict && x.run == y.run;
                    });
}

void add_columns(StudyGrid& grid) {
  grid.column("step [s]");
  for (const char* head : {"h/h_crit", "error", "cost"}) grid.column(head);
}

void add_cells(StudyGrid& grid, const RuleAnswer* rule, double cost) {
  const double none = std::nan("");
  const bool has_run = rule != nullptr && rule->run != nullptr;
  grid.number(has_run ? rule->run->step : none);
  grid.number(has_run ? rule->run->step / rule->run->stable_step : none, "{:.3g}");
  grid.number(has_run ? rule->error : none);
  grid.number(cost, "{:.3g}");
}

// A line for each rule and target. Targets with the same lines are named together.
StudyGrid grid_of_rules(const StudyAnswer& answer, bool repeats) {
  StudyGrid grid;
  grid.column("error below", true);
  grid.column("rule", true);
  add_columns(grid);
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
      add_cells(grid, &rule, rule.relative_cost);
      grid.number(rule.run != nullptr ? rule.run->max_relative_energy_drift : std::nan(""));
      grid.text(to_string(rule.verdict));
    }
  }
  return grid;
}

// A line for each variant with its cheapest rule. Costs are relative to those of the first variant.
StudyGrid grid_of_variants(const StudyAnswer& answer, std::size_t most) {
  StudyGrid grid;
  grid.column("variant", true);
  grid.column("difference");
  grid.column("h_crit [s]");
  grid.column("rule", true);
  add_columns(grid);
  grid.column("verdict", true);
  const RuleAnswer* first = answer.variants.front().answer.best();
  for (std::size_t i = 0; i < std::min(most, answer.variants.size()); ++i) {
    const VariantAnswer& variant = answer.variants[i];
    const RuleAnswer* rule = variant.answer.best();
    grid.row();
    grid.text(variant.name);
    grid.number(i == 0 ? 0.0 : variant.difference);
    grid.number(variant.stable_step);
    grid.text(rule != nullptr ? rule->rule : "");
    const bool is_measured = rule != nullptr && first != nullptr;
    add_cells(grid, rule, is_measured ? rule->cost / first->cost : variant.least_cost_ratio);
    const bool is_own = !variant.answer.rules.empty();
    const StudyVerdict verdict = rule != nullptr ? StudyVerdict::kMet : StudyVerdict::kNotMet;
    grid.text(is_own ? fmt::format("{}: {} %", to_string(verdict),
                                   short_number(100 * variant.answer.target))
                     : "the reference of another one");
  }
  return grid;
}

// Whether each variant has an answer of its own.
bool is_sweep(const StudyResult& result, const StudyAnswer& answer) {
  return result.references.size() > 1 && !answer.variants.empty();
}

StudyGrid answer_grid(const StudyResult& result, const StudyAnswer& answer, bool is_terminal,
                      bool repeats) {
  return is_sweep(result, answer)
             ? grid_of_variants(answer, is_terminal ? kMostLines : answer.variants.size())
             : grid_of_rules(answer, repeats);
}

// At most so many lines, and how many more there are.
std::string first_lines(const std::string& text, std::size_t most) {
  std::size_t lines = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\n' || ++lines < most) continue;
    const auto more =
        std::count(text.begin() + static_cast<std::ptrdiff_t>(i) + 1, text.end(), '\n');
    if (more == 0) break;
    return text.substr(0, i + 1) + fmt::format("… and {} more lines, with --all\n", more);
  }
  return text;
}

}  // namespace

AnswerFormat answer_format_from_string(const std::string& name) {
  if (name == "markdown") return AnswerFormat::kMarkdown;
  if (name == "latex") return AnswerFormat::kLatex;
  throw InputError(fmt::format(
      "--table {}: there are no such tables; there are markdown and latex.", in_quotes(name)));
}

std::string answer_text(const StudyResult& result, const AnswerOptions& options) {
  const StudyAnswer answer = study_answer(result);
  const bool is_terminal = options.format == AnswerFormat::kTerminal;
  const StudyGrid grid = answer_grid(result, answer, is_terminal, !is_terminal);
  if (options.format == AnswerFormat::kMarkdown) return grid.markdown();
  if (options.format == AnswerFormat::kLatex) return grid.latex();
  std::string text;
  if (!grid.is_empty()) {
    text = first_lines(grid.terminal(), kMostLines + 1);
    const std::size_t hidden =
        answer.variants.size() - std::min(answer.variants.size(), kMostLines);
    if (is_sweep(result, answer) && hidden > 0) {
      text += fmt::format("… and {} more variants, with --all\n", hidden);
    }
    text += "\n";
  }
  for (const std::string& sentence : answer_sentences(result, answer)) {
    text += printable_message(sentence) + "\n";
  }
  return text;
}

std::string answer_html(const StudyResult& result, const StudyAnswer& answer) {
  return answer_grid(result, answer, false, true).html("answer");
}

}  // namespace tetraction
