#include "single_precision_factor.h"

#include <cholmod.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <new>
#include <numeric>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// The next index in an array of floats at which a cache line begins if the array begins with one.
std::size_t aligned(std::size_t place) {
  constexpr std::size_t kLine = 16;
  return (place + kLine - 1) / kLine * kLine;
}

// Allocates uninitialised numbers, on large pages if the system has them. On small pages reading
// some hundred megabytes takes half as long again.
float* allocate_for_stream(std::size_t count) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t bytes = count * sizeof(float);
  const bool large = bytes >= 2 * kPage;
  const std::size_t alignment = large ? kPage : 64;
  void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  if (large) madvise(memory, bytes, MADV_HUGEPAGE);
  return static_cast<float*>(memory);
}

}  // namespace

// CHOLMOD's factor as a list of supernodes. The supernodes of a simplicial factor are found here.
class SinglePrecisionFactor::Source {
 public:
  explicit Source(const cholmod_factor& factor)
      : size_(static_cast<std::int32_t>(factor.n)),
        supernodal_(factor.is_super != 0),
        permutation_(static_cast<const int*>(factor.Perm)),
        values_(static_cast<const double*>(factor.x)) {
    if (factor.is_ll == 0 || factor.xtype != CHOLMOD_REAL || factor.itype != CHOLMOD_INT ||
        factor.minor != factor.n) {
      throw Error("Only a whole real factor L Lᵀ with int indices can be copied.");
    }
    if (supernodal_) {
      const auto* first = static_cast<const int*>(factor.super);
      first_.assign(first, first + factor.nsuper + 1);
      begin_ = static_cast<const int*>(factor.px);
      rows_begin_ = static_cast<const int*>(factor.pi);
      rows_ = static_cast<const int*>(factor.s);
    } else {
      begin_ = static_cast<const int*>(factor.p);
      rows_ = static_cast<const int*>(factor.i);
      count_ = static_cast<const int*>(factor.nz);
      // The rows of a column, without the first, are among those of its parent in the elimination
      // tree, which is the column of that first row. If their numbers agree, the rows are the same.
      for (std::int32_t j = 0; j < size_; ++j) {
        const bool joined =
            j > 0 && count_[j - 1] == count_[j] + 1 && rows_[begin_[j - 1] + 1] == j;
        if (!joined) first_.push_back(j);
      }
      first_.push_back(size_);
    }
  }

  std::int32_t size() const { return size_; }
  std::int32_t unknown(std::int32_t column) const { return permutation_[column]; }
  std::size_t supernode_count() const { return first_.size() - 1; }
  std::int32_t first_column(std::size_t s) const { return first_[s]; }
  std::int32_t end_column(std::size_t s) const { return first_[s + 1]; }
  std::int32_t columns(std::size_t s) const { return first_[s + 1] - first_[s]; }
  std::int32_t rows_below(std::size_t s) const {
    return supernodal_ ? rows_begin_[s + 1] - rows_begin_[s] - columns(s)
                       : count_[end_column(s) - 1] - 1;
  }
  // Columns of L, rising.
  const int* rows(std::size_t s) const {
    return rows_ + (supernodal_ ? rows_begin_[s] + columns(s) : begin_[end_column(s) - 1] + 1);
  }
  // Column `j` of a supernode from the diagonal down.
  const double* column(std::size_t s, std::int32_t j) const {
    if (!supernodal_) return values_ + begin_[first_column(s) + j];
    const std::ptrdiff_t height = rows_begin_[s + 1] - rows_begin_[s];
    return values_ + begin_[s] + j * (height + 1);
  }
  std::ptrdiff_t trapezoid(std::size_t s) const {
    return trapezoid_size(columns(s), rows_below(s));
  }

  // For every row the inverse of the power of two above its largest number.
  std::vector<double> inverse_scales() const {
    std::vector<double> largest(static_cast<std::size_t>(size_), 0.0);
    const auto raise = [&](std::int32_t row, double value) {
      double& l = largest[static_cast<std::size_t>(row)];
      l = std::max(l, std::abs(value));
    };
    for (std::size_t s = 0; s < supernode_count(); ++s) {
      const std::int32_t n = columns(s);
      const std::int32_t below = rows_below(s);
      const int* row = rows(s);
      for (std::int32_t j = 0; j < n; ++j) {
        const double* value = column(s, j);
        for (std::int32_t i = j; i < n; ++i) raise(first_column(s) + i, *value++);
        for (std::int32_t i = 0; i < below; ++i) raise(row[i], *value++);
      }
    }
    for (double& l : largest) {
      int exponent = 0;
      std::frexp(l, &exponent);
      l = std::ldexp(1.0, -exponent);
    }
    return largest;
  }

  // Finds the part of every supernode. A part is one or more whole subtrees, or the top, which
  // comes last. Returns the number of parts.
  std::int32_t deal(std::vector<std::int32_t>& part) const;

  // Copies a supernode in the layout of the kernels.
  void copy(std::size_t s, const double* scale, float* to) const;

 private:
  std::vector<std::int32_t> parents() const {
    std::vector<std::int32_t> of_column(static_cast<std::size_t>(size_));
    for (std::size_t s = 0; s < supernode_count(); ++s) {
      std::fill_n(of_column.begin() + first_column(s), columns(s), static_cast<std::int32_t>(s));
    }
    std::vector<std::int32_t> parent(supernode_count(), -1);
    for (std::size_t s = 0; s < parent.size(); ++s) {
      if (rows_below(s) > 0) parent[s] = of_column[static_cast<std::size_t>(*rows(s))];
    }
    return parent;
  }

  std::int32_t size_;
  bool supernodal_;
  const int* permutation_;
  const double* values_;
  std::vector<std::int32_t> first_;  // column of every supernode
  const int* begin_ = nullptr;       // of supernodes or columns in values_
  const int* rows_begin_ = nullptr;  // supernodal
  const int* rows_ = nullptr;
  const int* count_ = nullptr;  // simplicial
};

std::int32_t SinglePrecisionFactor::Source::deal(std::vector<std::int32_t>& part) const {
  // There are enough parts to keep several threads busy. Smaller parts would leave more to the top.
  constexpr std::ptrdiff_t kParts = 16;
  constexpr std::ptrdiff_t kLeast = 20000;  // numbers that are worth a task
  constexpr std::int32_t kTop = -1;
  const std::vector<std::int32_t> parent = parents();
  std::vector<std::ptrdiff_t> work(parent.size());
  std::ptrdiff_t total = 0;
  for (std::size_t s = 0; s < parent.size(); ++s) total += trapezoid(s);
  for (std::size_t s = 0; s < parent.size(); ++s) {  // children come before their parent
    work[s] += trapezoid(s);
    if (parent[s] >= 0) work[parent[s]] += work[s];
  }
  const std::ptrdiff_t most = std::max(total / kParts, kLeast);
  part.assign(parent.size(), kTop);
  std::int32_t count = 0;
  std::ptrdiff_t filled = most;
  for (std::size_t s = parent.size(); s-- > 0;) {
    const std::int32_t of_parent = parent[s] < 0 ? kTop : part[parent[s]];
    if (of_parent != kTop) {
      part[s] = of_parent;
    } else if (work[s] <= most) {
      if (filled + work[s] > most) {
        ++count;
        filled = 0;
      }
      filled += work[s];
      part[s] = count - 1;
    }
  }
  std::replace(part.begin(), part.end(), kTop, count);
  return count + 1;
}

void SinglePrecisionFactor::Source::copy(std::size_t s, const double* scale, float* to) const {
  const std::int32_t n = columns(s);
  const std::int32_t below = rows_below(s);
  const std::int32_t end = n + below;
  std::vector<double> scale_of_row(scale + first_column(s), scale + end_column(s));
  const int* row_below = rows(s);
  std::transform(row_below, row_below + below, std::back_inserter(scale_of_row),
                 [&](int row) { return scale[row]; });
  const auto number = [&](std::int32_t i, std::int32_t j) {  // of the trapezoid
    return column(s, j)[i - j] * scale_of_row[i];
  };
  const auto put_inverse = [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t j = first; j < last; ++j) {
      std::array<double, kBlockColumns> inverse{};  // column j of the triangle's
      for (std::int32_t i = j; i < last; ++i) {
        double sum = i == j ? 1.0 : 0.0;
        for (std::int32_t l = j; l < i; ++l) sum -= number(i, l) * inverse[l - first];
        inverse[i - first] = sum / number(i, i);
        *to++ = static_cast<float>(inverse[i - first]);
      }
    }
  };
  const auto put_rows = [&](std::int32_t first, std::int32_t last, std::int32_t row,
                            std::int32_t end_row) {
    for (; row < end_row; row += kTileRows) {
      const std::int32_t last_row = std::min<std::int32_t>(row + kTileRows, end_row);
      for (std::int32_t j = first; j < last; ++j) {
        const double* l = column(s, j) - j;
        for (std::int32_t i = row; i < last_row; ++i) {
          *to++ = static_cast<float>(l[i] * scale_of_row[i]);
        }
      }
    }
  };
  for (std::int32_t panel = 0; panel < n; panel += kPanelColumns) {
    const std::int32_t panel_end = std::min<std::int32_t>(panel + kPanelColumns, n);
    for (std::int32_t first = panel; first < panel_end; first += kBlockColumns) {
      const std::int32_t last = std::min<std::int32_t>(first + kBlockColumns, panel_end);
      put_inverse(first, last);
      put_rows(first, last, last, panel_end);
    }
    for (std::int32_t first = panel; first < panel_end; first += kBlockColumns) {
      put_rows(first, std::min<std::int32_t>(first + kBlockColumns, panel_end), panel_end, end);
    }
  }
}

void SinglePrecisionFactor::assign(const cholmod_factor_struct& factor) {
  const Source source(factor);
  std::vector<std::int32_t> part;
  parts_.assign(static_cast<std::size_t>(source.deal(part)), Part());
  std::vector<std::size_t> order(source.supernode_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return part[a] < part[b]; });
  const std::size_t old_count = value_count_;
  std::vector<std::int32_t> place(static_cast<std::size_t>(source.size()));
  arrange(source, order, part, place);
  connect(source, order, place);

  const std::vector<double> scale = source.inverse_scales();
  inverse_scale_.resize(scale.size());
  for (std::int32_t j = 0; j < source.size(); ++j) {
    inverse_scale_[source.unknown(j)] = scale[j];
  }
  if (!values_ || value_count_ != old_count) {
    values_.reset();
    values_.reset(allocate_for_stream(value_count_ + kTileRows));
    std::fill_n(values_.get() + value_count_, kTileRows, 0.0F);
  }
  std::vector<float*> begin;
  float* next = values_.get();
  for (const std::size_t s : order) {
    begin.push_back(next);
    next += source.trapezoid(s);
  }
  parallel_for(static_cast<Index>(order.size()), 16, [&](Index first, Index last) {
    for (Index k = first; k < last; ++k) source.copy(order[k], scale.data(), begin[k]);
  });
}

// Supernodes and columns in their order; `place` of the columns of L in it.
void SinglePrecisionFactor::arrange(const Source& source, const std::vector<std::size_t>& order,
                                    const std::vector<std::int32_t>& part,
                                    std::vector<std::int32_t>& place) {
  supernodes_.clear();
  unknown_.clear();
  value_count_ = 0;
  for (const std::size_t s : order) {
    Part& p = parts_[part[s]];
    if (p.supernode_count++ == 0) {
      p.first_supernode = supernodes_.size();
      p.values = value_count_;
      p.first_column = static_cast<std::int32_t>(unknown_.size());
    }
    p.columns += source.columns(s);
    supernodes_.push_back({source.columns(s), source.rows_below(s)});
    value_count_ += source.trapezoid(s);
    for (std::int32_t j = source.first_column(s); j < source.end_column(s); ++j) {
      place[j] = static_cast<std::int32_t>(unknown_.size());
      unknown_.push_back(source.unknown(j));
    }
    p.values_end = value_count_;
  }
}

// The rows below the supernodes as places in the vector of their part.
void SinglePrecisionFactor::connect(const Source& source, const std::vector<std::size_t>& order,
                                    const std::vector<std::int32_t>& place) {
  constexpr std::int32_t kUnseen = -1;
  rows_.clear();
  reach_.clear();
  const std::int32_t top_column = parts_.back().first_column;
  std::vector<std::int32_t> reached(place.size(), kUnseen);  // where in the part's vector
  std::size_t vectors = 0;
  for (Part& p : parts_) {
    p.rows = rows_.size();
    p.reach = reach_.size();
    std::int32_t length = p.columns;
    std::ptrdiff_t work = 0;
    for (std::size_t k = p.first_supernode; k < p.first_supernode + p.supernode_count; ++k) {
      work = std::max(work, trapezoid_work(supernodes_[k]));
      const int* row = source.rows(order[k]);
      for (std::int32_t i = 0; i < supernodes_[k].rows; ++i) {
        const std::int32_t at = place[static_cast<std::size_t>(row[i])];
        if (at < p.first_column + p.columns) {  // not of the top, or this is the top
          rows_.push_back(at - p.first_column);
          continue;
        }
        std::int32_t& where = reached[static_cast<std::size_t>(at)];
        if (where == kUnseen) {
          where = length++;
          reach_.push_back(at - top_column);
        }
        rows_.push_back(where);
      }
    }
    p.rows_end = rows_.size();
    p.reach_end = reach_.size();
    for (std::size_t k = p.reach; k < p.reach_end; ++k) {
      reached[top_column + reach_[k]] = kUnseen;
    }
    p.vector = vectors;
    p.work = aligned(p.vector + static_cast<std::size_t>(length));
    vectors = aligned(p.work + static_cast<std::size_t>(work));
  }
  vectors_.resize(vectors);
}

std::size_t SinglePrecisionFactor::bytes() const {
  const auto of = [](const auto& v) { return v.size() * sizeof(v[0]); };
  return value_count_ * sizeof(float) + of(supernodes_) + of(rows_) + of(reach_) + of(parts_) +
         of(unknown_) + of(inverse_scale_) + of(vectors_);
}

FactorPart SinglePrecisionFactor::view(const Part& p) const {
  return {supernodes_.data() + p.first_supernode,
          static_cast<std::ptrdiff_t>(p.supernode_count),
          values_.get() + p.values,
          values_.get() + p.values_end,
          rows_.data() + p.rows,
          rows_.data() + p.rows_end,
          p.columns};
}

template <class T>
void SinglePrecisionFactor::solve_in(const T* right, T* solution) {
  double largest = 0.0;
  for (std::size_t u = 0; u < unknown_.size(); ++u) {
    largest = std::max(largest, std::abs(static_cast<double>(right[u]) * inverse_scale_[u]));
  }
  int exponent = 0;
  std::frexp(largest, &exponent);
  exponent = std::max(exponent, std::numeric_limits<double>::min_exponent);
  const double shrink = std::ldexp(1.0, -exponent);
  const double grow = std::ldexp(1.0, exponent);

  const auto forward = [&](const Part& p) {
    const std::int32_t* unknown = unknown_.data() + p.first_column;
    float* x = vectors_.data() + p.vector;
    for (std::int32_t j = 0; j < p.columns; ++j) {
      const auto u = static_cast<std::size_t>(unknown[j]);
      x[j] += static_cast<float>(static_cast<double>(right[u]) * inverse_scale_[u] * shrink);
    }
    substitute_forward(view(p), x, vectors_.data() + p.work);
  };
  const auto backward = [&](const Part& p) {
    const std::int32_t* unknown = unknown_.data() + p.first_column;
    float* x = vectors_.data() + p.vector;
    substitute_backward(view(p), x, vectors_.data() + p.work);
    for (std::int32_t j = 0; j < p.columns; ++j) {
      const auto u = static_cast<std::size_t>(unknown[j]);
      solution[u] = static_cast<T>(static_cast<double>(x[j]) * inverse_scale_[u] * grow);
    }
  };
  // Calls body(reached number of the subtree, its place in the top).
  Part& top = parts_.back();
  float* top_x = vectors_.data() + top.vector;
  const auto exchange = [&](const Part& p, const auto& body) {
    float* x = vectors_.data() + p.vector + p.columns;
    for (std::size_t k = p.reach; k < p.reach_end; ++k) body(*x++, top_x[reach_[k]]);
  };
  const auto subtrees = static_cast<Index>(parts_.size()) - 1;
  const auto each_subtree = [&](const auto& body) {
    parallel_for(subtrees, 1, [&](Index begin, Index end) {
      for (Index k = begin; k < end; ++k) body(parts_[static_cast<std::size_t>(k)]);
    });
  };

  std::fill(vectors_.begin(), vectors_.end(), 0.0F);
  each_subtree(forward);
  for (Index k = 0; k < subtrees; ++k) {
    exchange(parts_[static_cast<std::size_t>(k)], [](float own, float& above) { above += own; });
  }
  forward(top);
  backward(top);
  each_subtree([&](const Part& p) {
    exchange(p, [](float& own, float above) { own = above; });
    backward(p);
  });
}

void SinglePrecisionFactor::solve(const Eigen::Ref<const Vector>& right,
                                  Eigen::Ref<Vector> solution) {
  solve_in(right.data(), solution.data());
}

void SinglePrecisionFactor::solve(const Eigen::Ref<const Eigen::VectorXf>& right,
                                  Eigen::Ref<Eigen::VectorXf> solution) {
  solve_in(right.data(), solution.data());
}

}  // namespace tetraction
