#include "hilbert_order.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>
#include <utility>

namespace tetraction {
namespace {

constexpr int kBits = 21;

// Position along the curve of a cell: Skilling, "Programming the Hilbert curve" (2004).
std::uint64_t hilbert_key(std::array<std::uint32_t, 3> x) {
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1) {
    const std::uint32_t p = q - 1;
    for (std::uint32_t& xi : x) {
      if ((xi & q) != 0) {
        x[0] ^= p;
      } else {
        const std::uint32_t t = (x[0] ^ xi) & p;
        x[0] ^= t;
        xi ^= t;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t t = 0;
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1) {
    if ((x[2] & q) != 0) t ^= q - 1;
  }
  for (std::uint32_t& xi : x) xi ^= t;
  std::uint64_t key = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    for (const std::uint32_t xi : x) key = (key << 1) | ((xi >> bit) & 1U);
  }
  return key;
}

}  // namespace

std::vector<Index> hilbert_order(const Eigen::Matrix<float, 3, Eigen::Dynamic>& points) {
  if (points.cols() == 0) return {};
  const Eigen::Vector3f low = points.rowwise().minCoeff();
  const float extent = (points.rowwise().maxCoeff() - low).maxCoeff();
  const float scale = extent > 0.0F ? static_cast<float>((1U << kBits) - 1) / extent : 0.0F;
  std::vector<std::pair<std::uint64_t, Index>> keys(static_cast<std::size_t>(points.cols()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Index column = static_cast<Index>(i);
    std::array<std::uint32_t, 3> cell{};
    for (int k = 0; k < 3; ++k) {
      const float c = (points(k, column) - low[k]) * scale;
      cell[static_cast<std::size_t>(k)] =
          std::min(static_cast<std::uint32_t>(std::max(c, 0.0F)), (1U << kBits) - 1);
    }
    keys[i] = {hilbert_key(cell), column};
  }
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<Index> order(keys.size());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& k) { return k.second; });
  return order;
}

}  // namespace tetraction
