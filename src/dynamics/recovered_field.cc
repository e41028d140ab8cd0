// Recovery of nodal values from superconvergent patches.
#include <cstdint>
#include <optional>
#include <vector>

#include "core/decompositions.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"

namespace tetraction {
namespace {

// Sums over the elements of a patch. r is the position of an element's centroid relative to the vertex, and
// s its values.
constexpr Index kCount = 0;    // Σ 1
constexpr Index kFirst = 1;    // Σ r
constexpr Index kSecond = 4;   // Σ r_x², r_x r_y, r_x r_z, r_y², r_y r_z, r_z²
constexpr Index kValues = 10;  // Σ s, and after it Σ r_x s, Σ r_y s, Σ r_z s

Index rows_of(Index values) {
  return kValues + 4 * values;
}

// What the position alone says of the polynomial of a patch.
struct Patch {
  Vector3 mean;     // of r
  Matrix3 inverse;  // of Σ (r − mean)(r − mean)ᵀ
  double count = 0.0;

  // The square of the factor from errors of the elements, independent of each other and of size 1, to
  // that of the polynomial at r.
  double amplification(const Vector3& r) const {
    return 1.0 / count + (r - mean).dot(inverse * (r - mean));
  }
};

// Nothing if centroids in a plane do not determine the polynomial.
std::optional<Patch> patch_of(const Matrix& sums, Index vertex) {
  const auto s = sums.col(vertex);
  Patch patch;
  patch.count = s[kCount];
  patch.mean = s.segment<3>(kFirst) / patch.count;
  Matrix3 second;
  second << s[kSecond], s[kSecond + 1], s[kSecond + 2], s[kSecond + 1], s[kSecond + 3],
      s[kSecond + 4], s[kSecond + 2], s[kSecond + 4], s[kSecond + 5];
  second -= patch.count * patch.mean * patch.mean.transpose();
  const SymmetricEigen3 eigen = symmetric_eigen(second);
  constexpr double kPlane = 1e-6;
  if (!(eigen.values[0] > kPlane * eigen.values[2])) return std::nullopt;
  patch.inverse =
      eigen.vectors * eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  return patch;
}

// The polynomial of the patch of a vertex at r.
Vector value_of(const Patch& patch, const Matrix& sums, Index vertex, const Vector3& r) {
  const Index values = (sums.rows() - kValues) / 4;
  const auto s = sums.col(vertex);
  const auto part = [&](Index k) { return s.segment(kValues + k * values, values); };
  const Vector mean = part(0) / patch.count;
  const Vector3 factors = patch.inverse * (r - patch.mean);
  Vector value = mean;
  for (Index k = 0; k < 3; ++k) {
    value += factors[k] * (part(k + 1) - patch.count * patch.mean[k] * mean);
  }
  return value;
}

Matrix patch_sums(const MechanicalSystem& system, const Matrix& field) {
  const RestState& rest = system.rest();
  Matrix sums = Matrix::Zero(rows_of(field.rows()), system.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Vector3 center = rest.center(e);
    for (const Index v : rest.nodes(e)) {
      const Vector3 r = center - rest.position(v);
      auto s = sums.col(v);
      s[kCount] += 1.0;
      s.segment<3>(kFirst) += r;
      Index k = kSecond;
      for (Index i = 0; i < 3; ++i) {
        for (Index j = i; j < 3; ++j) s[k++] += r[i] * r[j];
      }
      s.segment(kValues, field.rows()) += field.col(e);
      for (Index i = 0; i < 3; ++i) {
        s.segment(kValues + (i + 1) * field.rows(), field.rows()) += r[i] * field.col(e);
      }
    }
  }
  if (system.part() != nullptr) system.part()->add_shared(sums.data(), sums.rows());
  return sums;
}

// Gives the vertices without a patch of their own the mean of the polynomials of their neighbours. Each
// counts once for every common element, with the inverse of its amplification.
void take_from_neighbors(const MechanicalSystem& system, const Matrix& sums,
                         const std::vector<std::uint8_t>& has_own, Matrix& recovered) {
  const RestState& rest = system.rest();
  const Index rows = recovered.rows();
  Matrix means = Matrix::Zero(rows + 1, recovered.cols());
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) {
      if (has_own[static_cast<std::size_t>(v)] != 0) continue;
      for (const Index other : rest.nodes(e)) {
        if (has_own[static_cast<std::size_t>(other)] == 0) continue;
        const Patch patch = *patch_of(sums, other);
        const Vector3 r = rest.position(v) - rest.position(other);
        const double weight = 1.0 / patch.amplification(r);
        means.col(v).head(rows) += weight * value_of(patch, sums, other, r);
        means(rows, v) += weight;
      }
    }
  }
  if (system.part() != nullptr) system.part()->add_shared(means.data(), means.rows());
  for (Index v = 0; v < recovered.cols(); ++v) {
    if (means(rows, v) > 0.0) recovered.col(v) = means.col(v).head(rows) / means(rows, v);
  }
}

}  // namespace

Matrix recovered_field(const MechanicalSystem& system, const Matrix& element_field) {
  const Matrix sums = patch_sums(system, element_field);
  Matrix recovered = nodal_average(system, element_field);
  std::vector<std::uint8_t> has_own(static_cast<std::size_t>(recovered.cols()), 0);
  parallel_for(recovered.cols(), 512, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      // A polynomial that amplifies errors is an extrapolation.
      const std::optional<Patch> patch = patch_of(sums, v);
      if (!patch || patch->amplification(Vector3::Zero()) > 1.0) continue;
      has_own[static_cast<std::size_t>(v)] = 1;
      recovered.col(v) = value_of(*patch, sums, v, Vector3::Zero());
    }
  });
  take_from_neighbors(system, sums, has_own, recovered);
  return recovered;
}

}  // namespace tetraction
