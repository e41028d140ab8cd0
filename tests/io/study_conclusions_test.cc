// What a study concludes from its numbers, in words, and how its page shows them.
#include "io/study/study_conclusions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/study/study_page.h"
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

TEST(StudyConclusions, NameTheCheapestRunOnBothSidesOfTheLimit) {
  const std::string text = on(two_rules(), "Cost of accuracy");
  expect_part(text,
              "For a position error of 1 % the cheapest run is verlet with h = 7.2e-5 s (0.72 "
              "h_crit): its error is 4e-3, and its time steps take 1 s.");
  expect_part(text,
              "Among the steps above the stability limit it is midpoint with h = 1.2e-3 s (12 "
              "h_crit), which takes 41 times the wall time.");
  expect_part(text, "No run reaches a position error of 0.1 %: the smallest is 2e-3 (verlet");
}

TEST(StudyConclusions, NameAnAnswerToSeveralTargetsOnce) {
  StudyResult result = two_rules();
  result.rows.resize(2);
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % and 1 % the cheapest run is verlet");
  expect_no_part(text, "above the stability limit");
}

TEST(StudyConclusions, DistinguishTargetsWithDifferentAnswers) {
  StudyResult result = two_rules();
  result.rows[3].wall_seconds = 0.5;  // the coarse step is the cheapest, but too coarse for 1 %
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text, "For a position error of 10 % the cheapest run is midpoint with h = 3.6e-3 s");
  expect_part(text, "Among the steps below the stability limit it is verlet");
  expect_part(text, "For a position error of 1 % the cheapest run is verlet");
}

TEST(StudyConclusions, NameARunThatCostsTheSame) {
  StudyResult result = two_rules();
  expect_no_part(on(result, "Cost of accuracy"), "same wall time");
  result.rows[3].wall_seconds = 1.1;
  expect_part(on(result, "Cost of accuracy"),
              "Midpoint with h = 3.6e-3 s (36 h_crit) takes about the same wall time.");
}

TEST(StudyConclusions, AddTheErrorOfTheReference) {
  StudyResult result = two_rules();
  result.reference_error = 9e-3;
  const std::string text = on(result, "Cost of accuracy");
  expect_part(text,
              "No run is certain to reach a position error of 1 %: the reference's own error "
              "is estimated at 9e-3");
  expect_part(on(result, "Limits of the comparison"), "less than five times as large");
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
  expect_part(text, "of 10 % the cheapest run is verlet with h = 5e-5 s");
  expect_part(text, "of 1 % the cheapest run is verlet with h = 5e-5 s");
  expect_part(text, "The wall times of 1 of 4 runs do not count here");
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

TEST(StudyConclusions, CompareSolversWithoutTimesThatWereShared) {
  StudyResult result = two_rules();
  result.rows.push_back(row_of(Integrator::kMidpoint, 3.6e-3, 5e-2, 900.0));
  result.rows.back().solver = "ceres";
  result.rows.back().compares_solver = true;
  expect_part(on(result, "Solvers"), "ceres takes 45 times the wall time of newton");
  result.rows.back().shares_machine = true;
  const std::string text = on(result, "Solvers");
  expect_part(text, "the errors with ceres and newton are 0.05 and 0.05; their wall times do not");
  expect_no_part(text, "45 times");
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
  expect_part(meshes, "The study has 2 references.");
  expect_part(meshes, "The variants fine, soft and fine, hard share the reference of the first");
  expect_part(meshes, "The stability limit of fine, soft is 0.5 times that of coarse, soft.");
  expect_part(meshes, "fine, soft takes 8 times the wall time of coarse, soft.");
  expect_part(meshes, "--error probe.NAME");
  expect_part(on(result, "Cost of accuracy: coarse, soft"),
              "For a position error of 1 % the cheapest run is verlet (coarse, soft) with");
  expect_part(on(result, "Cost of accuracy: fine, soft"),
              "No run reaches a position error of 1 %: the smallest is 0.04 (verlet (fine, soft)");
  expect_part(on(result, "Limits of the comparison: fine, soft"), "is estimated at 3e-3");
  expect_part(on(result, "Variants: fine, soft"), "those of the variant fine, soft");
  result.error_probe = "tip";
  result.references[1].difference.probe = 0.02;
  expect_part(on(result, "Variants"),
              "The probe tip of the reference of fine, soft differs by up to 0.02 from that of "
              "coarse, soft");
  expect_no_part(on(result, "Variants"), "The positions of the reference");
  result.error_probe.clear();
  result.references[1].difference.position = 0.25;
  result.references[1].difference.position_rms = 0.5;
  const std::string same_mesh = on(result, "Variants");
  expect_part(same_mesh,
              "The positions of the reference of fine, soft differ from those of coarse, soft by "
              "0.25 at the end and by 0.5 over the whole time");
  expect_part(same_mesh, "the errors of the two references in time are estimated at 3e-3 and 1e-5");
  expect_no_part(same_mesh, "--error probe.NAME");
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
  expect_part(on(result, "Cost of accuracy"), "Wall times below 0.05 s vary much");
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
              "Verlet became unstable with h = 8e-4 s (8 h_crit) and 2e-4 s (2 h_crit): these "
              "steps are above its stability limit.");
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
              "Verlet has the observed order 2.01 between 5e-5 s and 7.2e-5 s; it agrees with "
              "the theoretical order 2.");
  expect_part(text,
              "Midpoint has the observed order 1.20 between 1.2e-3 s and 3.6e-3 s; the "
              "theoretical order is 2, which the errors do not show there.");
  result.rows[3].observed_order = kNone;
  result.reference_error = 1e-2;
  expect_part(on(result, "Observed orders"),
              "Midpoint has no observed order: the reference's own error is not small beside");
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
  expect_part(text,
              "Its own error is estimated at 1e-5, from the extrapolation with twice the steps");
  expect_part(text, "That of its finest run is 4e-4 at the end");
  expect_part(text, "the order 1.98 at the end and 2.03 over time; the theoretical order is 2.");
  expect_no_part(text, "uncertain");
  result.extrapolation->is_valid = false;
  result.extrapolation->reason = "the observed order at the end is 1.20";
  EXPECT_EQ(reference_name(result), "verlet with h = 1e-5 s");
  text = on(result, "Limits of the comparison");
  expect_part(text, "not extrapolated, because the observed order at the end is 1.20.");
  expect_part(text, "the estimate is uncertain");
}

TEST(StudyConclusions, NameEnergyErrorsOfRoundOff) {
  StudyResult result = two_rules();
  result.rows[2].max_relative_energy_drift = 1e-14;
  const std::string text = on(result, "Conservation");
  expect_part(text, "verlet 1e-3 and midpoint 1e-14 to 1e-3");
  expect_part(text,
              "The energy error of midpoint with h = 1.2e-3 s (12 h_crit) is at the level of "
              "round-off.");
}

TEST(StudyConclusions, CompareSolversAndVariants) {
  StudyResult result = two_rules();
  StudyRow other = row_of(Integrator::kMidpoint, 1.2e-3, 8e-3, 124.0);
  other.solver = "ceres";
  other.compares_solver = true;
  result.rows.push_back(other);
  expect_part(on(result, "Solvers"),
              "For midpoint with h = 1.2e-3 s, ceres takes 3 times the wall time of newton; their "
              "errors are 0.008 and 0.008.");
  for (StudyRow& row : result.rows) row.variant = "exact";
  StudyRow variant = row_of(Integrator::kVerlet, 7.2e-5, 0.1, 1.5);
  variant.variant = "penalty";
  variant.role = StudyRole::kVariant;
  variant.stable_step = 2.5e-5;
  result.rows.push_back(variant);
  const std::string text = on(result, "Variants");
  expect_part(text, "The stability limit of penalty is 0.25 times that of exact.");
  expect_part(text,
              "With equal integrators and steps penalty takes 1.5 times the wall time of exact.");
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
              ",date,processor,cores,threads,version,command,reference,reference_error,timing\n");
  expect_part(text, ",2025-01-31T12:00:00Z,first processor,2,2,");
  expect_part(text,
              ",\"tetraction study a --steps 1,2 --set 'b=\"\"c\"\"'\",verlet with h = 1e-5 "
              "s,1e-05,alone\n");
}

}  // namespace
}  // namespace tetraction
