// Runs the vectorised kernels on every instruction set that this processor has.
#pragma once

// The macros that leave out sets come before Highway.
#include "core/simd_targets.h"

#include <hwy/targets.h>

#include <cstdint>
#include <string>
#include <vector>

namespace tetraction::testing_support {

/// The sets that the kernels are compiled for and this processor has, best first; the last is the
/// fallback that every processor has.
inline std::vector<std::int64_t> instruction_sets() {
  std::vector<std::int64_t> sets;
  const std::int64_t possible = hwy::SupportedTargets() & HWY_TARGETS;
#if HWY_ARCH_X86
  for (const std::int64_t set : {HWY_AVX3, HWY_AVX2}) {
    if ((possible & set) != 0 && set != HWY_STATIC_TARGET) sets.push_back(set);
  }
#else
  for (std::int64_t rest = possible; rest != 0; rest &= rest - 1) {
    const std::int64_t set = rest & ~(rest - 1);
    if (set != HWY_STATIC_TARGET) sets.push_back(set);
  }
#endif
  sets.push_back(HWY_STATIC_TARGET);
  return sets;
}

/// Lets the kernels use one instruction set until the end of the scope.
class UseInstructionSet {
 public:
  explicit UseInstructionSet(std::int64_t set) {
    hwy::SetSupportedTargetsForTest(set);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~UseInstructionSet() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  UseInstructionSet(const UseInstructionSet&) = delete;
  UseInstructionSet& operator=(const UseInstructionSet&) = delete;
};

inline std::string instruction_set_name(std::int64_t set) {
  return hwy::TargetName(set);
}

}  // namespace tetraction::testing_support
