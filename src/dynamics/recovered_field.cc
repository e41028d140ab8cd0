// Recovery of nodal values from superconvergent patches.
#include <cstdint>
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

// One polynomial a + b·r for each row of the field at each vertex, with r from the vertex: the numbers a, and
// after them b_x, b_y and b_z of all rows.
struct Polynomials {
  Matrix numbers;
  std::vector<std::uint8_t> exists;  // at each vertex

  bool has(Index vertex) const { return exists[static_cast<std::size_t>(vertex)] != 0; }
};

// The polynomial that is nearest to the values of the patch of a vertex in the sum of squares. There is none
// if centroids in a plane do not determine it, or if its value at the vertex would be an extrapolation,
// with a larger error than that of single elements.
bool fit(const Matrix& sums, Index vertex, Eigen::Ref<Vector> numbers) {
  const Index rows = numbers.size() / 4;
  const auto s = sums.col(vertex);
  const double count = s[kCount];
  const Vector3 mean = s.segment<3>(kFirst) / count;
  Matrix3 second;
  second << s[kSecond], s[kSecond + 1], s[kSecond + 2], s[kSecond + 1], s[kSecond + 3],
      s[kSecond + 4], s[kSecond + 2], s[kSecond + 4], s[kSecond + 5];
  second -= count * mean * mean.transpose();
  const SymmetricEigen3 eigen = symmetric_eigen(second);
  constexpr double kPlane = 1e-6;
  if (!(eigen.values[0] > kPlane * eigen.values[2])) return false;
  const Matrix3 inverse =
      eigen.vectors * eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  if (1.0 / count + mean.dot(inverse * mean) > 1.0) return false;
  const Vector mean_value = s.segment(kValues, rows) / count;
  numbers.head(rows) = mean_value;
  for (Index i = 0; i < 3; ++i) {
    auto slope = numbers.segment((i + 1) * rows, rows);
    slope.setZero();
    for (Index k = 0; k < 3; ++k) {
      slope += inverse(i, k) *
               (s.segment(kValues + (k + 1) * rows, rows) - count * mean[k] * mean_value);
    }
    numbers.head(rows) -= mean[i] * slope;
  }
  return true;
}

// The polynomials of all vertices that have none yet and that `asks(v)` names, from their own patches.
template <class Asks>
void fit_patches(const Matrix& sums, const Asks& asks, Polynomials& polynomials) {
  parallel_for(sums.cols(), 512, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      if (polynomials.has(v) || !asks(v)) continue;
      polynomials.exists[static_cast<std::size_t>(v)] =
          fit(sums, v, polynomials.numbers.col(v)) ? 1 : 0;
    }
  });
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

// Gives the vertices without a polynomial the mean of those of their neighbours. Each counts once for every
// common element.
void take_from_neighbors(const MechanicalSystem& system, Polynomials& polynomials) {
  const RestState& rest = system.rest();
  const Index size = polynomials.numbers.rows();
  const Index rows = size / 4;
  Matrix sums = Matrix::Zero(size + 1, system.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) {
      if (polynomials.has(v)) continue;
      for (const Index other : rest.nodes(e)) {
        if (!polynomials.has(other)) continue;
        const auto numbers = polynomials.numbers.col(other);
        const Vector3 r = rest.position(v) - rest.position(other);
        sums.col(v).head(size) += numbers;
        for (Index i = 0; i < 3; ++i) {
          sums.col(v).head(rows) += r[i] * numbers.segment((i + 1) * rows, rows);
        }
        sums(size, v) += 1.0;
      }
    }
  }
  if (system.part() != nullptr) system.part()->add_shared(sums.data(), sums.rows());
  for (Index v = 0; v < sums.cols(); ++v) {
    if (sums(size, v) == 0.0) continue;
    polynomials.numbers.col(v) = sums.col(v).head(size) / sums(size, v);
    polynomials.exists[static_cast<std::size_t>(v)] = 1;
  }
}

// 0 for the vertices inside the body.
Vector surface_marks(const MechanicalSystem& system) {
  Vector marks = Vector::Zero(system.vertex_count());
  for (const auto& face : boundary_faces(system.mesh())) {
    for (const Index v : face) marks[v] = 1.0;
  }
  add_shared(system.part(), marks, 1);
  return marks;
}

}  // namespace

Matrix recovered_field(const MechanicalSystem& system, const Matrix& element_field) {
  const Matrix sums = patch_sums(system, element_field);
  const Vector marks = surface_marks(system);
  Polynomials polynomials;
  polynomials.numbers = Matrix::Zero(4 * element_field.rows(), system.vertex_count());
  polynomials.exists.assign(static_cast<std::size_t>(system.vertex_count()), 0);
  // Patches that surround their vertex have the higher order. From them the faces of the body take theirs, from
  // these its edges, and from these its corners.
  fit_patches(
      sums, [&](Index v) { return marks[v] == 0.0; }, polynomials);
  constexpr int kSweeps = 3;
  for (int i = 0; i < kSweeps; ++i) take_from_neighbors(system, polynomials);
  // Where the body is one element thick, there are patches on its surface only.
  fit_patches(
      sums, [](Index) { return true; }, polynomials);
  take_from_neighbors(system, polynomials);
  Matrix recovered = nodal_average(system, element_field);
  for (Index v = 0; v < recovered.cols(); ++v) {
    if (polynomials.has(v)) recovered.col(v) = polynomials.numbers.col(v).head(recovered.rows());
  }
  return recovered;
}

}  // namespace tetraction
