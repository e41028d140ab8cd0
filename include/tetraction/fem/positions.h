// Current positions, given as one field or as the sum of two.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The current positions x of all vertices (3 per vertex, m). The object refers to the fields that
/// it is made of and is meant for one call.
///
/// A sum x = origin + displacement keeps more digits than one field does. An element needs the
/// differences of its nodes' positions. Taken part by part, (o_a − o_b) + (u_a − u_b), they carry
/// an error of ε times the edge and of ε|u|, instead of ε|x|. Forces of slender and thin bodies,
/// which are small differences of large stresses, would otherwise drown in the round-off of
/// positions.
class Positions {
 public:
  /// x = q.
  Positions(const Vector& q) : origin_(q) {}  // NOLINT(google-explicit-constructor)
  /// x = origin + displacement, both of the same length.
  Positions(const Vector& origin, const Vector& displacement)
      : origin_(origin), displacement_(&displacement) {}

  const Vector& origin() const { return origin_; }
  /// Null if x is the origin itself.
  const Vector* displacement() const { return displacement_; }
  Index size() const { return origin_.size(); }

 private:
  const Vector& origin_;
  const Vector* displacement_ = nullptr;
};

}  // namespace tetraction
