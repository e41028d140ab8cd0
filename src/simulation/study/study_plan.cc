// Which runs a study makes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "core/quoting.h"
#include "core/spelling.h"
#include "run_scene.h"
#include "simulation/scene/initial_state.h"
#include "simulation/scene/setting_keys.h"
#include "simulation/stepping/step_count.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

// `what` names the step in messages.
double checked_step(double step, double end, const std::string& what) {
  if (!(step > 0.0) || !std::isfinite(step) || step > end) {
    throw InputError(fmt::format("{} must be positive and at most the end time {} s, not {} s.",
                                 what, end, step));
  }
  if (end / step > kMostSteps) {
    throw InputError(fmt::format(
        "{} is {} s. A run of {} s would have more steps than can be counted: make it larger.",
        what, step, end));
  }
  return step;
}

void check_scenes(const std::vector<StudyVariant>& variants) {
  const StudyVariant& first = variants.front();
  for (const StudyVariant& variant : variants) {
    if (variant.scene.time.end == first.scene.time.end) continue;
    throw InputError(
        fmt::format("The variants {} and {} end at different times, {} s and {} s: give all the "
                    "same time.end, or their positions cannot be compared.",
                    first.name, variant.name, first.scene.time.end, variant.scene.time.end));
  }
  for (const StudyVariant& variant : variants) {
    const StepAdaptation adapt = variant.scene.time.adapt;
    if (adapt == StepAdaptation::kNone) continue;
    throw InputError(
        fmt::format("time.adapt = \"{}\" chooses the steps, and a study compares steps that are "
                    "given: leave time.adapt out (--set time.adapt=none), and make a rule of it: "
                    "--rule midpoint:time.adapt={}.",
                    to_string(adapt), to_string(adapt)));
  }
  for (const StudyVariant& variant : variants) {
    for (const EventSettings& event : variant.scene.event) {
      for (const Edit& edit : event.edits) {
        if (!std::holds_alternative<SetTime>(edit)) continue;
        throw InputError(event.where +
                         " changes [time], which a study does itself: integrators and steps are "
                         "what it compares. Leave that change out.");
      }
    }
  }
}

const ProbeSettings& error_probe_of(const StudyVariant& variant, const std::string& name) {
  const std::vector<ProbeSettings>& probes = variant.scene.probe;
  const auto found = std::find_if(probes.begin(), probes.end(),
                                  [&](const ProbeSettings& probe) { return probe.name == name; });
  if (found != probes.end()) return *found;
  NameList names;
  for (const ProbeSettings& probe : probes) names.emplace_back(probe.name);
  throw InputError(fmt::format(
      "The error of the probe {} is asked for, but {} has no probe of that name: {}",
      in_quotes(name), variant.name.empty() ? "the scene" : "the variant " + variant.name,
      names.empty() ? "add a [[probe]]." : advice(name, names)));
}

// All variants must have the probe, and its values must be comparable. An energy must be one of `energies`.
void check_error_probe(const StudyPlan& plan, const std::vector<std::string>& energies) {
  if (plan.error_probe.empty()) return;
  if (plan.error_kind == ErrorKind::kEnergy) {
    if (std::count(energies.begin(), energies.end(), plan.error_probe) > 0) return;
    throw InputError(fmt::format(
        "--error {}: history.csv has no energy of that name: {}", to_string(plan.error_series()),
        advice(plan.error_probe, NameList(energies.begin(), energies.end()))));
  }
  const StudyVariant& first = plan.variants.front();
  const ProbeQuantity quantity = error_probe_of(first, plan.error_probe).quantity;
  for (const StudyVariant& variant : plan.variants) {
    const ProbeQuantity other = error_probe_of(variant, plan.error_probe).quantity;
    if (other == quantity) continue;
    throw InputError(fmt::format(
        "The probe \"{}\" is a {} in the variant {} and a {} in the variant {}: they "
        "cannot be compared.",
        plan.error_probe, to_string(quantity), first.name, to_string(other), variant.name));
  }
}

// Adds a run unless it is there already. Returns its index.
std::size_t add_run(StudyPlan& plan, PlannedRun run) {
  const auto found = std::find_if(plan.runs.begin(), plan.runs.end(), [&](const PlannedRun& other) {
    return other.directory == run.directory;
  });
  if (found != plan.runs.end()) return static_cast<std::size_t>(found - plan.runs.begin());
  plan.runs.push_back(std::move(run));
  return plan.runs.size() - 1;
}

// `run` is that with the scene's own solver.
void add_comparison(StudyPlan& plan, PlannedRun run, const SolverComparison& wanted) {
  SolverSettings solver = plan.variants[run.variant].scene.solver;
  if (wanted.solver == solver.kind) {
    throw InputError(fmt::format(
        "The scene's own solver is {} already, so that there is nothing to compare it with. To run "
        "it at {} s, add that step to the steps of the study.",
        solver.kind, wanted.step));
  }
  solver.kind = wanted.solver;
  solver.linear = LinearSolver::kAuto;  // as in scene_of()
  check_settings(solver);
  checked_step(wanted.step, plan.end, fmt::format("The step at which {} is compared", solver.kind));
  run.solver = wanted.solver;
  run.compares_solver = true;
  run.directory += "-" + wanted.solver;
  const std::size_t count = plan.runs.size();
  if (add_run(plan, std::move(run)) < count) {
    throw InputError(
        fmt::format("The solver {} at {} s is there twice.", wanted.solver, wanted.step));
  }
}

// The step of a second run that tells the error of a reference with this step, or nothing if there is no longer one at
// which its rule can be stable.
std::optional<double> second_step(const StudyPlan& plan, Integrator integrator, double step) {
  constexpr double kStable = 0.9;
  constexpr double kLonger = 1.05;
  double second = std::min(2.0 * step, plan.end);
  if (!is_implicit(integrator) && second > kStable * plan.stable_step) {
    second = kStable * plan.stable_step;
  }
  if (second < kLonger * step) return {};
  return second;
}

// Whether a run of the study tells the error of this reference.
bool tells_the_error(const StudyPlan& plan, const PlannedRun& run, const PlannedRun& reference) {
  return run.variant == reference.variant && run.rule() == reference.rule() &&
         run.step > reference.step && (is_implicit(run.integrator) || run.step <= plan.stable_step);
}

// Adds the runs of the references, and gives all runs their order and roles.
void add_references(StudyPlan& plan, const StudySettings& settings, double finest_step) {
  const double step = settings.reference_step
                          ? checked_step(*settings.reference_step, plan.end, "The reference step")
                          : finest_step;
  std::vector<double> steps{step};
  if (settings.reference_kind == ReferenceKind::kRichardson) {
    steps = {2.0 * step, step, 0.5 * step};
    checked_step(steps.front(), plan.end, "Twice the reference step");
    checked_step(steps.back(), plan.end, "Half the reference step");
  }
  std::vector<std::vector<std::string>> folders(plan.references.size());
  std::set<std::string> serves;  // folders of the runs that make references or tell their errors
  const std::size_t asked = plan.runs.size();
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    const std::size_t variant = plan.references[i].variant;
    const auto add = [&](double of) {
      return add_run(plan, planned_run(plan, variant, settings.reference_integrator, of));
    };
    for (const double of : steps) folders[i].push_back(plan.runs[add(of)].directory);
    serves.insert(folders[i].begin(), folders[i].end());
    const PlannedRun reference = plan.runs[add(steps.back())];
    const bool is_known =
        std::any_of(plan.runs.begin(), plan.runs.end(),
                    [&](const PlannedRun& run) { return tells_the_error(plan, run, reference); });
    if (is_known) continue;
    if (const auto second = second_step(plan, reference.integrator, reference.step)) {
      serves.insert(plan.runs[add(*second)].directory);
    }
  }

  std::map<std::pair<std::size_t, StudyRule>, std::size_t> blocks;  // in their order
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    PlannedRun& run = plan.runs[i];
    blocks.emplace(std::make_pair(run.variant, run.rule()), i);
    const bool is_trial = run.role == StudyRole::kTrial;
    if (i >= asked || (is_trial && serves.contains(run.directory))) {
      run.role = StudyRole::kReference;
    } else if (!is_trial &&
               run.variant != plan.references[plan.reference_of[run.variant]].variant) {
      run.role = StudyRole::kVariant;
    }
  }
  const auto place = [&](const PlannedRun& run) {
    return std::make_tuple(run.variant, blocks.at({run.variant, run.rule()}), run.compares_solver,
                           run.compares_solver ? 0.0 : run.step);
  };
  std::stable_sort(plan.runs.begin(), plan.runs.end(),
                   [&](const PlannedRun& a, const PlannedRun& b) { return place(a) < place(b); });
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    for (const std::string& folder : folders[i]) {
      PlannedRun run;
      run.directory = folder;
      plan.references[i].runs.push_back(add_run(plan, std::move(run)));
    }
  }
}

const TetMesh& mesh_of(const StudyVariant& variant, const TetMesh& mesh) {
  return variant.mesh ? *variant.mesh : mesh;
}

// Throws InputError if a run cannot have its solver.
void check_solvers(const StudyPlan& plan, const TetMesh& mesh) {
  for (std::size_t variant = 0; variant < plan.variants.size(); ++variant) {
    const Scene& scene = plan.variants[variant].scene;
    try {
      const std::unique_ptr<MechanicalSystem> system =
          make_system(scene, mesh_of(plan.variants[variant], mesh));
      for (const PlannedRun& run : plan.runs) {
        if (run.variant != variant) continue;
        check_solver(run.integrator, scene_of(plan, run).solver, *system);
      }
    } catch (const InputError& error) {
      const std::string& name = plan.variants[variant].name;
      if (name.empty()) throw;
      throw InputError(fmt::format("The variant {}: {}", name, error.what()));
    }
  }
}

// Whether positions on the meshes can be compared.
bool have_same_elements(const TetMesh& a, const TetMesh& b) {
  if (&a == &b) return true;
  return std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end()) &&
         std::equal(a.tetrahedra.begin(), a.tetrahedra.end(), b.tetrahedra.begin(),
                    b.tetrahedra.end()) &&
         a.edge_vertices == b.edge_vertices;
}

// Whether a key leaves the exact motion as it is. Probes do if no error is computed from them.
bool keeps_the_motion(const std::string& key, bool has_error_probe) {
  const std::string section = key.substr(0, key.find('.'));
  return section == "solver" || (section == "probe" && !has_error_probe);
}

// Gives each variant the reference of the first one with the same motion, whose runs are not known yet.
void group_variants(StudyPlan& plan, const TetMesh& mesh) {
  std::map<std::vector<std::pair<std::string, std::string>>, std::size_t> known;
  for (std::size_t variant = 0; variant < plan.variants.size(); ++variant) {
    std::vector<std::pair<std::string, std::string>> motion;
    for (const VariedValue& varied : plan.variants[variant].values) {
      if (keeps_the_motion(varied.key, !plan.error_probe.empty())) continue;
      motion.emplace_back(varied.key, varied.value);
    }
    const bool has_values = !plan.variants[variant].values.empty();
    const auto found = has_values ? known.find(motion) : known.end();
    if (found != known.end()) {
      plan.reference_of.push_back(found->second);
      continue;
    }
    const std::size_t index = plan.references.size();
    if (has_values) known.emplace(std::move(motion), index);
    plan.references.push_back({variant, {}});
    plan.reference_of.push_back(index);
    plan.has_first_mesh.push_back(have_same_elements(mesh_of(plan.variants.front(), mesh),
                                                     mesh_of(plan.variants[variant], mesh)));
  }
}

}  // namespace

PlannedRun planned_run(const StudyPlan& plan, std::size_t variant, const StudyRule& rule,
                       double step) {
  const StudyVariant& scene = plan.variants[variant];
  PlannedRun run;
  run.variant = variant;
  run.integrator = rule.integrator;
  run.step = step;
  run.settings = rule.settings;
  if (is_implicit(rule.integrator)) run.solver = scene_of(plan, run).solver.kind;
  if (needs_root_finder(rule.integrator)) run.solver = "newton";  // others minimise
  std::string folder = scene.folder.empty() ? scene.name : scene.folder;
  if (!folder.empty()) folder += '-';
  folder += to_string(rule.integrator);
  if (!rule.settings.empty()) folder += "-" + folder_name(rule);
  run.directory = fmt::format("{}-{:.10g}", folder, step);
  return run;
}

StudyPlan begin_plan(const Scene& scene, const TetMesh& mesh, const StudySettings& settings) {
  StudyPlan plan;
  plan.variants = settings.variants;
  if (plan.variants.empty()) plan.variants.push_back({"", scene});
  check_scenes(plan.variants);
  plan.error_probe = settings.error_probe;
  plan.error_kind = settings.error_kind;
  plan.repeats = settings.repeats;
  plan.repeat_seconds = settings.repeat_seconds;
  if (plan.error_kind != ErrorKind::kProbe &&
      settings.reference_kind == ReferenceKind::kRichardson) {
    throw InputError(
        "A reference that is extrapolated has no peaks and frequencies of its own: leave "
        "--reference "
        "richardson out, or compare the values of the probe over time (--error probe.NAME).");
  }
  const Scene& first = plan.variants.front().scene;
  plan.end = first.time.end;
  const std::unique_ptr<MechanicalSystem> system =
      make_system(first, mesh_of(plan.variants.front(), mesh));
  plan.probes = ProbeSet(first.probe, *system).probes();
  const State initial = make_initial_state(first, *system);
  Energies energies;
  evaluate_energies(*system, initial, energies);
  check_error_probe(plan, energy_columns(energies));
  plan.stable_step = stability_limit(*system, initial.position).critical_step;
  return plan;
}

StudyPlan plan_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings) {
  StudyPlan plan = begin_plan(scene, mesh, settings);
  std::vector<RuleSteps> rules = settings.rule_steps;
  if (rules.empty()) {
    for (const Integrator integrator :
         settings.integrators.empty() ? all_integrators() : settings.integrators) {
      rules.push_back({integrator, settings.steps});
    }
  }
  for (RuleSteps& rule : rules) {
    check_settings_of(rule.rule());
    std::sort(rule.settings.begin(), rule.settings.end());
    std::sort(rule.steps.begin(), rule.steps.end());
  }
  const auto implicit = std::find_if(rules.begin(), rules.end(), [](const RuleSteps& rule) {
    return is_implicit(rule.integrator) && !needs_root_finder(rule.integrator) &&
           rule.settings.empty();
  });
  if (!settings.solver_comparisons.empty() && implicit == rules.end()) {
    throw InputError(
        "Solvers can be compared only in a study with an integrator that minimises: add midpoint "
        "or "
        "backward-euler to its integrators.");
  }
  group_variants(plan, mesh);
  double finest = plan.end;
  for (std::size_t variant = 0; variant < plan.variants.size(); ++variant) {
    for (auto rule = rules.begin(); rule != rules.end(); ++rule) {
      for (const double step : rule->steps) {
        checked_step(step, plan.end, "A step of the study");
        finest = std::min(finest, step);
        add_run(plan, planned_run(plan, variant, rule->rule(), step));
      }
      if (variant > 0) continue;
      for (const double step : rule->trials) {
        PlannedRun run = planned_run(plan, variant, rule->rule(), step);
        run.role = StudyRole::kTrial;
        add_run(plan, std::move(run));
      }
      if (rule != implicit) continue;
      for (const SolverComparison& wanted : settings.solver_comparisons) {
        add_comparison(plan, planned_run(plan, variant, rule->integrator, wanted.step), wanted);
      }
    }
  }
  if (plan.runs.empty()) throw InputError("The study has no runs: give it steps.");
  check_solvers(plan, mesh);
  add_references(plan, settings, finest);
  return plan;
}

}  // namespace tetraction
