// The tables of the program `steps`.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "beam.h"
#include "machine_limits.h"
#include "report.h"

namespace tetraction::benchmarks {

struct Settings {
  std::vector<BeamSize> sizes;
  std::vector<int> threads;
  bool quick = false;
  double budget = 20.0;  ///< s for one implicit run; the table marks runs that are cut short

  int repetitions() const { return quick ? 3 : 9; }
};

/// By the number of threads.
using LimitsByThreads = std::map<int, MachineLimits>;

/// The machine, its BLAS and its limits.
LimitsByThreads limits_table(const Settings& settings, Report& report);
/// Explicit steps, with and without balance.
void explicit_table(const Settings& settings, const LimitsByThreads& limits, Report& report);
/// Forces, stiffness and assembly.
void stiffness_table(const Settings& settings, Report& report);
/// Implicit steps and the ratios of their solvers.
void implicit_tables(const Settings& settings, Report& report);
/// Resident memory. It forks, and so it must be called before any thread is started.
void memory_table(const Settings& settings, Report& report);
/// From file to first step.
void large_mesh_table(const Settings& settings, Report& report);

}  // namespace tetraction::benchmarks
