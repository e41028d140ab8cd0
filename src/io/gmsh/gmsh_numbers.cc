#include "gmsh_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

namespace tetraction {

template <class Number>
Number GmshNumbers::bytes(const char* wanted) {
  if (in_.remaining() < sizeof(Number)) {
    in_.fail(fmt::format("the file ends where {} is expected: it is truncated.", wanted));
  }
  Number value;
  std::memcpy(&value, in_.text().data() + in_.position(), sizeof(Number));
  in_.set_position(in_.position() + sizeof(Number));
  if (swap_) {
    auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(value);
    std::reverse(raw.begin(), raw.end());
    value = std::bit_cast<Number>(raw);
  }
  return value;
}

void GmshNumbers::begin_binary_file() {
  in_.skip_line();
  in_.count_bytes();
  binary_ = true;
  const auto one = bytes<std::int32_t>("the byte-order mark");
  if (one == 0x01000000) {
    swap_ = true;
  } else if (one != 1) {
    in_.fail("the byte-order mark is not 1: the file is broken.");
  }
}

std::int64_t GmshNumbers::int32(const char* wanted) {
  if (binary_) return bytes<std::int32_t>(wanted);
  const std::int64_t value = in_.integer(wanted);
  using Limits = std::numeric_limits<std::int32_t>;
  if (value < Limits::min() || value > Limits::max()) {
    in_.fail(fmt::format("{} is not {} (an integer of 32 bits).", value, wanted));
  }
  return value;
}

std::int64_t GmshNumbers::size(const char* wanted) {
  return binary_ ? static_cast<std::int64_t>(bytes<std::uint64_t>(wanted)) : in_.integer(wanted);
}

double GmshNumbers::real(const char* wanted) {
  return binary_ ? bytes<double>(wanted) : in_.real(wanted);
}

}  // namespace tetraction
