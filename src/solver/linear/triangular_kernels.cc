#include "triangular_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/linear/triangular_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kTileRows>;
using V = hn::Vec<D>;
constexpr std::ptrdiff_t kLanes = hn::MaxLanes(D());

// Memory is fast only if long ranges are read upwards. The backward solve reads upwards within a
// panel only. If panels are short, a group of them is first read upwards into the second-level
// cache.
constexpr std::ptrdiff_t kLongPanel = 32 * 1024;  // numbers
constexpr std::ptrdiff_t kGroup = 64 * 1024;

HWY_INLINE void fetch(const float* begin, const float* end) {
  constexpr std::ptrdiff_t kLine = 16;
  for (; begin < end; begin += kLine) static_cast<void>(*static_cast<const volatile float*>(begin));
}

// f(k) with k the number of columns of a block, known to the compiler.
template <class F>
HWY_INLINE void with_columns(std::ptrdiff_t columns, const F& f) {
  static_assert(kBlockColumns == 8);
  switch (columns) {
    case 1:
      return f(std::integral_constant<int, 1>());
    case 2:
      return f(std::integral_constant<int, 2>());
    case 3:
      return f(std::integral_constant<int, 3>());
    case 4:
      return f(std::integral_constant<int, 4>());
    case 5:
      return f(std::integral_constant<int, 5>());
    case 6:
      return f(std::integral_constant<int, 6>());
    case 7:
      return f(std::integral_constant<int, 7>());
    default:
      return f(std::integral_constant<int, 8>());
  }
}

// x ← T⁻¹ x; `inverse` is T⁻¹. Returns its end.
template <int kColumns>
HWY_INLINE const float* solve_triangle(const float* HWY_RESTRICT inverse, float* HWY_RESTRICT x) {
  float result[kColumns] = {};
  for (int j = 0; j < kColumns; ++j) {
    for (int i = j; i < kColumns; ++i) result[i] += *inverse++ * x[j];
  }
  for (int j = 0; j < kColumns; ++j) x[j] = result[j];
  return inverse;
}

// x ← T⁻ᵀ x.
template <int kColumns>
HWY_INLINE void solve_triangle_transposed(const float* HWY_RESTRICT inverse,
                                          float* HWY_RESTRICT x) {
  float result[kColumns] = {};
  for (int j = 0; j < kColumns; ++j) {
    for (int i = j; i < kColumns; ++i) result[j] += *inverse++ * x[i];
  }
  for (int j = 0; j < kColumns; ++j) x[j] = result[j];
}

// y ← y − B x, B the rows of a block. Returns the end of B.
template <int kColumns>
HWY_INLINE const float* subtract_product(const float* HWY_RESTRICT b, std::ptrdiff_t rows,
                                         const float* HWY_RESTRICT x, float* HWY_RESTRICT y) {
  const D d;
  V xs[kColumns];
  for (int j = 0; j < kColumns; ++j) xs[j] = hn::Set(d, x[j]);
  const auto vector = [&](std::ptrdiff_t stride, std::ptrdiff_t i) HWY_ATTR {
    V sum = hn::LoadU(d, y + i);
    for (int j = 0; j < kColumns; ++j) {
      sum = hn::NegMulAdd(hn::LoadU(d, b + j * stride + i), xs[j], sum);
    }
    return sum;
  };
  for (; rows >= kTileRows; rows -= kTileRows) {
    for (std::ptrdiff_t i = 0; i < kTileRows; i += kLanes)
      hn::StoreU(vector(kTileRows, i), d, y + i);
    b += kColumns * kTileRows;
    y += kTileRows;
  }
  // The lanes behind the last row have read what follows.
  for (std::ptrdiff_t i = 0; i < rows; i += kLanes) {
    const auto valid = hn::FirstN(d, static_cast<size_t>(rows - i));
    hn::StoreU(hn::IfThenElse(valid, vector(rows, i), hn::LoadU(d, y + i)), d, y + i);
  }
  return b + kColumns * rows;
}

// x ← x − Bᵀ y. Returns the end of B.
template <int kColumns>
HWY_INLINE const float* subtract_transposed(const float* HWY_RESTRICT b, std::ptrdiff_t rows,
                                            const float* HWY_RESTRICT y, float* HWY_RESTRICT x) {
  const D d;
  V sums[kColumns];
  for (int j = 0; j < kColumns; ++j) sums[j] = hn::Zero(d);
  const auto add = [&](std::ptrdiff_t stride, std::ptrdiff_t i, V yi) HWY_ATTR {
    for (int j = 0; j < kColumns; ++j) {
      sums[j] = hn::MulAdd(hn::LoadU(d, b + j * stride + i), yi, sums[j]);
    }
  };
  for (; rows >= kTileRows; rows -= kTileRows) {
    for (std::ptrdiff_t i = 0; i < kTileRows; i += kLanes) add(kTileRows, i, hn::LoadU(d, y + i));
    b += kColumns * kTileRows;
    y += kTileRows;
  }
  for (std::ptrdiff_t i = 0; i < rows; i += kLanes) {
    const auto valid = hn::FirstN(d, static_cast<size_t>(rows - i));
    add(rows, i, hn::IfThenElseZero(valid, hn::LoadU(d, y + i)));
  }
  for (int j = 0; j < kColumns; ++j) x[j] -= hn::GetLane(hn::SumOfLanes(d, sums[j]));
  return b + kColumns * rows;
}

HWY_INLINE std::ptrdiff_t block_width(std::ptrdiff_t panel_columns, std::ptrdiff_t j) {
  return std::min(kBlockColumns, panel_columns - j);
}

// One panel: w has its columns, then `below` rows. Returns the panel's end.
HWY_INLINE const float* panel_forward(const float* values, std::ptrdiff_t columns,
                                      std::ptrdiff_t below, float* w) {
  for (std::ptrdiff_t j = 0; j < columns; j += kBlockColumns) {
    with_columns(block_width(columns, j), [&](auto k) HWY_ATTR {
      values = solve_triangle<k>(values, w + j);
      values = subtract_product<k>(values, columns - j - k, w + j, w + j + k);
    });
  }
  for (std::ptrdiff_t j = 0; j < columns; j += kBlockColumns) {
    with_columns(block_width(columns, j), [&](auto k) HWY_ATTR {
      values = subtract_product<k>(values, below, w + j, w + columns);
    });
  }
  return values;
}

// The same backwards: takes the panel's end and returns its begin.
HWY_INLINE const float* panel_backward(const float* values, std::ptrdiff_t columns,
                                       std::ptrdiff_t below, float* w) {
  values -= columns * below;
  const float* rows = values;
  for (std::ptrdiff_t j = 0; j < columns; j += kBlockColumns) {
    with_columns(block_width(columns, j), [&](auto k) HWY_ATTR {
      rows = subtract_transposed<k>(rows, below, w + columns, w + j);
    });
  }
  for (std::ptrdiff_t j = (columns - 1) / kBlockColumns * kBlockColumns; j >= 0;
       j -= kBlockColumns) {
    with_columns(block_width(columns, j), [&](auto k) HWY_ATTR {
      const std::ptrdiff_t inside = columns - j - k;
      values -= k * inside;
      subtract_transposed<k>(values, inside, w + j + k, w + j);
      values -= k * (k + 1) / 2;
      solve_triangle_transposed<k>(values, w + j);
    });
  }
  return values;
}

void substitute_forward(const FactorPart& part, float* HWY_RESTRICT x, float* HWY_RESTRICT work) {
  const float* values = part.values;
  const std::int32_t* rows = part.rows;
  float* own = x;
  for (std::ptrdiff_t s = 0; s < part.supernode_count; ++s) {
    const std::ptrdiff_t columns = part.supernodes[s].columns;
    const std::ptrdiff_t below = part.supernodes[s].rows;
    std::copy_n(own, columns, work);
    std::fill_n(work + columns, below, 0.0F);
    for (std::ptrdiff_t j = 0; j < columns; j += kPanelColumns) {
      const std::ptrdiff_t width = std::min(kPanelColumns, columns - j);
      values = panel_forward(values, width, columns - j - width + below, work + j);
    }
    std::copy_n(work, columns, own);
    for (std::ptrdiff_t i = 0; i < below; ++i) x[rows[i]] += work[columns + i];
    rows += below;
    own += columns;
  }
}

void substitute_backward(const FactorPart& part, float* HWY_RESTRICT x, float* HWY_RESTRICT work) {
  const float* values = part.values_end;
  const float* fetched = values;
  const std::int32_t* rows = part.rows_end;
  float* own = x + part.columns;
  for (std::ptrdiff_t s = part.supernode_count; s-- > 0;) {
    const std::ptrdiff_t columns = part.supernodes[s].columns;
    const std::ptrdiff_t below = part.supernodes[s].rows;
    rows -= below;
    own -= columns;
    std::copy_n(own, columns, work);
    for (std::ptrdiff_t i = 0; i < below; ++i) work[columns + i] = x[rows[i]];
    for (std::ptrdiff_t j = (columns - 1) / kPanelColumns * kPanelColumns; j >= 0;
         j -= kPanelColumns) {
      const std::ptrdiff_t width = std::min(kPanelColumns, columns - j);
      const std::ptrdiff_t size = trapezoid_size(width, columns - j - width + below);
      if (size < kLongPanel && values - size < fetched) {
        const float* next = std::max(part.values, values - kGroup);
        fetch(next, std::min(fetched, values));
        fetched = next;
      }
      values = panel_backward(values, width, columns - j - width + below, work + j);
    }
    std::copy_n(work, columns, own);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(substitute_forward);
HWY_EXPORT(substitute_backward);

void substitute_forward(const FactorPart& part, float* x, float* work) {
  HWY_DYNAMIC_DISPATCH(substitute_forward)(part, x, work);
}

void substitute_backward(const FactorPart& part, float* x, float* work) {
  HWY_DYNAMIC_DISPATCH(substitute_backward)(part, x, work);
}

}  // namespace tetraction
#endif
