// Loops over the items of a surface, with results that do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "dynamics/contact/pairs/box_tree.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// The number of items that one thread looks at together.
inline constexpr Index kItemsOfPiece = 256;
/// The number of such pieces.
inline std::size_t piece_count(Index items) {
  return static_cast<std::size_t>((items + kItemsOfPiece - 1) / kItemsOfPiece);
}

/// Calls work(i, piece, found) for all items i, on all threads, those of a piece in one. `found` is an empty list, whose
/// memory is kept.
template <class Work>
void for_each_item(Index count, const Work& work) {
  parallel_for(static_cast<Index>(piece_count(count)), 1, [&](Index begin, Index end) {
    std::vector<Index> found;
    for (Index piece = begin; piece < end; ++piece) {
      const Index last = std::min(count, (piece + 1) * kItemsOfPiece);
      for (Index i = piece * kItemsOfPiece; i < last; ++i) {
        found.clear();
        work(i, static_cast<std::size_t>(piece), found);
      }
    }
  });
}

/// The pairs (i, j) of items i and what find(i, found) appends for them, in the order of i.
template <class Find>
std::vector<std::array<Index, 2>> gather_pairs(Index count, const Find& find) {
  std::vector<std::vector<std::array<Index, 2>>> parts(piece_count(count));
  for_each_item(count, [&](Index i, std::size_t piece, std::vector<Index>& found) {
    find(i, found);
    for (const Index j : found) parts[piece].push_back({i, j});
  });
  std::vector<std::array<Index, 2>> pairs;
  for (const auto& part : parts) pairs.insert(pairs.end(), part.begin(), part.end());
  return pairs;
}

/// The smallest of least(i, found) over all items, or `none` if it is smaller. `found` is work space.
template <class Least>
Index smallest_over_items(Index count, Index none, const Least& least) {
  std::vector<Index> parts(piece_count(count), none);
  for_each_item(count, [&](Index i, std::size_t piece, std::vector<Index>& found) {
    parts[piece] = std::min(parts[piece], least(i, found));
  });
  return parts.empty() ? none : *std::min_element(parts.begin(), parts.end());
}

/// The box of the ways of some vertices from one set of positions to another.
inline Box box_of_ways(std::span<const Index> vertices, const Vector& from, const Vector& to) {
  Box box;
  for (const Index i : vertices) {
    box.add(vertex_block(from, i));
    box.add(vertex_block(to, i));
  }
  return box;
}

/// The mean of vectors of all vertices, of which there is one at least.
inline Vector3 mean_of_vertices(const Vector& x) {
  Vector3 sum = Vector3::Zero();
  for (Index i = 0; i < x.size() / 3; ++i) sum += vertex_block(x, i);
  return sum / static_cast<double>(x.size() / 3);
}

/// Whether two vectors are equal.
inline bool same_numbers(const Vector& a, const Vector& b) {
  return a.size() == b.size() && (a.array() == b.array()).all();
}

}  // namespace tetraction
