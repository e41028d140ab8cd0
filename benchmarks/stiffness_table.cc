#include "tables.h"
#include "tetraction/fem/sparsity_pattern.h"
#include "timing.h"

namespace tetraction::benchmarks {
namespace {

// Median us per tetrahedron of work().
template <class F>
double measure(const BeamSize& size, int repetitions, const F& work) {
  work();
  std::vector<double> times;
  for (int r = 0; r < repetitions; ++r) times.push_back(seconds_of(work));
  return 1e6 * median(times) / static_cast<double>(size.tetrahedra());
}

}  // namespace

void stiffness_table(const Settings& settings, Report& report) {
  report.table("Forces and assembled stiffness (neo-Hookean): us per tetrahedron",
               {{"size", 4},
                {"tetrahedra", 10},
                {"threads", 7},
                {"repetitions", 11},
                {"force", 7},
                {"stiffness", 9},
                {"both", 7},
                {"stiffness/force", 15},
                {"speed-up", 8}},
               {"stiffness: element matrices, added to a matrix compressed by columns"});
  for (const BeamSize& size : settings.sizes) {
    use_threads(settings.threads.front());
    const auto beam = make_beam(size.mesh());
    const State bent = bent_state(*beam);
    const SparsityPattern pattern(beam->rest(), beam->coordinates());
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
    double first = 0.0;
    for (const int threads : settings.threads) {
      use_threads(threads);
      double energy = 0.0;
      Vector gradient;
      const double force = measure(size, settings.repetitions(), [&] {
        beam->elastic().value_and_gradient(bent.position, energy, gradient);
      });
      const double stiffness = measure(size, settings.repetitions(), [&] {
        beam->elastic().add_hessian(bent.position, pattern, values.data());
      });
      if (first == 0.0) first = stiffness;
      report.row({size.name, size.tetrahedra(), Index{threads}, Index{settings.repetitions()},
                  force, stiffness, force + stiffness, stiffness / force, first / stiffness});
    }
  }
}

}  // namespace tetraction::benchmarks
