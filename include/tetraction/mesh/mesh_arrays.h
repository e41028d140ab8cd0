// Positions and tetrahedra as arrays of numbers. There are views of such arrays, and containers that
// either own their items or view an array of the caller.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Iterator over the items of a view. An item is returned by value.
template <class View>
class ViewIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = typename View::value_type;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = value_type;

  ViewIterator(const View& view, std::size_t index) : view_(view), index_(index) {}
  value_type operator*() const { return view_[index_]; }
  ViewIterator& operator++() {
    ++index_;
    return *this;
  }
  ViewIterator operator++(int) { return {view_, index_++}; }
  bool operator==(const ViewIterator& other) const { return index_ == other.index_; }

 private:
  View view_;
  std::size_t index_;
};

/// Positions of vertices, m, in an array x0 y0 z0 x1 y1 z1 … that must live longer.
class VertexView {
 public:
  using value_type = Vector3;

  VertexView() = default;
  /// Three numbers per vertex.
  explicit VertexView(std::span<const double> numbers)
      : numbers_(numbers.data()), size_(numbers.size() / 3) {}
  explicit VertexView(const std::vector<Vector3>& items)
      : numbers_(items.empty() ? nullptr : items.front().data()), size_(items.size()) {}

  std::size_t size() const { return size_; }
  const double* data() const { return numbers_; }
  Vector3 operator[](std::size_t vertex) const {
    return Eigen::Map<const Vector3>(numbers_ + 3 * vertex);
  }

 private:
  const double* numbers_ = nullptr;
  std::size_t size_ = 0;
};

/// The vertices of tetrahedra, four each, in an array of 32- or 64-bit numbers that must live
/// longer.
class TetrahedronView {
 public:
  using value_type = std::array<Index, 4>;

  TetrahedronView() = default;
  /// Four numbers per tetrahedron.
  explicit TetrahedronView(std::span<const std::int32_t> numbers)
      : narrow_(numbers.data()), size_(numbers.size() / 4) {}
  explicit TetrahedronView(std::span<const std::int64_t> numbers)
      : wide_(numbers.data()), size_(numbers.size() / 4) {}
  explicit TetrahedronView(const std::vector<value_type>& items)
      : wide_(items.empty() ? nullptr : items.front().data()), size_(items.size()) {}

  std::size_t size() const { return size_; }
  /// The address of the first number.
  const void* data() const {
    return narrow_ != nullptr ? static_cast<const void*>(narrow_) : wide_;
  }
  value_type operator[](std::size_t tetrahedron) const {
    return narrow_ != nullptr ? nodes(narrow_ + 4 * tetrahedron) : nodes(wide_ + 4 * tetrahedron);
  }

 private:
  template <class Number>
  static value_type nodes(const Number* n) {
    return {n[0], n[1], n[2], n[3]};
  }

  const std::int32_t* narrow_ = nullptr;
  const std::int64_t* wide_ = nullptr;
  std::size_t size_ = 0;
};

/// A container that either owns its items or views an array of the caller. A viewed array must
/// live longer than the container and all its copies, because a copy of a view is a view. Both
/// kinds are read in the same way. own() gives access for changes.
template <class View>
class MeshArray {
 public:
  using value_type = typename View::value_type;
  using iterator = ViewIterator<View>;
  using const_iterator = iterator;

  MeshArray() = default;
  explicit MeshArray(const View& viewed) : viewed_(viewed) {}

  bool is_view() const { return viewed_.has_value(); }
  View view() const { return viewed_ ? *viewed_ : View(items_); }
  std::size_t size() const { return view().size(); }
  bool empty() const { return size() == 0; }
  // The values are const, so that an assignment to such a copy does not compile.
  const value_type operator[](std::size_t i) const { return view()[i]; }
  const value_type front() const { return view()[0]; }
  const value_type back() const { return view()[size() - 1]; }
  iterator begin() const { return {view(), 0}; }
  iterator end() const { return {view(), size()}; }

  /// Gives access to the container's own items, for changes. A view is copied first, so that the
  /// caller's array stays as it is.
  std::vector<value_type>& own() {
    if (viewed_) {
      items_.assign(begin(), end());
      viewed_.reset();
    }
    return items_;
  }

  friend bool operator==(const MeshArray& a, const MeshArray& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (a[i] != b[i]) return false;
    }
    return true;
  }

 private:
  std::vector<value_type> items_;
  std::optional<View> viewed_;
};

using VertexArray = MeshArray<VertexView>;
using TetrahedronArray = MeshArray<TetrahedronView>;

}  // namespace tetraction
