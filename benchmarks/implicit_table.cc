#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tables.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
#include "timing.h"

namespace tetraction::benchmarks {
namespace {

constexpr int kSteps = 20;
constexpr double kStep = 0.01;
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

enum class Solver { kAuto, kKept, kRefactored, kCeres };

struct Case {
  BeamSize size;
  double youngs_modulus;
  bool midpoint;
  int threads;
};

// The steps of a run from rest. There are fewer than kSteps if the time was used up.
struct Run {
  std::vector<double> seconds;
  Index iterations = 0;
  Index cg_iterations = 0;
  Index factorizations = 0;
  std::string linear;
  double tip = kNotMeasured;
  Index repetitions = 0;

  double total(std::size_t steps) const {
    return std::accumulate(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(steps),
                           0.0);
  }
  double per_step(double sum) const { return sum / static_cast<double>(seconds.size()); }
  double ms() const { return 1e3 * per_step(total(seconds.size())); }
};

std::string name(Solver solver) {
  switch (solver) {
    case Solver::kAuto:
      return "auto";
    case Solver::kKept:
      return "factor, kept";
    case Solver::kRefactored:
      return "factor, anew";
    case Solver::kCeres:
      break;
  }
  return "ceres";
}

std::shared_ptr<Minimizer> make_minimizer(const MechanicalSystem& beam, Solver solver) {
  if (solver == Solver::kCeres) return make_ceres_minimizer(beam, {});
  NewtonOptions options;
  if (solver != Solver::kAuto) options.linear = LinearSolver::kFactor;
  options.keep_factor = solver != Solver::kRefactored;
  return make_newton_minimizer(beam, options);
}

Run run_once(const MechanicalSystem& beam, bool midpoint, Solver solver, double budget) {
  const auto minimizer = make_minimizer(beam, solver);
  const auto stepper = midpoint ? make_midpoint_stepper(beam, minimizer)
                                : make_backward_euler_stepper(beam, minimizer);
  State state = beam.rest_state();
  Run run;
  double spent = 0.0;
  for (int k = 0; k < kSteps && spent < budget; ++k) {
    const double start = now();
    const StepOutcome outcome = stepper->step(state, kStep);
    run.seconds.push_back(now() - start);
    require(outcome);
    spent += run.seconds.back();
    run.iterations += outcome.minimizer.iterations;
    run.cg_iterations += outcome.minimizer.cg_iterations;
    run.factorizations += outcome.minimizer.factorizations;
    run.linear = outcome.minimizer.linear;
  }
  if (run.seconds.size() == kSteps) run.tip = tip_deflection(beam, state);
  return run;
}

// Repeats short runs; the times are medians, step by step.
Run measure(const MechanicalSystem& beam, bool midpoint, Solver solver, const Settings& settings) {
  const double budget = settings.quick ? 0.1 * settings.budget : settings.budget;
  Run run = run_once(beam, midpoint, solver, budget);
  std::vector<std::vector<double>> times(run.seconds.size());
  for (std::size_t k = 0; k < times.size(); ++k) times[k].push_back(run.seconds[k]);
  double spent = run.total(run.seconds.size());
  run.repetitions = 1;
  while (run.seconds.size() == kSteps && run.repetitions < settings.repetitions() &&
         spent < 0.15 * budget) {
    const Run again = run_once(beam, midpoint, solver, 1e9);
    for (std::size_t k = 0; k < times.size(); ++k) times[k].push_back(again.seconds[k]);
    spent += again.total(kSteps);
    ++run.repetitions;
  }
  for (std::size_t k = 0; k < times.size(); ++k) run.seconds[k] = median(times[k]);
  return run;
}

void add_row(const Case& c, Solver solver, const Run& run, Report& report) {
  report.row({c.size.name, c.youngs_modulus / 1e6, c.midpoint ? "midpoint" : "backward-euler",
              name(solver), Index{c.threads}, run.repetitions,
              static_cast<Index>(run.seconds.size()), run.ms(),
              run.per_step(static_cast<double>(run.iterations)),
              run.per_step(static_cast<double>(run.cg_iterations)), run.factorizations, run.linear,
              run.tip});
}

std::vector<Column> columns() {
  return {{"size", 4},         {"E MPa", 5},        {"rule", 14},   {"solver", 12},
          {"threads", 7},      {"repetitions", 11}, {"steps", 5},   {"ms/step", 8},
          {"newton/step", 11}, {"cg/step", 7},      {"factors", 7}, {"linear", 11},
          {"tip m", 13, 10}};
}

// The runs to compare. A factor of XL takes about ten gigabytes, and Ceres is slow above M.
std::vector<Solver> solvers(const Case& c) {
  std::vector<Solver> all{Solver::kAuto};
  if (c.size.name != "XL") {
    all.push_back(Solver::kKept);
    all.push_back(Solver::kRefactored);
  }
  if (c.youngs_modulus == kSoft && (c.size.name == "S" || c.size.name == "M")) {
    all.push_back(Solver::kCeres);
  }
  return all;
}

// Time of `a` over that of `b`, over the steps that both have made.
double ratio(const std::map<Solver, Run>& runs, Solver a, Solver b) {
  if (!runs.contains(a) || !runs.contains(b)) return kNotMeasured;
  const std::size_t steps = std::min(runs.at(a).seconds.size(), runs.at(b).seconds.size());
  return runs.at(a).total(steps) / runs.at(b).total(steps);
}

struct Ratios {
  Case of;
  double auto_to_ceres, anew_to_kept, kept_to_auto, speed_up;
};

Ratios run_case(Case c, const MechanicalSystem& beam, const Settings& settings, Report& report) {
  std::map<Solver, Run> runs;
  c.threads = settings.threads.front();
  use_threads(c.threads);
  for (const Solver solver : solvers(c)) {
    runs[solver] = measure(beam, c.midpoint, solver, settings);
    add_row(c, solver, runs[solver], report);
  }
  Ratios ratios{c, ratio(runs, Solver::kAuto, Solver::kCeres),
                ratio(runs, Solver::kRefactored, Solver::kKept),
                ratio(runs, Solver::kKept, Solver::kAuto), kNotMeasured};
  for (std::size_t i = 1; i < settings.threads.size(); ++i) {
    Case more = c;
    more.threads = settings.threads[i];
    use_threads(more.threads);
    const Run run = measure(beam, c.midpoint, Solver::kAuto, settings);
    add_row(more, Solver::kAuto, run, report);
    ratios.speed_up = runs[Solver::kAuto].ms() / run.ms();
  }
  return ratios;
}

void ratio_table(const std::vector<Ratios>& all, Report& report) {
  report.table("Implicit steps: ratios of times over the steps that both made",
               {{"size", 4},
                {"E MPa", 5},
                {"rule", 14},
                {"auto / ceres", 12},
                {"factor anew / kept", 18},
                {"factor kept / auto", 18},
                {"speed-up of auto", 16}},
               {"speed-up: most threads over fewest"});
  for (const Ratios& r : all) {
    report.row({r.of.size.name, r.of.youngs_modulus / 1e6,
                r.of.midpoint ? "midpoint" : "backward-euler", r.auto_to_ceres, r.anew_to_kept,
                r.kept_to_auto, r.speed_up});
  }
}

}  // namespace

void implicit_tables(const Settings& settings, Report& report) {
  report.table("Implicit steps from rest, h = 0.01 s, tolerance 1e-8: mean of 20 steps", columns(),
               {"fewer steps than 20: the time for a row was used up; no tip then"});
  std::vector<Ratios> ratios;
  for (const double youngs_modulus : {kSoft, kStiff}) {
    for (const BeamSize& size : settings.sizes) {
      // Stiff bodies need a factor, and that of XL takes about ten gigabytes.
      if (youngs_modulus == kStiff && size.name == "XL") continue;
      const auto beam = make_beam(size.mesh(), youngs_modulus);
      for (const bool midpoint : {false, true}) {
        ratios.push_back(run_case({size, youngs_modulus, midpoint, 1}, *beam, settings, report));
      }
    }
  }
  ratio_table(ratios, report);
}

}  // namespace tetraction::benchmarks
