// The answer of a study, its sentences, and how its page shows them.
#include "io/study/study_answer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/study/study_fields.h"
#include "io/study/study_names.h"
#include "io/study/study_page.h"
#include "io/study/study_row_json.h"
#include "support/messages.h"
#include "tetraction/io/study_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

StudyRow row_of(Integrator integrator, double step, double error, double seconds) {
  StudyRow row;
  row.integrator = integrator;
  row.step = step;
  row.stable_step = 1e-4;
  row.status = RunStatus::kFinished;
  row.steps = 100;
  row.wall_seconds = seconds;
  row.position_error = row.position_error_rms = error;
  row.observed_order = kNone;
  row.max_relative_energy_drift = 1e-3;
  row.processor = "first processor";
  row.cores = row.threads = 2;
  row.directory = to_string(integrator);
  if (is_implicit(integrator)) row.solver = "newton";
  return row;
}

// Verlet below the limit, midpoint above it.
StudyResult two_rules() {
  StudyResult result;
  result.stable_step = 1e-4;
  result.end = 0.01;
  result.reference_integrator = Integrator::kVerlet;
  result.reference_step = 1e-5;
  result.reference_status = RunStatus::kFinished;
  result.reference_error = 1e-5;
  result.rows = {row_of(Integrator::kVerlet, 5e-5, 2e-3, 2.0),
                 row_of(Integrator::kVerlet, 7.2e-5, 4e-3, 1.0),
                 row_of(Integrator::kMidpoint, 1.2e-3, 8e-3, 41.4),
                 row_of(Integrator::kMidpoint, 3.6e-3, 5e-2, 20.0)};
  return result;
}

// All sentences on a topic, with spaces between them.
std::string on(const StudyResult& result, const std::string& topic) {
  for (const StudyConclusion& conclusion : study_conclusions(result)) {
    if (conclusion.topic != topic) continue;
    std::string text;
    for (const std::string& sentence : conclusion.sentences) text += sentence + ' ';
    return text;
  }
  return {};
}

const RuleAnswer& found_for(const StudyAnswer& answer, double target, const std::string& rule) {
  for (const TargetAnswer& each : answer.targets) {
    for (const RuleAnswer& found : each.rules) {
      if (each.target == target && found.rule == rule) return found;
    }
  }
  throw std::runtime_error("no answer for " + rule);
}

std::ptrdiff_t lines_of(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
}

void expect_no_part(const std::string& text, const std::string& part) {
  EXPECT_EQ(text.find(part), std::string::npos) << text << "\nhas: " << part;
}

TEST(ShortNumber, HasNoSuperfluousCharacters) {
  EXPECT_EQ(short_number(7.2e-5), "7.2e-5");
  EXPECT_EQ(short_number(1.5e-10), "1.5e-10");
  EXPECT_EQ(short_number(3e15), "3e15");
  EXPECT_EQ(short_number(0.018), "0.018");
  EXPECT_EQ(short_number(0.0), "0");
}

TEST(StudyAnswer, HasTheCheapestRunOfEachRule) {
  const StudyResult result = two_rules();
  const StudyAnswer answer = study_answer(result);
  ASSERT_EQ(answer.targets.size(), 3U);
  const RuleAnswer& verlet = found_for(answer, 0.01, "verlet");
  EXPECT_EQ(verlet.verdict, StudyVerdict::kMet);
  EXPECT_EQ(verlet.run, &result.rows[1]);
  EXPECT_EQ(verlet.relative_cost, 1.0);
  const RuleAnswer& midpoint = found_for(answer, 0.01, "midpoint");
  EXPECT_EQ(midpoint.run, &result.rows[2]);
  EXPECT_DOUBLE_EQ(midpoint.relative_cost, 41.4);
  EXPECT_DOUBLE_EQ(found_for(answer, 0.1, "midpoint").relative_cost, 20.0);
  EXPECT_EQ(found_for(answer, 0.001, "verlet").verdict, StudyVerdict::kNotMet);
  EXPECT_EQ(answer.targets[2].best(), nullptr);
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text,
              "For a position error of 10 % and 1 % the cheapest run is verlet with h = 7.2e-5 s "
              "(0.72 h_crit): its error is 4e-3, and its time steps take 1 s.");
  expect_part(text, "Midpoint with h = 3.6e-3 s (36 h_crit) takes 20 times as long.");
  expect_part(text, "No run reaches a position error of 0.1 %: the smallest is 2e-3 (verlet");
}

TEST(StudyAnswer, IsATableOfAtMostFortyLinesWithTwoSentences) {
  StudyResult result = two_rules();
  const std::string text = answer_text(result);
  EXPECT_LE(lines_of(text), 12);
  expect_part(text, "error below");
  expect_part(text, "1 %          verlet");
  expect_part(text, "the cheapest run is verlet with h = 7.2e-5 s");
  expect_part(text, "verlet with h = 1e-5 s, whose own error is estimated at 1e-5.");
  const std::vector<StudyRow> rows = result.rows;
  for (int i = 0; i < 60; ++i) {
    for (StudyRow row : rows) {
      row.compares_solver = true;
      row.solver = "solver" + std::to_string(i);
      result.rows.push_back(row);
    }
  }
  EXPECT_LE(lines_of(answer_text(result)), 40);
  expect_part(answer_text(result), "more lines, with --table markdown");
}

TEST(StudyAnswer, SaysWhereARuleIsUnstableAndWhyOneFailed) {
  StudyResult result = two_rules();
  result.rows.insert(result.rows.begin() + 2, row_of(Integrator::kVerlet, 2e-4, kNone, 0.1));
  result.rows[2].status = RunStatus::kUnstable;
  result.rows.push_back(row_of(Integrator::kBackwardEuler, 1e-3, kNone, 0.1));
  result.rows.back().status = RunStatus::kNotConverged;
  result.rows.back().steps = 7;
  result.rows.back().message = "step 7: no convergence";
  const StudyAnswer answer = study_answer(result);
  EXPECT_EQ(found_for(answer, 0.1, "verlet").note, "are unstable above 7.2e-5 s (0.72 h_crit)");
  const RuleAnswer& failed = found_for(answer, 0.1, "backward-euler");
  EXPECT_EQ(failed.verdict, StudyVerdict::kFailed);
  EXPECT_EQ(failed.note, "failed: no convergence (h = 1e-3 s, at t = 7e-3 s)");
  result.rows.push_back(row_of(Integrator::kEnergyMomentum, 1e-3, kNone, 0.1));
  result.rows.back().status = RunStatus::kNotConverged;
  result.rows.back().steps = 3;
  result.rows.back().message = "step 3: no convergence";
  const std::string text = answer_text(result);
  expect_part(text, " met\n");
  expect_part(text, " failed\n");
  expect_part(text, "Runs with verlet are unstable above 7.2e-5 s (0.72 h_crit).");
  expect_part(text,
              "Runs with backward-euler (h = 1e-3 s, at t = 7e-3 s) and energy-momentum (h = 1e-3 "
              "s, at t = "
              "3e-3 s) failed: no convergence.");
  for (StudyRow& row : result.rows) row.position_error = kNone;
  result.reference_status = RunStatus::kUnstable;
  expect_part(answer_text(result), "failed: no convergence.");  // without a table, too
}

TEST(StudyAnswer, HasFewLinesHoweverManyRulesThereAre) {
  StudyResult result = two_rules();
  result.is_interrupted = true;
  result.mesh_check.emplace().difference = 0.1;
  result.mesh_check->status = RunStatus::kFinished;
  result.rows[2].position_error = 0.5;
  for (int i = 0; i < 20; ++i) {
    StudyRow row = row_of(Integrator::kMidpoint, 1e-3, kNone, 0.1);
    row.settings = "solver.tolerance=1e-" + std::to_string(i);
    row.status = RunStatus::kNotConverged;
    row.message = i < 10 ? "step 1 (t = 0.1 s): no convergence (residual " + row.settings + " N)."
                         : "step 1: reason " + std::to_string(i);
    result.rows.push_back(row);
  }
  const std::string text = answer_text(result);
  EXPECT_LE(lines_of(text), 33);
  expect_part(
      text, "solver.tolerance=1e-4 (h = 1e-3 s, at t = 0.1 s) and 5 more failed: no convergence.");
  expect_part(text, "The page of the study has 6 more sentences on single rules.");
  expect_part(text, "All errors are differences");
}

TEST(StudyAnswer, NamesTheLargestStepThatMeetsTheTarget) {
  StudyResult result = two_rules();
  result.target = 0.01;
  result.rows[0].wall_seconds = 0.5;  // the finer run happened to be faster
  RuleFinding finding;
  finding.rule = Integrator::kVerlet;
  finding.target.emplace();
  finding.target->outcome = TargetOutcome::kMet;
  finding.target->n = 139;
  finding.target->trial.error = 4e-3;
  result.findings = {finding};
  EXPECT_EQ(found_for(study_answer(result), 0.01, "verlet").run, &result.rows[1]);
  EXPECT_EQ(found_for(study_answer(result), 0.01, "verlet").cost, 1.0);
  std::string text = answer_text(result);
  expect_part(text, "1 %          verlet      7.2e-5");
  expect_part(text, "the cheapest run is verlet with h = 7.2e-5 s (0.72 h_crit)");
  // The table says this. What it does not say is said once for all rules.
  expect_no_part(text, "Larger steps");
  result.findings[0].target->is_monotone = false;
  result.findings.push_back(result.findings[0]);
  result.findings[1].rule = Integrator::kMidpoint;
  result.findings[1].settings = {{"solver.tolerance", "1e-6"}};
  expect_part(answer_text(result),
              "Larger steps of verlet and midpoint, solver.tolerance=1e-6 may meet 1 % as well,");
  const auto again = findings_from_json(nlohmann::json(findings_json(result)), result.end);
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[1].settings, result.findings[1].settings);
  result.findings.resize(1);
  result.findings[0].stable = StableStep{125, 120, 5};
  const StudyRow row = row_of(Integrator::kVerlet, 2e-4, kNone, 0.1);
  result.rows.insert(result.rows.begin() + 2, row);
  result.rows[2].status = RunStatus::kUnstable;
  text = answer_text(result);
  expect_part(text,
              "The largest stable step of verlet is 8e-5 s (0.8 h_crit); it becomes unstable with "
              "8.33e-5 s (0.833 h_crit).");
  expect_no_part(text, "Runs with verlet");  // which would say the same
}

TEST(StudyAnswer, HasARuleForEachSettings) {
  StudyResult result = two_rules();
  StudyRow loose = row_of(Integrator::kMidpoint, 1.2e-3, 9e-3, 10.0);
  loose.settings = "solver.tolerance=1e-6";
  loose.observed_order = kNone;
  result.rows.push_back(loose);
  loose.step = 2.4e-3;
  loose.observed_order = 2.0;
  loose.position_error = 0.04;
  result.rows.push_back(loose);
  const std::string rule = "midpoint, solver.tolerance=1e-6";
  const StudyAnswer answer = study_answer(result);
  EXPECT_EQ(found_for(answer, 0.01, rule).run, &result.rows[4]);
  EXPECT_EQ(found_for(answer, 0.01, "midpoint").run, &result.rows[2]);
  expect_part(answer_text(result), rule);
  expect_part(on(result, "Observed orders"),
              "Midpoint, solver.tolerance=1e-6 has the observed order 2.00");
  expect_part(study_table(result), "solver.tolerance=1e-6");
  expect_no_part(study_table(two_rules()), "settings");
}

TEST(StudyAnswer, ComparesCostsWithinTheirScatter) {
  StudyResult result = two_rules();
  result.rows[3].wall_seconds = 1.1;
  result.rows[1].time_scatter = 0.05;
  result.rows[3].time_scatter = 0.04;
  std::string text = answer_text(result);
  expect_part(text, "its time steps take 1 s, with a scatter of 5 %.");
  expect_part(text, "Midpoint with h = 3.6e-3 s (36 h_crit) takes 1.1 times as long.");
  result.rows[3].time_scatter = 0.2;
  text = answer_text(result);
  expect_part(text,
              "Midpoint with h = 3.6e-3 s (36 h_crit) costs the same within the scatter of 22 %.");
}

TEST(StudyAnswer, ComparesTheErrorsWithThatOfTheMesh) {
  StudyResult result = two_rules();
  result.mesh_check.emplace();
  result.mesh_check->tetrahedra = 384;
  result.mesh_check->directory = "finer";
  result.mesh_check->status = RunStatus::kFinished;
  const auto json = [&] {
    return nlohmann::json::parse(study_json(result, "scene", {})).at("mesh_check");
  };
  expect_no_part(answer_text(result), "finer mesh");
  EXPECT_TRUE(json().at("difference").is_null());
  result.mesh_check->difference = 0.031;
  const std::string sentence =
      "On a mesh with half the edge length (384 tetrahedra) the same run gives a result that "
      "differs by 3.1 %, so that the error of this mesh is about 4.13 % where the motion is "
      "smooth: "
      "time steps with a much smaller error gain nothing on it.";
  expect_part(answer_text(result), sentence);
  expect_part(on(result, "Limits of the comparison"), sentence);
  expect_part(study_page(result, StudyPageContents{}), sentence);
  EXPECT_EQ(json().at("difference"), 0.031);
  EXPECT_DOUBLE_EQ(json().at("estimated_error").get<double>(), 0.031 * 4.0 / 3.0);
  EXPECT_EQ(json().at("directory"), "finer");
  result.mesh_check->status = RunStatus::kUnstable;
  expect_part(answer_text(result),
              "The run on the finer mesh with 384 tetrahedra did not reach the end (unstable)");
}

TEST(StudyAnswer, UsesProcessorTimeWhereTheMachineWasBusy) {
  StudyResult result = two_rules();
  for (StudyRow& row : result.rows) row.processor_seconds = 10.0 * row.wall_seconds;
  EXPECT_FALSE(study_answer(result).uses_processor_time);
  result.rows[3].shares_machine = true;
  result.rows[3].processor_seconds = 5.0;
  const StudyAnswer answer = study_answer(result);
  EXPECT_TRUE(answer.uses_processor_time);
  EXPECT_EQ(found_for(answer, 0.1, "midpoint").relative_cost, 1.0);
  EXPECT_EQ(found_for(answer, 0.1, "verlet").relative_cost, 2.0);
  expect_part(answer_text(result), "Costs are processor times, because runs shared the cores");

  StudyResult busy = two_rules();
  for (StudyRow& row : busy.rows) {
    row.threads = 1;
    row.processor_seconds = row.wall_seconds;
  }
  EXPECT_FALSE(study_answer(busy).uses_processor_time);
  busy.rows[3].wall_seconds = 1.0;
  busy.rows[3].processor_seconds = 0.5;
  EXPECT_TRUE(study_answer(busy).uses_processor_time);
}

TEST(StudyAnswer, SaysWhenTheReferenceIsTheError) {
  StudyResult result = two_rules();
  EXPECT_EQ(study_answer(result).rule_beside_reference, "");
  result.rows[2].position_error = 0.0099;
  result.rows[3].position_error = 0.0101;
  EXPECT_EQ(study_answer(result).rule_beside_reference, "midpoint");
  expect_part(answer_text(result),
              "The two finest runs of midpoint agree better with each other than with the "
              "reference, verlet with h = 1e-5 s: the errors are mostly those of "
              "the reference.");
}

// The largest samples of two steps may agree by chance.
TEST(StudyAnswer, DoesNotJudgeTheReferenceByPeaks) {
  StudyResult result = two_rules();
  result.error_probe = "tip";
  result.rows[2].probe_error = 0.0099;
  result.rows[3].probe_error = 0.0101;
  for (const auto& [kind, rule] :
       {std::pair{ErrorKind::kProbe, "midpoint"}, std::pair{ErrorKind::kFrequency, "midpoint"},
        std::pair{ErrorKind::kPeak, ""}}) {
    result.error_kind = kind;
    EXPECT_EQ(study_answer(result).rule_beside_reference, rule);
  }
}

TEST(StudyAnswer, CountsTrialsLikeOtherRuns) {
  StudyResult result = two_rules();
  StudyRow trial = row_of(Integrator::kMidpoint, 1.8e-3, 9e-3, 0.5);
  trial.role = StudyRole::kTrial;
  trial.directory = "trial";
  result.rows.insert(result.rows.begin() + 3, trial);
  const StudyAnswer answer = study_answer(result);
  const RuleAnswer& midpoint = found_for(answer, 0.01, "midpoint");
  EXPECT_EQ(midpoint.run, &result.rows[3]);
  EXPECT_EQ(midpoint.relative_cost, 1.0);
  EXPECT_EQ(answer.compared, 5U);
  EXPECT_EQ(answer.asked, 4U);
  // One that failed does not.
  result.rows[3].status = RunStatus::kUnstable;
  const StudyAnswer without = study_answer(result);
  EXPECT_EQ(found_for(without, 0.01, "midpoint").run, &result.rows[2]);
}

TEST(StudyAnswer, ShowsPeaksAndFrequencies) {
  StudyResult result = two_rules();
  result.error_probe = "tip";
  result.probes = {{"tip", ProbeQuantity::kDisplacement, 0, {"tip_x", "tip_y", "tip_z"}}};
  for (StudyRow& row : result.rows) {
    row.probe_error = row.position_error;
    row.probe_value = 0.25 + row.position_error;
  }
  StudyRow reference = row_of(Integrator::kVerlet, 1e-5, 0.0, 8.0);
  reference.role = StudyRole::kReference;
  reference.is_reference = true;
  reference.directory = result.reference_directory = "reference";
  reference.probe_error = 0.0;
  reference.probe_value = 0.25;
  result.rows.insert(result.rows.begin(), reference);
  result.error_kind = ErrorKind::kPeak;
  expect_part(answer_text(result), "peak [m]");
  expect_part(answer_text(result), "0.258");
  expect_part(answer_text(result),
              "verlet with h = 1e-5 s, whose peak is 0.25 m. Its own error is");
  expect_part(study_table(result), "peak [m]");
  expect_part(study_page(result, StudyPageContents{}), "peak [m]");
  expect_part(study_csv(result, {}), ",probe_value");
  const auto json = nlohmann::json::parse(study_json(result, "scene", {}));
  EXPECT_EQ(json.at("runs").at(0).at("probe_value"), 0.25);
  result.error_kind = ErrorKind::kFrequency;
  expect_part(study_table(result), "frequency [Hz]");
  result.error_kind = ErrorKind::kProbe;
  for (StudyRow& row : result.rows) row.probe_value = kNone;
  expect_no_part(study_table(result), " value");
  expect_no_part(answer_text(result), "peak [m]");
}

// A frequency that is proportional to the square root of the stiffness, and to the inverse one of the density.
TEST(StudyAnswer, SensitivitiesOfFrequenciesHaveSigns) {
  StudyResult result = two_rules();
  const std::vector<StudyRow> rows = result.rows;
  result.rows.clear();
  result.error_probe = "tip";
  result.error_kind = ErrorKind::kFrequency;
  const std::vector<std::vector<VariedValue>> values{{{"density", "1000"}, {"stiffness", "10"}},
                                                     {{"density", "1200"}, {"stiffness", "10"}},
                                                     {{"density", "1000"}, {"stiffness", "8"}}};
  const std::vector<double> frequencies{2.0, 2.0 / std::sqrt(1.2), 2.0 * std::sqrt(0.8)};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string name = "v" + std::to_string(i);
    for (StudyRow row : rows) {
      row.variant = name;
      row.directory = name + to_string(row.integrator) + std::to_string(row.step);
      row.probe_error = row.position_error;
      row.probe_value = frequencies[i];
      result.rows.push_back(row);
    }
    result.variants.push_back({name, values[i]});
    VariantReference reference;
    reference.variant = name;
    reference.variants = {name};
    reference.status = RunStatus::kFinished;
    reference.directory = result.rows.back().directory;
    if (i > 0) reference.difference.probe = std::abs(frequencies[i] / frequencies[0] - 1.0);
    result.references.push_back(reference);
  }
  const StudyAnswer answer = study_answer(result);
  ASSERT_EQ(answer.sensitivities.size(), 2U);
  EXPECT_NEAR(answer.sensitivities[0].value, -0.5, 1e-12);
  EXPECT_NEAR(answer.sensitivities[1].value, 0.5, 1e-12);
  EXPECT_TRUE(answer_json(answer).at("sensitivities").at(0).at("has_sign"));
  expect_part(
      on(result, "Variants"),
      "An increase of density by 1 % changes the frequency of the probe tip by about −0.5 % (v1).");
  expect_part(on(result, "Variants"),
              "An increase of stiffness by 1 % changes the frequency of the probe tip by about "
              "+0.5 % (v2).");
}

TEST(StudyAnswer, OffersOtherErrorsWherePhasesAreCompared) {
  StudyResult result = two_rules();
  EXPECT_FALSE(study_answer(result).compares_phase);
  expect_no_part(answer_text(result), "peak.probe.NAME");
  result.rows[2].position_error = 0.5;  // more than with the longer step
  EXPECT_FALSE(study_answer(result).is_monotone);
  expect_part(answer_text(result), "--error frequency.probe.NAME or peak.probe.NAME");
  result = two_rules();
  for (std::size_t i : {0U, 1U, 2U, 3U}) result.rows[i].position_error = 0.4 + 0.1 * double(i);
  expect_part(answer_text(result), "4 of 4 errors exceed 30 %.");
}

TEST(StudyAnswer, IsWrittenForPapers) {
  StudyResult result = two_rules();
  const std::string latex = answer_text(result, {AnswerFormat::kLatex});
  expect_part(latex, "\\begin{tabular}{llrrrrrl}\n");
  expect_part(latex, "10 \\% & verlet &");
  expect_part(latex, "0.1 \\% & midpoint &");
  expect_part(latex, "$7.2\\cdot 10^{-5}$");
  expect_part(latex, "h/h\\_crit");
  result.rows[0].compares_solver = result.rows[1].compares_solver = true;
  result.rows[0].solver = result.rows[1].solver = "a&b%c_d#e|f$g{h}~^\\";
  const std::string hostile = answer_text(result, {AnswerFormat::kLatex});
  expect_part(
      hostile,
      "a\\&b\\%c\\_d\\#e|f\\$g\\{h\\}\\textasciitilde{}\\textasciicircum{}\\textbackslash{}");
  const std::string markdown = answer_text(result, {AnswerFormat::kMarkdown});
  expect_part(markdown, "| error below | rule |");
  expect_part(markdown, "| --- | --- | ---: |");
  expect_part(markdown, "a\\&b%c\\_d\\#e\\|f");
  EXPECT_EQ(answer_format_from_string("latex"), AnswerFormat::kLatex);
  EXPECT_THROW((void)answer_format_from_string("html"), InputError);
}

TEST(StudyConclusions, NameAnAnswerToSeveralTargetsOnce) {
  StudyResult result = two_rules();
  result.rows.resize(2);
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % and 1 % the cheapest run is verlet");
}

TEST(StudyConclusions, DistinguishTargetsWithDifferentAnswers) {
  StudyResult result = two_rules();
  result.rows[3].wall_seconds = 0.5;  // the coarse step is the cheapest, but too coarse for 1 %
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % the cheapest run is midpoint with h = 3.6e-3 s");
  expect_part(text, "Verlet with h = 7.2e-5 s (0.72 h_crit) takes 2 times as long.");
  expect_part(text, "For a position error of 1 % the cheapest run is verlet");
}

TEST(StudyConclusions, NameARunThatCostsTheSame) {
  StudyResult result = two_rules();
  expect_no_part(on(result, "Cost of accuracy"), "same time");
  result.rows[3].wall_seconds = 1.1;
  expect_part(on(result, "Cost of accuracy"),
              "Midpoint with h = 3.6e-3 s (36 h_crit) takes about the same time.");
}

TEST(StudyConclusions, AddTheErrorOfTheReference) {
  StudyResult result = two_rules();
  result.reference_error = 9e-3;
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text,
              "No run is certain to reach a position error of 1 %: the reference's own error "
              "is estimated at 9e-3");
  EXPECT_EQ(found_for(study_answer(result), 0.01, "verlet").verdict, StudyVerdict::kNotResolved);
  expect_part(answer_text(result), " not resolved\n");
  expect_part(answer_text(result), "whose own error is estimated at 9e-3.");
}

TEST(StudyConclusions, SayWhatIsNotKnownOfTheReference) {
  StudyResult result = two_rules();
  result.reference_error = kNone;
  expect_part(on(result, "Limits of the comparison"), "Its own error is not known");
  result.reference_status = RunStatus::kUnstable;
  for (StudyRow& row : result.rows) row.position_error = kNone;
  expect_part(on(result, "Limits of the comparison"), "there are no errors");
  EXPECT_EQ(on(result, "Cost of accuracy"), "");
  EXPECT_EQ(on(result, "Observed orders"), "");
}

TEST(StudyConclusions, DoNotCountTheReferenceOrVariants) {
  StudyResult result = two_rules();
  result.rows[0].role = StudyRole::kReference;
  result.rows[0].position_error = 0.0;
  result.rows[1].role = StudyRole::kVariant;
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % the cheapest run is midpoint");
  expect_no_part(text, "verlet");
}

TEST(StudyConclusions, DoNotCompareTimesOfDifferentMachines) {
  StudyResult result = two_rules();
  result.rows[1].processor = "second processor";
  EXPECT_EQ(on(result, "Cost of accuracy"), "");
  expect_part(on(result, "Limits of the comparison"), "wall times cannot be compared");
}

TEST(StudyConclusions, DoNotCountTimesOfRunsThatSharedTheMachine) {
  StudyResult result = two_rules();
  result.rows[1].shares_machine = true;  // the cheapest one
  std::string text = on(result, "Cost of accuracy");
  expect_part(text, "of 10 % and 1 % the cheapest run is verlet with h = 5e-5 s");
  expect_part(text, "The wall times of 1 of 4 runs do not count,");
  expect_part(text, "--jobs 1");
  // No run below the limit has a time, but it is not said that none reaches the error.
  result.rows[0].shares_machine = true;
  text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % the cheapest run is midpoint with h = 3.6e-3 s");
  expect_part(text, "For a position error of 1 % the cheapest run is midpoint with h = 1.2e-3 s");
  expect_no_part(text, "below the stability limit");
  expect_part(text, "No run reaches a position error of 0.1 %");
  // An error that is reached by runs without a time only is left out.
  result.rows[2].shares_machine = true;
  text = on(result, "Cost of accuracy");
  expect_part(text, "of 10 % the cheapest run is midpoint with h = 3.6e-3 s");
  expect_no_part(text, " 1 % the cheapest");
  expect_no_part(text, "No run is certain");
  result.rows[3].shares_machine = true;
  text = on(result, "Cost of accuracy");
  expect_part(text, "timings are missing: all runs shared the cores");
  expect_no_part(text, "cheapest");
}

TEST(StudyAnswer, ComparesSolversWithoutTimesThatWereShared) {
  StudyResult result = two_rules();
  result.rows.push_back(row_of(Integrator::kMidpoint, 3.6e-3, 5e-2, 900.0));
  result.rows.back().solver = "ceres";
  result.rows.back().compares_solver = true;
  const auto ratio = [&] {
    const StudyAnswer answer = study_answer(result);
    return found_for(answer, 0.1, "midpoint (ceres)").cost /
           found_for(answer, 0.1, "midpoint").cost;
  };
  EXPECT_DOUBLE_EQ(ratio(), 45.0);
  result.rows.back().shares_machine = true;
  EXPECT_TRUE(std::isnan(ratio()));
  EXPECT_EQ(found_for(study_answer(result), 0.1, "midpoint (ceres)").error, 0.05);
}

// Two meshes with two variants each; the second reference has another error.
StudyResult two_meshes() {
  StudyResult result = two_rules();
  const std::vector<StudyRow> rows = result.rows;
  result.rows.clear();
  for (const char* name : {"coarse, soft", "coarse, hard", "fine, soft", "fine, hard"}) {
    const std::string variant = name;
    for (StudyRow row : rows) {
      row.variant = variant;
      row.directory = variant + std::to_string(result.rows.size());
      if (variant.ends_with("hard")) row.role = StudyRole::kVariant;
      if (variant.starts_with("fine")) {
        row.stable_step = 5e-5;
        row.position_error *= 20.0;
        row.wall_seconds *= 8.0;
      }
      result.rows.push_back(row);
    }
    result.variants.push_back({variant, {}});
  }
  for (const std::string mesh : {"coarse", "fine"}) {
    VariantReference reference;
    reference.variant = mesh + ", soft";
    reference.variants = {mesh + ", soft", mesh + ", hard"};
    reference.status = RunStatus::kFinished;
    reference.directory = mesh;
    reference.error = mesh == "fine" ? 3e-3 : 1e-5;
    result.references.push_back(reference);
  }
  return result;
}

TEST(StudyConclusions, AreDrawnForEachMesh) {
  StudyResult result = two_meshes();
  const std::string meshes = on(result, "Variants");
  expect_part(meshes, "The study has 2 references");
  expect_part(meshes, "--error probe.NAME");
  const StudyAnswer answer = study_answer(result);
  ASSERT_EQ(answer.variants.size(), 4U);
  EXPECT_EQ(answer.variants[2].stable_step, 5e-5);
  EXPECT_EQ(answer.variants[2].least_cost_ratio, 8.0);
  EXPECT_EQ(answer.variants[2].reference_error, 3e-3);
  EXPECT_EQ(answer.variants[2].answer.best(), nullptr);
  ASSERT_NE(answer.variants[0].answer.best(), nullptr);
  EXPECT_EQ(answer.variants[0].answer.best()->run, &result.rows[1]);
  // Those that share the reference of another one have no answer of their own.
  EXPECT_TRUE(answer.variants[3].answer.rules.empty());
  const std::string said = answer_text(result);
  EXPECT_LE(lines_of(said), 14);
  expect_part(said, "fine, soft");
  expect_part(said, "not met: 1 %");
  result.error_probe = "tip";
  result.references[1].difference.probe = 0.02;
  expect_part(on(result, "Variants"),
              "The probe tip differs from that of coarse, soft by up to 2 % (fine, soft).");
  expect_no_part(on(result, "Variants"), "The motion");
  result.error_probe.clear();
  result.references[1].difference.position = 0.25;
  const std::string same_mesh = on(result, "Variants");
  expect_part(same_mesh,
              "The motion differs from that of coarse, soft by up to 25 % (fine, soft).");
  expect_no_part(same_mesh, "--error probe.NAME");
}

TEST(StudyAnswer, OfASweepHasALineForEachVariantAndSensitivities) {
  StudyResult result = two_rules();
  const std::vector<StudyRow> rows = result.rows;
  result.rows.clear();
  for (int i = 0; i < 60; ++i) {
    const std::string name = "v" + std::to_string(i);
    for (StudyRow row : rows) {
      row.variant = name;
      row.directory = name + to_string(row.integrator) + std::to_string(row.step);
      result.rows.push_back(row);
    }
    result.variants.push_back({name,
                               {{"material.density", i == 2 ? "1100" : "1000"},
                                {"load", i == 3  ? "2"
                                         : i > 3 ? std::to_string(i)
                                                 : "1"}}});
    VariantReference reference;
    reference.variant = name;
    reference.variants = {name};
    reference.status = RunStatus::kFinished;
    reference.error = 1e-5;
    if (i > 0) reference.difference.position = 0.01 * i;
    result.references.push_back(reference);
  }
  const StudyAnswer answer = study_answer(result);
  ASSERT_EQ(answer.sensitivities.size(), 2U);
  EXPECT_EQ(answer.sensitivities[0].key, "material.density");
  EXPECT_NEAR(answer.sensitivities[0].value, 0.02 / std::log(1.1), 1e-12);
  EXPECT_EQ(answer.sensitivities[1].key, "load");
  EXPECT_EQ(answer.sensitivities[1].variant, "v3");  // the nearest value
  EXPECT_NEAR(answer.sensitivities[1].value, 0.03 / std::log(2.0), 1e-12);
  const std::string text = answer_text(result);
  EXPECT_LE(lines_of(text), 40);
  expect_part(text, "The stability limit is 1e-4 s for all variants.");
  std::size_t sentences = 0;
  for (const StudyConclusion& conclusion : study_conclusions(result)) {
    sentences += conclusion.sentences.size();
  }
  EXPECT_LE(sentences, 14U);
}

TEST(StudyWriter, EachRowHasTheReferenceOfItsMesh) {
  StudyResult result = two_meshes();
  result.rows[5].shares_machine = true;
  const std::string csv = study_csv(result, {});
  std::vector<std::string> ends;
  for (std::size_t begin = csv.find('\n') + 1; begin < csv.size();) {
    const std::size_t end = csv.find('\n', begin);
    const std::string line = csv.substr(begin, end - begin);
    ends.push_back(line.substr(line.rfind(',', line.rfind(',') - 1) + 1));
    begin = end + 1;
  }
  ASSERT_EQ(ends.size(), 16U);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_EQ(ends[i], std::string(i < 8 ? "1e-05" : "0.003") + (i == 5 ? ",shared" : ",alone"));
  }
  const std::string table = study_table(result);
  expect_part(table,
              "Reference of fine, soft and fine, hard: verlet with h = 1e-5 s (ok), whose own");
  expect_part(table, "fine, soft: h_crit = 5e-05 s (verlet); with a reference of its own");
  expect_part(table, "differences from another variant, fine, soft");
}

TEST(StudyConclusions, WarnOfShortTimes) {
  StudyResult result = two_rules();
  expect_no_part(on(result, "Cost of accuracy"), "vary much");
  result.rows[1].wall_seconds = 0.01;
  expect_part(on(result, "Cost of accuracy"), "Times below 0.05 s vary much");
}

TEST(StudyConclusions, SayWhichRunsFailedAndWhy) {
  StudyResult result = two_rules();
  for (const double step : {2e-4, 8e-4}) {
    result.rows.insert(result.rows.begin() + 2, row_of(Integrator::kVerlet, step, kNone, 0.1));
    result.rows[2].status = RunStatus::kUnstable;
    result.rows[2].message = "step 3: inverted";
  }
  result.rows.back().status = RunStatus::kNotConverged;
  result.rows.back().message = "step 7: no convergence";
  const std::string text = on(result, "Runs that did not reach the end");
  expect_part(text,
              "Verlet became unstable above its stability limit, with h = 8e-4 s (8 h_crit) and "
              "2e-4 s (2 h_crit).");
  expect_part(text, "Midpoint with h = 3.6e-3 s (36 h_crit) failed: step 7: no convergence.");
  // Below the limit the message is the reason.
  result.rows[0].status = RunStatus::kUnstable;
  result.rows[0].message = "step 9: the energy blew up";
  expect_part(on(result, "Runs that did not reach the end"),
              "Verlet with h = 5e-5 s (0.5 h_crit) became unstable: step 9: the energy blew up.");
  EXPECT_EQ(on(two_rules(), "Runs that did not reach the end"), "");
}

TEST(StudyConclusions, CompareOrdersWithTheory) {
  StudyResult result = two_rules();
  result.rows[1].observed_order = 2.01;
  result.rows[3].observed_order = 1.2;
  const std::string text = on(result, "Observed orders");
  expect_part(text,
              "Verlet has the observed order 2.01 between 5e-5 s and 7.2e-5 s; the theoretical "
              "order is 2.");
  expect_part(text,
              "Midpoint has the observed order 1.20 between 1.2e-3 s and 3.6e-3 s; the "
              "theoretical order is 2, which these errors do not show.");
  result.rows[3].observed_order = kNone;
  result.reference_error = 1e-2;
  expect_no_part(on(result, "Observed orders"), "Midpoint");  // an order that cannot be seen
}

TEST(StudyConclusions, DoubtAnEstimateWithoutItsOrder) {
  StudyResult result = two_rules();
  result.rows[1].observed_order = 2.01;
  expect_no_part(on(result, "Limits of the comparison"), "uncertain");
  expect_no_part(on(result, "Limits of the comparison"), "No order was observed");
  result.rows[1].observed_order = 1.0;
  expect_part(on(result, "Limits of the comparison"),
              "show the order 1.00 instead, so that the estimate is uncertain");
}

// Two runs, of which one is the reference, show no order, neither a right nor a wrong one.
TEST(StudyConclusions, SayNothingOfOrdersThatWereNotObserved) {
  StudyResult result = two_rules();
  result.rows.resize(2);
  result.rows[0].role = StudyRole::kReference;
  result.rows[0].position_error = 0.0;
  const std::string text = on(result, "Limits of the comparison");
  expect_part(text,
              "from the finest other run of its integrator and the theoretical order 2. No order "
              "was observed that could confirm the estimate.");
  expect_no_part(text, "do not show");
  expect_no_part(text, "instead");
}

TEST(StudyConclusions, TellRunsThatAreEqualFromWrongOrders) {
  StudyResult result = two_rules();
  result.extrapolation = ReferenceExtrapolation{};
  result.extrapolation->is_valid = false;
  result.extrapolation->is_exact = true;
  result.extrapolation->reason = "the runs differ by 1e-12 and 2e-12 only";
  const std::string text = on(result, "Limits of the comparison");
  expect_part(text, "not extrapolated, because the runs differ by 1e-12 and 2e-12 only.");
  expect_part(text, "from its difference from the run with twice its step.");
  expect_no_part(text, "uncertain");
}

TEST(StudyConclusions, NameTheProbeThatIsNotExtrapolated) {
  StudyResult result = two_rules();
  result.error_probe = "speed";
  for (StudyRow& row : result.rows) row.probe_error = row.position_error;
  result.extrapolation = ReferenceExtrapolation{};
  result.extrapolation->probe_is_valid = false;
  result.extrapolation->probe_reason = "the observed order of the probe is 1.00";
  EXPECT_EQ(reference_name(result), "verlet with h = 1e-5 s");
  const std::string text = on(result, "Limits of the comparison");
  expect_part(text,
              "The reference of the probe speed is not extrapolated, because the observed order of "
              "the probe is 1.00.");
  expect_no_part(text, "The reference is not extrapolated");
  result.error_probe.clear();
  EXPECT_EQ(reference_name(result).substr(0, 24), "Richardson extrapolation");
}

TEST(StudyConclusions, SayWhetherTheReferenceIsExtrapolated) {
  StudyResult result = two_rules();
  ReferenceExtrapolation found;
  found.step = 2e-5;
  found.order_at_end = 1.98;
  found.order_over_time = 2.03;
  found.finest_error_at_end = 4e-4;
  result.extrapolation = found;
  EXPECT_EQ(reference_name(result),
            "Richardson extrapolation of verlet with h = 2e-5 s and 1e-5 s");
  std::string text = on(result, "Limits of the comparison");
  expect_part(text, "whose own error is estimated at 1e-5.");
  expect_part(text, "The estimate comes from the extrapolation with twice the steps");
  expect_part(text, "The three runs show the order 1.98, and the theoretical order is 2.");
  expect_no_part(text, "uncertain");
  result.extrapolation->is_valid = false;
  result.extrapolation->reason = "the observed order at the end is 1.20";
  EXPECT_EQ(reference_name(result), "verlet with h = 1e-5 s");
  text = on(result, "Limits of the comparison");
  expect_part(text, "not extrapolated, because the observed order at the end is 1.20.");
  expect_part(text, "the estimate is uncertain");
}

TEST(StudyConclusions, CompareSolversAndVariants) {
  StudyResult result = two_rules();
  StudyRow other = row_of(Integrator::kMidpoint, 1.2e-3, 8e-3, 124.0);
  other.solver = "ceres";
  other.compares_solver = true;
  result.rows.push_back(other);
  const StudyAnswer answer = study_answer(result);
  EXPECT_NEAR(
      found_for(answer, 0.01, "midpoint (ceres)").cost / found_for(answer, 0.01, "midpoint").cost,
      124.0 / 41.4, 1e-12);
  for (StudyRow& row : result.rows) row.variant = "exact";
  StudyRow variant = row_of(Integrator::kVerlet, 7.2e-5, 0.1, 1.5);
  variant.variant = "penalty";
  variant.role = StudyRole::kVariant;
  variant.stable_step = 2.5e-5;
  result.rows.push_back(variant);
  result.variants = {{"exact", {}}, {"penalty", {}}};
  const std::string text = on(result, "Variants");
  expect_part(text, "The stability limit lies between 2.5e-5 s (penalty) and 1e-4 s (exact).");
  expect_part(text, "With equal rules and steps penalty takes 1.5 times the wall time of exact.");
}

TEST(StudyConclusions, UseTheErrorOfTheProbe) {
  StudyResult result = two_rules();
  result.error_probe = "tip";
  for (StudyRow& row : result.rows) row.probe_error = 0.5 * row.position_error;
  expect_part(on(result, "Cost of accuracy"), "For an error of the probe tip of 10 %");
}

TEST(StudyConclusions, OfNothingAreEmpty) {
  EXPECT_TRUE(study_conclusions(StudyResult{}).empty());
}

TEST(StudyPage, EscapesWhatOthersNamed) {
  StudyResult result = two_rules();
  result.rows[0].message = "<b>&\"\xFF";
  StudyPageContents contents;
  contents.scene_name = "<script>alert(1)</script>";
  contents.provenance.command = "tetraction study '<i>.toml'";
  contents.why_no_pictures = "No plots.";
  const std::string page = study_page(result, contents);
  expect_no_part(page, "<script>alert");
  expect_no_part(page, "<i>");
  expect_no_part(page, "\xFF");
  expect_part(page, "&lt;b&gt;&amp;&quot;\xEF\xBF\xBD");
  expect_part(page, "No plots.");
}

TEST(StudyPage, HasDrawingsThatCanDoNothing) {
  StudyPageContents contents;
  const std::string good =
      "<?xml version=\"1.0\"?><!DOCTYPE svg><svg width=\"500pt\"><!-- name "
      "--><metadata>m</metadata>"
      "<style>*{}</style><defs><path id=\"a\"/></defs><use xlink:href=\"#a\"/></svg>\n";
  contents.pictures = {{"Heading", "Caption", good}};
  const std::string page = study_page(two_rules(), contents);
  expect_part(page,
              "<figure class=\"wide\"><h3>Heading</h3>\n<svg width=\"500pt\"><defs><path "
              "id=\"a\"/></defs><use xlink:href=\"#a\"/></svg>\n");
  for (const std::string bad :
       {"<script>alert(1)</script>", "<g onload=\"alert(1)\"/>", "<g OnClick = 'alert(1)'/>",
        "<image href=\"http://a/b.png\"/>", "<use href='#a'/>", "<foreignObject/>",
        "<a href=\"#a\">x</a>", "<![CDATA[x]]>", "<!-- -- ><g/>"}) {
    contents.pictures[0].svg = "<svg>" + bad + "</svg>";
    const std::string safe = study_page(two_rules(), contents);
    expect_part(safe, "<img alt=\"Heading\" src=\"data:image/svg+xml;base64,");
    expect_no_part(safe, bad);
  }
}

TEST(StudyPage, FillsItsTemplateOnce) {
  StudyPageContents contents;
  contents.scene_name = "{{script}}{{none}}";
  const std::string page = study_page(two_rules(), contents);
  expect_part(page, "<title>Step-size study: {{script}}{{none}}</title>");
  expect_part(page, "script-src 'sha256-");
}

TEST(StudyPage, HasThePlotOfTheErrorsBesideTheAnswer) {
  StudyPageContents contents;
  contents.answer_picture = StudyPicture{"Errors", "Caption", "<svg></svg>"};
  contents.pictures = {{"Other", "Caption", "<svg></svg>"}};
  const std::string page = study_page(two_rules(), contents);
  const auto errors = page.find("<h3>Errors</h3>");
  EXPECT_LT(errors, page.find("</section>"));
  EXPECT_EQ(page.find("<h3>Errors</h3>", errors + 1), std::string::npos);
  EXPECT_GT(page.find("<h3>Other</h3>"), page.find("<h2>Plots</h2>"));
  contents.answer_picture.reset();
  contents.why_no_pictures = "No plots.";
  const std::string without = study_page(two_rules(), contents);
  EXPECT_LT(without.find("No plots."), without.find("</section>"));
}

TEST(StudyFields, MakeTheSameRowAgain) {
  StudyRow row = two_rules().rows[2];
  row.message = "a message";
  row.variant = "soft";
  row.role = StudyRole::kVariant;
  row.processor_seconds = 3.5;
  row.shares_machine = true;
  row.stable_step = std::numeric_limits<double>::infinity();
  const nlohmann::json json = study_row_json(row);
  const std::optional<StudyRow> again = study_row_from_json(json);
  ASSERT_TRUE(again);
  EXPECT_EQ(study_row_json(*again), study_row_json(row));
  EXPECT_EQ(again->stable_step, row.stable_step);
  for (const auto& [key, value] : json.items()) {
    if (key == "observed_order" || key == "step_over_stable_step") continue;
    nlohmann::json damaged = json;
    damaged[key] = {1, 2};
    EXPECT_FALSE(study_row_from_json(damaged)) << key;
    damaged.erase(key);
    EXPECT_FALSE(study_row_from_json(damaged)) << key;
  }
}

TEST(StudyPage, HasThePicturesInside) {
  StudyPageContents contents;
  contents.pictures = {{"Heading", "Caption", "ab"}, {"Heading", "Caption", "abc"}};
  const std::string page = study_page(two_rules(), contents);
  expect_part(page, "src=\"data:image/svg+xml;base64,YWI=\"");
  expect_part(page, "src=\"data:image/svg+xml;base64,YWJj\"");
}

TEST(StudyCsv, HasTheProvenanceInEachRow) {
  StudyResult result = two_rules();
  result.rows.resize(1);
  result.rows[0].date = "2025-01-31T12:00:00Z";
  const std::string text =
      study_csv(result, {"tetraction study a --steps 1,2 --set 'b=\"c\"'", ""});
  expect_part(text,
              ",date,processor,cores,threads,settings,repeats,time_scatter,version,command,"
              "reference,reference_error,timing\n");
  expect_part(text, ",2025-01-31T12:00:00Z,first processor,2,2,");
  expect_part(text,
              ",\"tetraction study a --steps 1,2 --set 'b=\"\"c\"\"'\",verlet with h = 1e-5 "
              "s,1e-05,alone\n");
}

}  // namespace
}  // namespace tetraction
