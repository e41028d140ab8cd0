#include "machine_limits.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

#include "timing.h"

// The instruction sets of the library's own kernels.
#include "core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "machine_limits.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tetraction::benchmarks {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
constexpr std::int64_t kLanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
// So many chains hide the latency of two units and fit into sixteen registers.
constexpr int kChains = 12;

HWY_INLINE double total(D d, const V* sums, int count) {
  V sum = sums[0];
  for (int k = 1; k < count; ++k) sum = hn::Add(sum, sums[k]);
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

// Returns the number of flops; `sink` keeps the compiler from leaving them out.
double multiply_add_loop(std::int64_t rounds, double* sink) {
  const D d;
  const V factor = hn::Set(d, 0.999 + 0.0 * *sink);
  const V summand = hn::Set(d, 1e-3 + 0.0 * *sink);
  V chains[kChains];
  for (int k = 0; k < kChains; ++k) chains[k] = hn::Set(d, 1.0 + k);
  for (std::int64_t i = 0; i < rounds; ++i) {
    for (int k = 0; k < kChains; ++k) chains[k] = hn::MulAdd(chains[k], factor, summand);
  }
  *sink = total(d, chains, kChains);
  return 2.0 * kChains * static_cast<double>(kLanes * rounds);
}

double read_loop(const double* x, std::int64_t count) {
  constexpr int kSums = 8;
  const D d;
  V sums[kSums];
  for (int k = 0; k < kSums; ++k) sums[k] = hn::Zero(d);
  for (std::int64_t i = 0; i + kSums * kLanes <= count; i += kSums * kLanes) {
    for (int k = 0; k < kSums; ++k) {
      sums[k] = hn::Add(sums[k], hn::LoadU(d, x + i + k * kLanes));
    }
  }
  return total(d, sums, kSums);
}

void triad_loop(double* a, const double* b, const double* c, std::int64_t count) {
  const D d;
  const V factor = hn::Set(d, 3.0);
  for (std::int64_t i = 0; i + kLanes <= count; i += kLanes) {
    hn::StoreU(hn::MulAdd(factor, hn::LoadU(d, c + i), hn::LoadU(d, b + i)), d, a + i);
  }
}

const char* target_name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction::benchmarks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction::benchmarks {
namespace {

HWY_EXPORT(multiply_add_loop);
HWY_EXPORT(read_loop);
HWY_EXPORT(triad_loop);
HWY_EXPORT(target_name);

constexpr int kRepetitions = 7;

// Runs body(t) for t = 0 … threads − 1 at the same time.
template <class F>
void on_threads(int threads, const F& body) {
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back([&body, t] { body(t); });
  body(0);
  for (std::thread& other : others) other.join();
}

// The median rate of work(), which processes `amount`.
template <class F>
double rate_of(double amount, const F& work) {
  work();
  std::vector<double> rates;
  for (int r = 0; r < kRepetitions; ++r) rates.push_back(amount / seconds_of(work));
  return median(rates);
}

double multiply_add_rate(int threads) {
  constexpr std::int64_t kRounds = 5'000'000;
  std::vector<double> sinks(static_cast<std::size_t>(threads), 0.0);
  double unused = 0.0;
  const double flops = HWY_DYNAMIC_DISPATCH(multiply_add_loop)(1, &unused) * kRounds * threads;
  return rate_of(flops, [&] {
    on_threads(threads, [&](int t) {
      double sink = 0.0;
      HWY_DYNAMIC_DISPATCH(multiply_add_loop)(kRounds, &sink);
      sinks[static_cast<std::size_t>(t)] = sink;
    });
  });
}

std::int64_t array_length() {
  constexpr std::int64_t kMebibyte = 1 << 20;
  const std::int64_t cache = std::max<std::int64_t>(sysconf(_SC_LEVEL3_CACHE_SIZE), 0);
  return std::clamp(4 * cache, 128 * kMebibyte, 512 * kMebibyte) / 8;
}

}  // namespace

MachineLimits measure_limits(int threads) {
  MachineLimits limits;
  limits.repetitions = kRepetitions;
  limits.multiply_add = multiply_add_rate(threads);
  const std::int64_t part = array_length() / threads / 64 * 64;
  const std::int64_t length = part * threads;
  std::vector<double> a(static_cast<std::size_t>(length), 0.0);
  const std::vector<double> b(a.size(), 1.0);
  const std::vector<double> c(a.size(), 2.0);
  std::vector<double> sums(static_cast<std::size_t>(threads));
  limits.read = rate_of(8.0 * static_cast<double>(length), [&] {
    on_threads(threads, [&](int t) {
      sums[static_cast<std::size_t>(t)] =
          HWY_DYNAMIC_DISPATCH(read_loop)(b.data() + t * part, part);
    });
  });
  limits.triad = rate_of(24.0 * static_cast<double>(length), [&] {
    on_threads(threads, [&](int t) {
      HWY_DYNAMIC_DISPATCH(triad_loop)
      (a.data() + t * part, b.data() + t * part, c.data() + t * part, part);
    });
  });
  return limits;
}

std::string instruction_set_name() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace tetraction::benchmarks
#endif
