// Whole steps, measured as ratios within one run: docs/performance.md tells how to read the tables.
//
//     steps --sizes S,M,L,XL --threads 1,2 --json steps.json
//     steps --quick                                     a minute, coarser
//     steps --only explicit,implicit --sizes M
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <thread>

#include "tables.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"

namespace tetraction::benchmarks {

LimitsByThreads limits_table(const Settings& settings, Report& report) {
  const BlasInfo blas = blas_info();
  report.table(
      "The machine's limits",
      {{"threads", 7},
       {"repetitions", 11},
       {"multiply-add GF/s", 17},
       {"read GB/s", 9},
       {"triad GB/s", 10},
       {"speed-up", 8}},
      {fmt::format("{} hardware threads, instruction set {}, BLAS {} {}",
                   std::thread::hardware_concurrency(), instruction_set_name(), blas.library,
                   blas.core),
       "two flops a multiply-add, double precision; triad: 24 bytes an entry",
       "speed-up: of multiply-adds; where threads share a core or its time it stays at 1"});
  LimitsByThreads limits;
  for (const int threads : settings.threads) {
    const MachineLimits l = measure_limits(threads);
    limits[threads] = l;
    report.row({Index{threads}, Index{l.repetitions}, 1e-9 * l.multiply_add, 1e-9 * l.read,
                1e-9 * l.triad, l.multiply_add / limits.at(settings.threads.front()).multiply_add});
  }
  return limits;
}

namespace {

struct Choice {
  std::vector<std::string> sizes{"S", "M", "L"};
  std::vector<int> threads{1, 2};
  std::vector<std::string> only;
  std::string json;
  bool quick = false;
  double budget = 20.0;

  bool wants(const std::string& table) const {
    return only.empty() || std::find(only.begin(), only.end(), table) != only.end();
  }
};

void add_options(CLI::App& app, Choice& choice) {
  app.add_option("--sizes", choice.sizes, "beams to measure: S,M,L,XL")
      ->delimiter(',')
      ->check(CLI::IsMember({"S", "M", "L", "XL"}))
      ->capture_default_str();
  app.add_option("--threads", choice.threads,
                 "numbers of threads; those above the number of cores are left out")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--only", choice.only,
                 "tables to make: explicit,stiffness,implicit,memory,large (the limits always)")
      ->delimiter(',')
      ->check(CLI::IsMember({"explicit", "stiffness", "implicit", "memory", "large"}));
  app.add_option("--budget", choice.budget, "seconds for one run of implicit steps")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", choice.json, "write the tables to this file, too");
  app.add_flag("--quick", choice.quick, "fewer repetitions, a smaller large mesh");
}

Settings settings_of(const Choice& choice) {
  Settings settings;
  settings.quick = choice.quick;
  settings.budget = choice.budget;
  for (const std::string& size : choice.sizes) settings.sizes.push_back(beam_size(size));
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  for (const int threads : choice.threads) {
    if (threads <= cores) settings.threads.push_back(threads);
  }
  if (settings.threads.empty()) settings.threads.push_back(cores);
  return settings;
}

void measure(const Choice& choice) {
  const Settings settings = settings_of(choice);
  Report report;
  // This table comes first, because it forks, which must happen before threads are started.
  if (choice.wants("memory")) memory_table(settings, report);
  const LimitsByThreads limits = limits_table(settings, report);
  if (choice.wants("explicit")) explicit_table(settings, limits, report);
  if (choice.wants("stiffness")) stiffness_table(settings, report);
  if (choice.wants("implicit")) implicit_tables(settings, report);
  if (choice.wants("large")) large_mesh_table(settings, report);
  // The limits are measured again to show how much the machine itself has changed meanwhile.
  limits_table(settings, report);
  if (!choice.json.empty()) report.write_json(choice.json);
}

}  // namespace
}  // namespace tetraction::benchmarks

int main(int argc, char** argv) {
  CLI::App app("Measures whole steps against the machine's limits and against each other.");
  tetraction::benchmarks::Choice choice;
  tetraction::benchmarks::add_options(app, choice);
  CLI11_PARSE(app, argc, argv);
  try {
    tetraction::benchmarks::measure(choice);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
