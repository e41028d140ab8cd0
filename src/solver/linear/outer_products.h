// The part of a Hessian that consists of matrices of rank one.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "dynamics/nodal_volume/patch_gradients.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "vertex_groups.h"

namespace tetraction {

class NodalVolume;

/// Σ c b bᵀ over the outer products of nodal volumes (dynamics/nodal_volume/nodal_volume.h) and those of force
/// terms (HessianBlocks), in precision T. A vector has one record (x y z 0) per vertex in the order of
/// the places of some groups. It is stored as Σ σ v vᵀ with v = |c|^½ b and σ = ±1.
///
/// Those of the volume come first. The vectors are stored twice: product by product for v·x, and place by
/// place for the sums Σ σ v (v·x). Both loops then read what is together in memory
/// and write to what belongs to one thread, and are bitwise the same for any number of threads.
template <class T>
class OuterProducts {
 public:
  using Record = Eigen::Matrix<T, 4, 1>;

  /// `volume` may be null. Both must live longer.
  OuterProducts(const VertexGroups& groups, const NodalVolume* volume);

  /// Takes the outer products of the volume at x in this form, and those of `terms`.
  void set(const Positions& x, HessianForm form, const HessianBlocks& terms);
  bool empty() const { return signs_.empty(); }

  /// Computes all v·x. product() then gives the product of the matrix and x.
  void multiply(const AlignedVector<T>& x);
  /// The part of the product at a place.
  Record product(Index place) const {
    Record sum = Record::Zero();
    for_place(place, [&](std::size_t number, const auto& v) { sum += along_[number] * v; });
    return sum;
  }
  /// The block on the diagonal at a place.
  Matrix3 block(Index place) const;

  Index count() const { return static_cast<Index>(signs_.size()); }
  /// σ of a product.
  double sign(Index number) const {
    return static_cast<double>(signs_[static_cast<std::size_t>(number)]);
  }
  /// visit(place, v) for the vertices of a product.
  template <class Visit>
  void for_each(Index number, const Visit& visit) const {
    const auto i = static_cast<std::size_t>(number);
    for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) visit(place_[k], record(vectors_, k));
  }

 private:
  static Eigen::Map<const Record, Eigen::Aligned16> record(const AlignedVector<T>& field,
                                                           std::size_t i) {
    return Eigen::Map<const Record, Eigen::Aligned16>(field.data() + 4 * i);
  }
  template <class Visit>
  void for_place(Index place, const Visit& visit) const {
    const auto i = static_cast<std::size_t>(place);
    for (std::size_t k = place_begin_[i]; k < place_begin_[i + 1]; ++k) {
      visit(static_cast<std::size_t>(number_[k]), record(at_place_, k));
    }
  }
  bool has_pattern_of(const HessianBlocks& terms) const;
  void make_pattern(const HessianBlocks& terms);
  void set_terms(const HessianBlocks& terms);
  // Stores v in both places.
  void store(std::size_t index, const Record& v) {
    Eigen::Map<Record, Eigen::Aligned16>{vectors_.data() + 4 * index} = v;
    Eigen::Map<Record, Eigen::Aligned16>{at_place_.data() +
                                         4 * static_cast<std::size_t>(other_[index])} = v;
  }

  const VertexGroups& groups_;
  const NodalVolume* volume_;
  std::unique_ptr<PatchGradients<T>> gradients_;
  // The pattern. Products and entries of the volume's patches come first.
  bool has_pattern_ = false;
  std::vector<std::size_t> term_begin_;  // of the products of the terms that the pattern has
  std::vector<Index> term_vertices_;     // and their vertices
  std::vector<std::size_t> begin_;       // of each product in the next three
  std::vector<std::int32_t> place_;
  std::vector<std::int32_t> other_;       // index of the same vector in at_place_
  AlignedVector<T> vectors_;              // v
  std::vector<std::size_t> place_begin_;  // of each place in the next two
  std::vector<std::int32_t> number_;      // of the product
  AlignedVector<T> at_place_;             // v
  std::vector<T> roots_;                  // |c|^½ of each patch
  AlignedVector<T> signs_;                // σ of each product
  AlignedVector<T> along_;                // σ v·x
};

extern template class OuterProducts<float>;
extern template class OuterProducts<double>;

}  // namespace tetraction
