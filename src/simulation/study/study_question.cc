// From what a study is asked for to the steps of its rules.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
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
        requests_(requests),
        scales_{frame.end, frame.stable_step, [this] { return required_period(); }} {}

  StepQuestion question(const StudySettings& settings) {
    StepQuestion question;
    question.end = frame_.end;
    question.error = requests_.error;
    question.target = requests_.target;
    for (std::size_t i = 0; i < requests_.rules.size(); ++i) {
      question.rules.push_back(about(requests_.rules[i], requests_.steps[i]));
    }
    if (!chooses_steps(requests_)) return question;
    if (!std::isfinite(scales_.stable_step)) {
      throw InputError(
          "No steps can be chosen, because nothing in this scene limits the explicit rules, as "
          "where "
          "every vertex is held. Leave vertices free, or give --steps.");
    }
    question.period = period().period;
    question.reference_step = settings.reference_step;
    // The explicit rule of second order is the cheapest one where it is not too slow.
    std::vector<Integrator> references{Integrator::kVerlet, Integrator::kMidpoint};
    if (settings.reference_step) references = {Integrator::kMidpoint};
    if (requests_.reference_integrator) references = {*requests_.reference_integrator};
    for (const Integrator integrator : references) {
      question.references.push_back(about(integrator, {}));
    }
    for (auto* rules : {&question.rules, &question.references}) {
      for (RuleQuestion& rule : *rules) set_time(rule);
    }
    return question;
  }

  const std::map<Integrator, double>& seconds_per_step() const { return seconds_per_step_; }

 private:
  RuleQuestion about(const StudyRule& rule, const std::vector<StepRequest>& steps) {
    check_settings_of(rule);
    RuleQuestion question;
    question.rule = rule;
    question.stable_step = scales_.stable_step;
    question.adapts = scene_of(frame_, planned_run(frame_, 0, rule, frame_.end)).time.adapt !=
                      StepAdaptation::kNone;
    const bool needs_limit = requests_.target || steps.empty() ||
                             std::any_of(steps.begin(), steps.end(), [](const StepRequest& step) {
                               return step.unit == StepUnit::kAuto;
                             });
    if (needs_limit && rule.integrator == Integrator::kVerlet) {
      const State start = make_initial_state(scene_, system());
      question.stable_step =
          stability_limit(system(), start.position, Integrator::kVerlet).critical_step;
    }
    question.asked = resolve_steps(steps, rule.integrator, question.stable_step, scales_);
    return question;
  }

  // Explicit rules are timed, because their first runs may be long.
  void set_time(RuleQuestion& rule) {
    const Integrator integrator = rule.rule.integrator;
    if (is_implicit(integrator) || rule.adapts || !std::isfinite(rule.stable_step)) return;
    const auto known = requests_.seconds_per_step.find(integrator);
    const auto [place, is_new] = seconds_per_step_.try_emplace(integrator);
    if (known != requests_.seconds_per_step.end()) {
      place->second = known->second;
    } else if (is_new) {
      const double step = std::min(frame_.end, rule.stable_step);
      place->second = time_steps(scene_of(frame_, planned_run(frame_, 0, integrator, step)), mesh_);
    }
    rule.seconds_per_step = place->second;
  }

  MechanicalSystem& system() {
    if (!system_) system_ = make_system(scene_, mesh_);
    return *system_;
  }

  const ExcitedPeriod& period() {
    if (!period_) period_ = excited_period(scene_, system());
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
  std::unique_ptr<MechanicalSystem> system_;
  std::optional<ExcitedPeriod> period_;
  std::map<Integrator, double> seconds_per_step_;
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
  ChosenStudy chosen{std::move(settings), {}, requests.target};
  StudySettings& result = chosen.settings;
  result.reference_integrator = requests.reference_integrator.value_or(Integrator::kMidpoint);
  const auto add_steps = [](StudySettings& to, const StudyRule& rule, std::vector<double> steps,
                            std::vector<double> trials = {}) {
    to.rule_steps.push_back({rule.integrator, std::move(steps), std::move(trials), rule.settings});
  };
  if (question.references.empty()) {
    for (const RuleQuestion& rule : question.rules) {
      add_steps(result, rule.rule, rule.asked.steps);
    }
    return chosen;
  }
  // Mistakes in the settings are found before the first run.
  StudySettings checked = result;
  for (const RuleQuestion& rule : question.rules) add_steps(checked, rule.rule, {frame.end});
  if (!checked.reference_step) checked.reference_step = 0.25 * frame.end;
  plan_study(frame.variants.front().scene, mesh, checked);
  // All variants are made with the steps that are chosen with the first one.
  StudyBudget budget(requests.budget / static_cast<double>(frame.variants.size()));
  chosen.choice = choose_steps(question, budget, [&](const StudyRule& rule, double step) {
    PlannedRun run = planned_run(frame, 0, rule, step);
    run.role = StudyRole::kTrial;
    return make(run);
  });
  PlannedSteps& plan = chosen.plan.emplace();
  plan.budget = requests.budget;
  plan.seconds_per_step = questioner.seconds_per_step();
  for (std::size_t i = 0; i < question.rules.size(); ++i) {
    const RuleQuestion& asked = question.rules[i];
    const RuleChoice& rule = chosen.choice.rules[i];
    add_steps(result, asked.rule, rule.steps, rule.trials);
    plan.rules.push_back({asked.rule, rule.steps, rule.steps != asked.asked.steps});
    if (rule.target || rule.stable) {
      chosen.findings.push_back(
          {asked.rule.integrator, rule.target, rule.stable, asked.rule.settings});
    }
  }
  if (has_choice_of_reference && chosen.choice.reference_step > 0.0) {
    result.reference_integrator = chosen.choice.reference;
    result.reference_step = chosen.choice.reference_step;
  }
  return chosen;
}

void ChosenStudy::add_to(StudyResult& result) const {
  result.target = target;
  result.findings = findings;
  result.plan = plan;
  result.remarks.insert(result.remarks.begin(), choice.remarks.begin(), choice.remarks.end());
}

StudyResult run_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings,
                      const ObserverFactory& observers, const StudyProgress& progress) {
  if (!settings.steps.empty() || !settings.rule_steps.empty()) {
    return run_study(plan_study(scene, mesh, settings), mesh, observers, progress);
  }
  StudyRequests requests;
  const std::vector<Integrator>& rules =
      settings.integrators.empty() ? all_integrators() : settings.integrators;
  requests.rules.assign(rules.begin(), rules.end());
  requests.steps.resize(rules.size());
  if (!settings.error_probe.empty()) requests.error = {settings.error_kind, settings.error_probe};
  if (settings.reference_integrator != StudySettings().reference_integrator) {
    requests.reference_integrator = settings.reference_integrator;
  }
  const StudyMemory memory = memory_of_runs();
  const StudyPlan frame = begin_plan(scene, mesh, settings);
  const ChosenStudy chosen =
      choose_study(frame, mesh, settings, requests, [&](const PlannedRun& run) {
        return make_tracked_run(frame, run, mesh, observers, progress, memory);
      });
  StudyResult result;
  result.is_interrupted = true;
  if (chosen.choice.is_stopped) return result;
  result = run_study(plan_study(scene, mesh, chosen.settings), mesh, observers, progress, memory);
  chosen.add_to(result);
  return result;
}

}  // namespace tetraction
