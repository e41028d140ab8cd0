// The highest rates that the machine reaches. The times of the steps are compared with them.
#pragma once

#include <string>

namespace tetraction::benchmarks {

struct MachineLimits {
  double multiply_add = 0.0;  ///< double precision, from registers: flop/s, two per multiply-add
  double read = 0.0;          ///< from memory, B/s
  double triad = 0.0;         ///< a = b + s c in memory, B/s of the 24 bytes that the source names
  int repetitions = 0;        ///< number of repetitions for each median
};

/// Measures with `threads` threads at once, about a second. The arrays are four times the last-level
/// cache, 128 to 512 MiB each.
MachineLimits measure_limits(int threads);

/// Name of the widest instruction set of this machine, e.g. "AVX3" (AVX-512), "AVX2".
std::string instruction_set_name();

}  // namespace tetraction::benchmarks
