// From what a study is asked for to the steps of its rules.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "run_scene.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/excited_period.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

// Stops a run after a few steps.
class StopAfterSteps : public Observer {
 public:
  bool on_step(const Session& session) override {
    constexpr Index kMost = 20;
    constexpr double kSeconds = 0.2;
    return session.step_number() < kMost && session.times().stepping < kSeconds;
  }
};

// The time that a step takes, from the first ones, s. 0 if they fail.
double time_steps(Scene scene, const TetMesh& mesh) {
  Session session(std::move(scene), mesh);
  StopAfterSteps stop;
  session.run({&stop});
  const auto steps = static_cast<double>(session.step_number());
  return steps > 0.0 ? session.times().stepping / steps : 0.0;
}

class Questioner {
 public:
  Questioner(const StudyPlan& frame, const TetMesh& mesh, const StudyRequests& requests)
      : frame_(frame),
        scene_(frame.variants.front().scene),
        mesh_(frame.variants.front().mesh ? *frame.variants.front().mesh : mesh),
        requests_(requests) {
    question_.end = frame.end;
    question_.error = requests.error;
    question_.target = requests.target;
    scales_ = {frame.end, frame.stable_step, [this] { return required_period(); }};
  }

  StepQuestion question(const StudySettings& settings) {
    for (std::size_t i = 0; i < requests_.rules.size(); ++i) {
      question_.rules.push_back(about(requests_.rules[i], requests_.steps[i]));
    }
    if (!chooses_steps(requests_)) return std::move(question_);
    if (!std::isfinite(scales_.stable_step)) {
      throw InputError(
          "No steps can be chosen, because nothing in this scene limits the explicit rules, as "
          "where "
          "every vertex is held. Leave vertices free, or give --steps.");
    }
    question_.period = period().period;
    question_.reference_step = settings.reference_step;
    // The explicit rule of second order is the cheapest one where it is not too slow.
    std::vector<Integrator> references{Integrator::kVerlet, Integrator::kMidpoint};
    if (requests_.reference_integrator) references = {*requests_.reference_integrator};
    if (settings.reference_step && !requests_.reference_integrator)
      references.erase(references.begin());
    for (const Integrator integrator : references) {
      question_.references.push_back(about(integrator, {}));
    }
    for (RuleQuestion& rule : question_.rules) set_time(rule);
    for (RuleQuestion& rule : question_.references) set_time(rule);
    return std::move(question_);
  }

 private:
  RuleQuestion about(Integrator rule, const std::vector<StepRequest>& steps) {
    RuleQuestion question;
    question.rule = rule;
    question.stable_step = scales_.stable_step;
    const bool needs_limit = requests_.target || steps.empty() ||
                             std::any_of(steps.begin(), steps.end(), [](const StepRequest& step) {
                               return step.unit == StepUnit::kAuto;
                             });
    if (needs_limit && rule == Integrator::kVerlet) question.stable_step = verlet_limit();
    question.asked = resolve_steps(steps, rule, question.stable_step, scales_);
    return question;
  }

  // Explicit rules are timed, because their first runs may be long.
  void set_time(RuleQuestion& rule) const {
    if (is_implicit(rule.rule) || !std::isfinite(rule.stable_step)) return;
    const double step = std::min(question_.end, rule.stable_step);
    rule.seconds_per_step =
        time_steps(scene_of(frame_, planned_run(frame_, 0, rule.rule, step)), mesh_);
  }

  double verlet_limit() {
    if (!verlet_limit_) {
      const auto system = make_system(scene_, mesh_);
      const State start = make_initial_state(scene_, *system);
      verlet_limit_ = stability_limit(*system, start.position, Integrator::kVerlet).critical_step;
    }
    return *verlet_limit_;
  }

  const ExcitedPeriod& period() {
    if (!period_) {
      const auto system = make_system(scene_, mesh_);
      period_ = excited_period(scene_, *system);
    }
    return *period_;
  }

  double required_period() {
    if (period().period > 0.0) return period().period;
    throw InputError(fmt::format(
        "--steps: there is no excited period to measure steps by: {}. Give the steps in s or in "
        "h_crit (4x).",
        period().source));
  }

  const StudyPlan& frame_;
  const Scene& scene_;
  const TetMesh& mesh_;
  const StudyRequests& requests_;
  StepScales scales_;
  StepQuestion question_;
  std::optional<double> verlet_limit_;
  std::optional<ExcitedPeriod> period_;
};

}  // namespace

double estimated_seconds(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh) {
  const StudyVariant& variant = plan.variants[run.variant];
  const double each = time_steps(scene_of(plan, run), variant.mesh ? *variant.mesh : mesh);
  return each > 0.0 ? each * plan.end / run.step : std::nan("");
}

ChosenStudy choose_study(const StudyPlan& frame, const TetMesh& mesh, StudySettings settings,
                         const StudyRequests& requests,
                         const std::function<TrackedRun(const PlannedRun&)>& make) {
  Questioner questioner(frame, mesh, requests);
  const bool has_choice_of_reference = !settings.reference_step;
  const StepQuestion question = questioner.question(settings);
  ChosenStudy chosen{std::move(settings), {}, {}};
  StudySettings& result = chosen.settings;
  result.reference_integrator = requests.reference_integrator.value_or(Integrator::kMidpoint);
  if (question.references.empty()) {
    for (const RuleQuestion& rule : question.rules) {
      result.rule_steps.push_back({rule.rule, rule.asked.steps});
    }
    return chosen;
  }
  // Mistakes in the settings are found before the first run.
  StudySettings checked = result;
  for (const RuleQuestion& rule : question.rules) {
    checked.rule_steps.push_back({rule.rule, {frame.end}});
  }
  if (!checked.reference_step) checked.reference_step = 0.25 * frame.end;
  plan_study(frame.variants.front().scene, mesh, checked);
  // All variants are made with the steps that are chosen with the first one.
  StudyBudget budget(requests.budget / static_cast<double>(frame.variants.size()));
  chosen.choice = choose_steps(question, budget, [&](Integrator rule, double step) {
    PlannedRun run = planned_run(frame, 0, rule, step);
    run.role = StudyRole::kTrial;
    return make(run);
  });
  for (std::size_t i = 0; i < question.rules.size(); ++i) {
    const Integrator integrator = question.rules[i].rule;
    const RuleChoice& rule = chosen.choice.rules[i];
    result.rule_steps.push_back({integrator, rule.steps, rule.trials});
    if (rule.target || rule.stable) {
      chosen.findings.push_back({integrator, rule.target, rule.stable});
    }
  }
  if (has_choice_of_reference && chosen.choice.reference_step > 0.0) {
    result.reference_integrator = chosen.choice.reference;
    result.reference_step = chosen.choice.reference_step;
  }
  return chosen;
}

}  // namespace tetraction
