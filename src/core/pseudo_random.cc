#include "core/pseudo_random.h"

#include <cstdint>

namespace tetraction {

Vector pseudo_random(Index size) {
  // SplitMix64 (Steele, Lea & Flood 2014) gives the same numbers on every machine.
  Vector numbers(size);
  std::uint64_t state = 0;
  for (Index i = 0; i < size; ++i) {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    numbers[i] = static_cast<double>(static_cast<std::int64_t>(z)) * 0x1p-63;
  }
  return numbers;
}

}  // namespace tetraction
