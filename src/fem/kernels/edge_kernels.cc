#include "edge_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/edge_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "element_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kRecord = 4;
constexpr int kNodes = QuadraticPoints::kNodes;

template <class T>
struct Factors {
  static constexpr T kOwn =
      static_cast<T>(QuadraticPoints::kScale * (4.0 * QuadraticPoints::kFar - 1.0));
  static constexpr T kSum = static_cast<T>(QuadraticPoints::kScale * 4.0 * QuadraticPoints::kFar);
  static constexpr T kMore = static_cast<T>(QuadraticPoints::kScale * 4.0 *
                                            (QuadraticPoints::kNear - QuadraticPoints::kFar));
};

// The node that is next to point p, among those in the derivative D_j.
constexpr int next_to(int p, int j) {
  return p == j ? j : QuadraticPoints::middle(p, j);
}

// The products of two coefficients of a node that are not zero.
struct Products {
  int count = 0;
  int product[6] = {};                             // 11 22 33 12 13 23
  alignas(64) double factor[6][kBatchLanes] = {};  // in each lane that of its point
};

constexpr std::array<Products, kNodes> products_of_nodes() {
  constexpr int kFirst[6] = {0, 1, 2, 0, 0, 1};
  constexpr int kSecond[6] = {0, 1, 2, 1, 2, 2};
  std::array<Products, kNodes> result{};
  for (int a = 0; a < kNodes; ++a) {
    Products& own = result[static_cast<std::size_t>(a)];
    for (int m = 0; m < 6; ++m) {
      bool any = false;
      for (int lane = 0; lane < kBatchLanes; ++lane) {
        const int p = lane % QuadraticPoints::kPoints;
        const double factor = QuadraticPoints::coefficient(p, kFirst[m], a) *
                              QuadraticPoints::coefficient(p, kSecond[m], a);
        own.factor[own.count][lane] = factor;
        any = any || factor != 0.0;
      }
      if (any) own.product[own.count++] = m;
    }
  }
  return result;
}
constexpr std::array<Products, kNodes> kProducts = products_of_nodes();

// Adds the numbers of the points in these lanes, the first of which is `lane` of the batch, to the
// number of their elements.
template <std::size_t kLanes>
HWY_INLINE void add_points(const double* numbers, std::size_t lane, double* HWY_RESTRICT number) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    number[kDiagonalNumbers * ((lane + i) / QuadraticPoints::kPoints)] += numbers[i];
  }
}

template <class T>
HWY_NOINLINE void edges_of(std::span<const NodeRecords> elements, const T* HWY_RESTRICT nodes,
                           T* HWY_RESTRICT edges) {
  using Tag = hn::CappedTag<T, kRecord>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  const Vec own = hn::Set(tag, Factors<T>::kOwn);
  const Vec sum = hn::Set(tag, Factors<T>::kSum);
  const Vec more = hn::Set(tag, Factors<T>::kMore);
  for (const NodeRecords& records : elements) {
    for (std::size_t part = 0; part < kRecord; part += hn::MaxLanes(Tag())) {
      Vec x[kNodes];
      const Vec origin = hn::Load(tag, nodes + kRecord * records[0] + part);
      x[0] = hn::Zero(tag);
      for (int a = 1; a < kNodes; ++a) {
        x[a] = hn::Sub(hn::Load(tag, nodes + kRecord * records[static_cast<std::size_t>(a)] + part),
                       origin);
      }
      // s D_j is `base` and a term of the node that is next to the point.
      Vec base[4];
      for (int j = 0; j < 4; ++j) {
        const Vec others = hn::Add(hn::Add(x[QuadraticPoints::middle(j, (j + 1) % 4)],
                                           x[QuadraticPoints::middle(j, (j + 2) % 4)]),
                                   x[QuadraticPoints::middle(j, (j + 3) % 4)]);
        base[j] = hn::MulAdd(own, x[j], hn::Mul(sum, others));
      }
      T* HWY_RESTRICT to = edges + part;
      for (int p = 0; p < QuadraticPoints::kPoints; ++p) {
        const Vec first = hn::MulAdd(more, x[next_to(p, 0)], base[0]);
        for (int k = 1; k < 4; ++k, to += kRecord) {
          hn::Store(hn::Sub(hn::MulAdd(more, x[next_to(p, k)], base[k]), first), tag, to);
        }
      }
    }
    edges += kRecord * QuadraticPoints::kEdges;
  }
}

template <class T>
HWY_NOINLINE void add_forces(std::span<const NodeRecords> elements, const T* HWY_RESTRICT edges,
                             T* HWY_RESTRICT nodes) {
  using Tag = hn::CappedTag<T, kRecord>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  const Vec own = hn::Set(tag, Factors<T>::kOwn);
  const Vec sum = hn::Set(tag, Factors<T>::kSum);
  const Vec more = hn::Set(tag, Factors<T>::kMore);
  for (const NodeRecords& records : elements) {
    for (std::size_t part = 0; part < kRecord; part += hn::MaxLanes(Tag())) {
      const T* HWY_RESTRICT from = edges + part;
      Vec x[kNodes];  // first what is multiplied by `more`
      Vec base[4];
      for (Vec& v : x) v = hn::Zero(tag);
      for (Vec& v : base) v = hn::Zero(tag);
      for (int p = 0; p < QuadraticPoints::kPoints; ++p) {
        Vec all = hn::Zero(tag);
        for (int k = 1; k < 4; ++k, from += kRecord) {
          const Vec edge = hn::Load(tag, from);
          all = hn::Add(all, edge);
          base[k] = hn::Add(base[k], edge);
          x[next_to(p, k)] = hn::Add(x[next_to(p, k)], edge);
        }
        base[0] = hn::Sub(base[0], all);
        x[next_to(p, 0)] = hn::Sub(x[next_to(p, 0)], all);
      }
      for (int j = 0; j < 4; ++j) {
        x[j] = hn::MulAdd(own, base[j], hn::Mul(more, x[j]));
        for (int i = 0; i < j; ++i) {
          Vec& middle = x[QuadraticPoints::middle(i, j)];
          middle = hn::MulAdd(more, middle, hn::Mul(sum, hn::Add(base[i], base[j])));
        }
      }
      for (int a = 0; a < kNodes; ++a) {
        T* HWY_RESTRICT to = nodes + kRecord * records[static_cast<std::size_t>(a)] + part;
        hn::Store(hn::Add(hn::Load(tag, to), x[a]), tag, to);
      }
    }
    edges += kRecord * QuadraticPoints::kEdges;
  }
}

void diagonal_of_nodes(const double* HWY_RESTRICT matrices, double* HWY_RESTRICT diagonal) {
  using Tag = hn::CappedTag<double, kBatchLanes>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  constexpr std::size_t kLanes = hn::MaxLanes(Tag());
  // The products c_k c_l: 11 22 33 12 13 23, with the places of their blocks among the numbers of a
  // matrix. A symmetric block has xx xy xz yy yz zz.
  HWY_ALIGN double numbers[6 * 6 * kLanes];
  HWY_ALIGN double sums[kLanes];
  for (std::size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
    const auto number = [&](int i) HWY_ATTR {
      return hn::Load(tag, matrices + static_cast<std::size_t>(i) * kBatchLanes + lane);
    };
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 6; ++i) {
        hn::Store(number(6 * (k + 1) + i), tag,
                  numbers + static_cast<std::size_t>(6 * k + i) * kLanes);
      }
      constexpr int kRow[6] = {0, 0, 0, 1, 1, 2};
      constexpr int kColumn[6] = {0, 1, 2, 1, 2, 2};
      const int block = 24 + 9 * (3 + k);
      for (int i = 0; i < 6; ++i) {  // and the transpose
        hn::Store(hn::Add(number(block + 3 * kRow[i] + kColumn[i]),
                          number(block + 3 * kColumn[i] + kRow[i])),
                  tag, numbers + static_cast<std::size_t>(6 * (3 + k) + i) * kLanes);
      }
    }
    for (int a = 0; a < kNodes; ++a) {
      const Products& own = kProducts[static_cast<std::size_t>(a)];
      Vec total[6];
      for (Vec& v : total) v = hn::Zero(tag);
      for (int m = 0; m < own.count; ++m) {
        const auto product = static_cast<std::size_t>(own.product[m]);
        const Vec factor = hn::Load(tag, own.factor[m]);
        for (std::size_t i = 0; i < 6; ++i) {
          total[i] =
              hn::MulAdd(factor, hn::Load(tag, numbers + (6 * product + i) * kLanes), total[i]);
        }
      }
      constexpr std::size_t kPlace[6] = {0, 4, 5, 1, 6, 2};
      for (std::size_t i = 0; i < 6; ++i) {
        hn::Store(total[i], tag, sums);
        add_points<kLanes>(sums, lane, diagonal + 8 * static_cast<std::size_t>(a) + kPlace[i]);
      }
    }
  }
}

void edges_of_doubles(std::span<const NodeRecords> elements, const double* nodes, double* edges) {
  edges_of(elements, nodes, edges);
}
void edges_of_floats(std::span<const NodeRecords> elements, const float* nodes, float* edges) {
  edges_of(elements, nodes, edges);
}
void add_doubles(std::span<const NodeRecords> elements, const double* edges, double* nodes) {
  add_forces(elements, edges, nodes);
}
void add_floats(std::span<const NodeRecords> elements, const float* edges, float* nodes) {
  add_forces(elements, edges, nodes);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(edges_of_doubles);
HWY_EXPORT(edges_of_floats);
HWY_EXPORT(add_doubles);
HWY_EXPORT(add_floats);
HWY_EXPORT(diagonal_of_nodes);

void form_edges(std::span<const NodeRecords> elements, const double* nodes, double* edges) {
  HWY_DYNAMIC_DISPATCH(edges_of_doubles)(elements, nodes, edges);
}

void form_edges(std::span<const NodeRecords> elements, const float* nodes, float* edges) {
  HWY_DYNAMIC_DISPATCH(edges_of_floats)(elements, nodes, edges);
}

void add_edge_forces(std::span<const NodeRecords> elements, const double* edges, double* nodes) {
  HWY_DYNAMIC_DISPATCH(add_doubles)(elements, edges, nodes);
}

void add_edge_forces(std::span<const NodeRecords> elements, const float* edges, float* nodes) {
  HWY_DYNAMIC_DISPATCH(add_floats)(elements, edges, nodes);
}

void quadratic_diagonal(const double* matrices, double* diagonal) {
  std::fill_n(diagonal, kDiagonalNumbers * kBatchLanes / QuadraticPoints::kPoints, 0.0);
  HWY_DYNAMIC_DISPATCH(diagonal_of_nodes)(matrices, diagonal);
}

}  // namespace tetraction
#endif
