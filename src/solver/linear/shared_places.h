// Sums at the vertices that several parts of a body have.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "vertex_groups.h"

namespace tetraction {

/// The places of the vertices of a part of a body that other parts have, too. Without parts there are none.
class SharedPlaces {
 public:
  /// Keeps references to both.
  SharedPlaces(const MechanicalSystem& system, const VertexGroups& groups)
      : system_(system), groups_(groups) {
    const MeshPart* part = system.part();
    if (part == nullptr) return;
    is_in_group_.assign(static_cast<std::size_t>(groups.count_with_copies()), false);
    is_shared_.assign(groups.order().size(), 0);
    sums_.setZero(system.dof_count());
    for (Index g = 0; g < groups.count_with_copies(); ++g) {
      for (Index i = groups.begin(g); i < groups.end(g); ++i) {
        if (!std::binary_search(part->shared_vertices.begin(), part->shared_vertices.end(),
                                groups.vertex(i))) {
          continue;
        }
        places_.push_back(i);
        is_in_group_[static_cast<std::size_t>(g)] = true;
        is_shared_[static_cast<std::size_t>(i)] = 1;
      }
    }
  }

  const std::vector<Index>& places() const { return places_; }
  bool are_in_group(Index group) const {
    return !is_in_group_.empty() && is_in_group_[static_cast<std::size_t>(group)];
  }
  bool contains(Index place) const { return is_shared_[static_cast<std::size_t>(place)] != 0; }

  /// Adds the records (x y z 0) own(place) over all parts. Collective.
  template <class Own>
  void add(const Own& own) {
    for (const Index i : places_) {
      vertex_block(sums_, groups_.vertex(i)) = own(i).template head<3>().template cast<double>();
    }
    add_shared(system_.part(), sums_, 3);
  }
  /// The sum at a shared place.
  template <class T>
  Eigen::Matrix<T, 4, 1> sum(Index place) const {
    const Index v = groups_.vertex(place);
    return Eigen::Vector4d(sums_[3 * v], sums_[3 * v + 1], sums_[3 * v + 2], 0.0)
        .template cast<T>();
  }

 private:
  const MechanicalSystem& system_;
  const VertexGroups& groups_;
  std::vector<Index> places_;
  std::vector<std::uint8_t> is_shared_;  // of each place
  std::vector<bool> is_in_group_;
  Vector sums_;  // 3 per vertex
};

}  // namespace tetraction
