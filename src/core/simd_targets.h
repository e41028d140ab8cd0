// Which instruction sets the vectorised kernels are compiled for. A file with kernels includes this
// before Highway.
//
// On x86 these are SSE2, which all have, AVX2 and AVX-512 (Highway's AVX3). Sets whose vectors
// have no size at compile time (SVE of Arm, RVV of RISC-V) are left out, because the kernels store
// vectors in structs and arrays. Those processors use an instruction set with vectors of fixed size,
// or the portable set.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// The code of each set is the same, and GCC takes minutes for one of them with sanitizers.
#define TETRACTION_DISABLED_FOR_SANITIZERS HWY_AVX3
#else
#define TETRACTION_DISABLED_FOR_SANITIZERS 0
#endif

#define HWY_DISABLED_TARGETS                                                                      \
  (TETRACTION_DISABLED_FOR_SANITIZERS | HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | \
   HWY_SVE2_128 | HWY_RVV)
