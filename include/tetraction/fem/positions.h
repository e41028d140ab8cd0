// Current positions, given as one field or as the sum of two.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The current positions x of all vertices (3 per vertex, m). The object refers to the fields that
/// it is made of and is meant for one call.
///
/// A sum x = origin + displacement keeps more digits than one field does. The element loops need the
/// differences of the positions of an element's nodes. With both parts taken separately,
/// (o_a − o_b) + (u_a − u_b), the round-off is ε times the length of the edge plus ε|u|, instead of
/// ε|x|. This matters for slender and thin bodies, whose forces are small differences of large
/// stresses.
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
