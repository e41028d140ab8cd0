#include <algorithm>
#include <utility>

#include "tables.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/material/material.h"
#include "timing.h"

namespace tetraction::benchmarks {
namespace {

// The least data and arithmetic that an explicit step needs for each tetrahedron.
constexpr double kBytes = 100.0;       // rest data, slots and its share of the vertices' fields
constexpr double kMultiplyAdds = 125;  // neo-Hookean

struct Timing {
  double step = 0.0;     // ns per tetrahedron and step
  double balance = 0.0;  // what Balance::enter() adds, per cent of the step
};

using Rule = std::unique_ptr<Stepper> (*)(const MechanicalSystem&);

struct Loop {
  const MechanicalSystem& beam;
  const State& start;
  double h = 0.0;
  Index steps = 0;
};

// Seconds for one step. Every repetition starts from the same state.
double run_once(const Loop& loop, Stepper& stepper, bool with_books) {
  State state = loop.start;
  State next;
  const auto step = [&] {
    const StepOutcome outcome = stepper.advance(state, next, loop.h, state.time + loop.h);
    require(outcome);
    std::swap(state, next);
    return outcome;
  };
  stepper.reset();
  step();
  Balance balance(loop.beam, state);
  const double seconds = seconds_of([&] {
    for (Index k = 0; k < loop.steps; ++k) {
      const StepOutcome outcome = step();
      if (with_books) balance.enter(state, outcome);
    }
  });
  return seconds / static_cast<double>(loop.steps);
}

// Measures with and without the balance in turns, so that the load of the machine is the same for
// both.
Timing measure(const Loop& loop, Rule rule, int repetitions) {
  const std::unique_ptr<Stepper> stepper = rule(loop.beam);
  std::vector<double> bare;
  std::vector<double> extra;
  run_once(loop, *stepper, true);
  for (int r = 0; r < repetitions; ++r) {
    bare.push_back(run_once(loop, *stepper, false));
    extra.push_back(100.0 * (run_once(loop, *stepper, true) / bare.back() - 1.0));
  }
  const double per_tetrahedron = 1e9 / static_cast<double>(loop.beam.mesh().tetrahedron_count());
  return {per_tetrahedron * median(bare), median(extra)};
}

std::vector<Column> columns() {
  return {{"size", 4},         {"tetrahedra", 10},  {"material", 13},
          {"rule", 8},         {"threads", 7},      {"repetitions", 11},
          {"ns/tet", 7},       {"x bandwidth", 11}, {"x multiply-add", 14},
          {"balance %", 9, 2}, {"speed-up", 8}};
}

}  // namespace

void explicit_table(const Settings& settings, const LimitsByThreads& limits, Report& report) {
  report.table(
      "Explicit steps: time per tetrahedron and step", columns(),
      {"x bandwidth: times what reading 100 bytes a tetrahedron from memory takes",
       "x multiply-add: times what 125 multiply-adds a tetrahedron take",
       "speed-up: over the first number of threads (at most the machine's own, see its limits)"});
  for (const BeamSize& size : settings.sizes) {
    use_threads(settings.threads.front());
    const auto beam = make_beam(size.mesh());
    const State bent = bent_state(*beam);
    const double work = settings.quick ? 2e6 : 1e7;  // tetrahedra in a repetition
    const Index steps =
        std::max<Index>(3, static_cast<Index>(work / static_cast<double>(size.tetrahedra())));
    const Loop loop{*beam, bent, size.explicit_step(), steps};
    for (const char* material :
         {NeoHookean::kName, StVenantKirchhoff::kName, MooneyRivlin::kName}) {
      beam->set_material(0, beam_material(material, kSoft));
      for (const bool verlet : {false, true}) {
        double first = 0.0;
        for (const int threads : settings.threads) {
          use_threads(threads);
          const Timing t = measure(loop, verlet ? make_verlet_stepper : make_explicit_stepper,
                                   settings.repetitions());
          if (first == 0.0) first = t.step;
          const MachineLimits& limit = limits.at(threads);
          report.row({size.name, size.tetrahedra(), material, verlet ? "verlet" : "explicit",
                      Index{threads}, Index{settings.repetitions()}, t.step,
                      1e-9 * t.step * limit.read / kBytes,
                      1e-9 * t.step * limit.multiply_add / (2.0 * kMultiplyAdds), t.balance,
                      first / t.step});
        }
      }
    }
  }
}

}  // namespace tetraction::benchmarks
