#include "free_modes.h"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/decompositions.h"
#include "fem/jointed_pieces.h"
#include "mode_construction.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// An orthonormal basis of the coefficients c with |columns c| ≤ limit |c|.
Matrix null_space(const Matrix& columns, double limit) {
  const Index n = columns.cols();
  if (n == 0) return Matrix(0, 0);
  const Eigen::HouseholderQR<Matrix> qr(columns);
  const Index rows = std::min(n, columns.rows());
  const Matrix r = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  // All right singular vectors, as the left ones of the transpose.
  const Matrix v = singular_vectors(r.transpose()).u;
  Matrix null(n, 0);
  for (Index j = 0; j < n; ++j) {
    if ((r * v.col(j)).norm() > limit) continue;
    null.conservativeResize(Eigen::NoChange, null.cols() + 1);
    null.rightCols<1>() = v.col(j);
  }
  return null;
}

// Another orthonormal basis of the same span, along the axes as far as possible.
Matrix along_axes(const Matrix& basis) {
  Matrix left = basis * basis.transpose();
  Matrix aligned(basis.rows(), basis.cols());
  for (Index j = 0; j < basis.cols(); ++j) {
    Index longest = 0;
    for (Index i = 1; i < left.cols(); ++i) {
      if (left.col(i).norm() > 1.001 * left.col(longest).norm()) longest = i;
    }
    aligned.col(j) = left.col(longest).normalized();
    left -= aligned.col(j) * (aligned.col(j).transpose() * left);
  }
  return aligned;
}

// The rigid motions of every part: three translations and three rotations about its centre of mass.
struct RigidMotions {
  Matrix fields;     // 3n × 6 parts, orthonormal with respect to the mass
  Matrix rotations;  // 3 × 6 parts: the angular velocities
};

RigidMotions rigid_motions(const ScaledStiffness& stiffness, const Vector& q,
                           const std::vector<std::vector<Index>>& parts) {
  const Vector masses = stiffness.momentum(Vector::Ones(q.size()));  // of every coordinate
  Vector arms = Vector::Zero(q.size());
  const auto count = static_cast<Index>(parts.size());
  RigidMotions motions{Matrix::Zero(q.size(), 6 * count), Matrix::Zero(3, 6 * count)};
  for (Index k = 0; k < count; ++k) {
    const std::vector<Index>& vertices = parts[static_cast<std::size_t>(k)];
    double total = 0.0;
    Vector3 center = Vector3::Zero();
    for (const Index v : vertices) {
      total += masses[3 * v];
      center += masses[3 * v] * vertex_block(q, v);
    }
    center /= total;
    for (const Index v : vertices) vertex_block(arms, v) = vertex_block(q, v) - center;
    const Vector weighted = stiffness.momentum(arms);
    Matrix3 moments = Matrix3::Zero();  // Σ a (M a)ᵀ
    for (const Index v : vertices) {
      moments +=
          Vector3(vertex_block(std::as_const(arms), v)) * vertex_block(weighted, v).transpose();
    }
    const Matrix3 inertia = moments.trace() * Matrix3::Identity() - moments;
    // Fields of the angular velocities U⁻¹ with inertia = UᵀU are orthonormal.
    const Matrix3 upper = inertia.llt().matrixU();
    const Matrix3 rates = upper.triangularView<Eigen::Upper>().solve(Matrix3::Identity());
    motions.rotations.middleCols<3>(6 * k + 3) = rates;
    for (const Index v : vertices) {
      const Vector3 arm = vertex_block(q, v) - center;
      for (int i = 0; i < 3; ++i) {
        motions.fields(3 * v + i, 6 * k + i) = 1.0 / std::sqrt(total);
        motions.fields.block<3, 1>(3 * v, 6 * k + 3 + i) = rates.col(i).cross(arm);
      }
    }
  }
  return motions;
}

// Motions in which pieces of a part turn against each other, and which the constraints of single vertices
// allow, orthonormal to each other and to `motions` with respect to the mass. They are free of strain only
// about the body at rest; elsewhere there are none.
Matrix mechanism_fields(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                        const Vector& q, const std::vector<std::vector<Index>>& parts,
                        const RigidMotions& motions) {
  Matrix fields(q.size(), 0);
  if (q != system.mesh().rest_positions()) return fields;
  Matrix known = motions.fields;
  for (std::vector<MeshPiece>& pieces : pieces_of_parts(system.mesh(), parts)) {
    if (pieces.size() < 2 || pieces.size() > JointedPieces::kMost) continue;
    const JointedPieces jointed(std::move(pieces), {}, q);
    const Matrix whole = jointed.whole(Vector3::Zero(), 1.0);
    const Matrix free = divide_motions(jointed.motions(system.coordinates()), whole).mechanism;
    for (Index j = 0; j < free.cols(); ++j) {
      Vector field = jointed.field(free.col(j));
      for (int pass = 0; pass < 2; ++pass) {
        field -= known * (known.transpose() * stiffness.momentum(field));
      }
      field /= std::sqrt(field.dot(stiffness.momentum(field)));
      for (Matrix* all : {&known, &fields}) {
        all->conservativeResize(Eigen::NoChange, all->cols() + 1);
        all->rightCols<1>() = field;
      }
    }
  }
  return fields;
}

// The sizes of the forces that terms add to at each vertex when the vertices move by displacements of
// these lengths, N.
Vector term_sizes(const HessianBlocks& terms, const Vector& lengths) {
  Vector sizes = Vector::Zero(lengths.size());
  for (Index v = 0; v < lengths.size(); ++v) sizes[v] = terms.diagonal(v).norm() * lengths[v];
  for (const HessianBlocks::Pair& pair : terms.pairs()) {
    const double size = pair.block.norm();
    sizes[pair.row] += size * lengths[pair.column];
    sizes[pair.column] += size * lengths[pair.row];
  }
  for (const HessianBlocks::Outer& outer : terms.outers()) {
    double sum = 0.0;
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      sum += terms.outer_vectors()[i].norm() * lengths[terms.outer_vertices()[i]];
    }
    for (std::size_t i = outer.begin; i < outer.end; ++i) {
      sizes[terms.outer_vertices()[i]] +=
          std::abs(outer.factor) * terms.outer_vectors()[i].norm() * sum;
    }
  }
  return sizes;
}

// The forces of the elements and of the terms of S at the positions of the modes.
struct ForcesOfState {
  Vector elastic;
  Vector sum;              // less forces that are in balance up to round-off
  double round_off = 0.0;  // of the elastic ones, N; 0 if there is no stress

  // The solver of equilibria takes forces for round-off up to the same size.
  ForcesOfState(const MechanicalSystem& system, const Vector& q, const ScaledStiffness& stiffness) {
    constexpr double kMargin = 100.0;
    double energy = 0.0;
    system.elastic_energy_and_gradient(q, energy, elastic);
    const double noise =
        kMargin * 0.5 * kEpsilon * std::sqrt(system.stiffness_sums(0.0).with_edges);
    if (elastic.norm() <= noise) {
      elastic.setZero();
    } else {
      round_off = noise;
    }
    sum = elastic + stiffness.terms_gradient();
    if (system.coordinates().restricted_norm(sum) <= noise) {
      sum.setZero();
      round_off = 0.0;
    }
  }
};

}  // namespace

FreeModes free_rigid_motions(const MechanicalSystem& system, const Vector& q,
                             const NormalModeOptions& options, const ScaledStiffness& stiffness,
                             const LinearisedEquations& equations, bool under_loads) {
  // These are no tolerances of find_free_motions() (simulation/facts/free_motions.cc), where it is said why.
  constexpr double kAllowed = 1e-11;
  constexpr double kResisted = 1e-9;
  constexpr std::size_t kMostParts = 32;
  const std::vector<std::vector<Index>> parts = connected_parts(system.rest());
  if (parts.size() > kMostParts) {
    throw InputError(fmt::format(
        "The mesh consists of {} parts that do not touch each other; modes are computed for up to "
        "{} of them. Take them one at a time.",
        parts.size(), kMostParts));
  }
  RigidMotions motions = rigid_motions(stiffness, q, parts);
  const Index of_parts = motions.fields.cols();
  const Matrix mechanisms = mechanism_fields(system, stiffness, q, parts, motions);
  motions.fields.conservativeResize(Eigen::NoChange, of_parts + mechanisms.cols());
  motions.fields.rightCols(mechanisms.cols()) = mechanisms;
  // The parts of the motions that the constraints hold, weighted by the mass.
  Matrix z(stiffness.size(), motions.fields.cols());
  Matrix missing(motions.fields.rows() + equations.count(), motions.fields.cols());
  for (Index j = 0; j < motions.fields.cols(); ++j) {
    z.col(j) = stiffness.scaled(stiffness.momentum(motions.fields.col(j)));
    Vector rest = motions.fields.col(j) - stiffness.displacements(z.col(j));
    for (Index i = 0; i < rest.size(); ++i) rest[i] *= std::sqrt(system.mass()[i / 3]);
    missing.col(j).head(rest.size()) = rest;
    missing.col(j).tail(equations.count()) =
        equations.h.transpose() * (equations.q.transpose() * z.col(j));
  }
  const Matrix allowed = null_space(missing, kAllowed);
  // K times a rotation ω × (q − c) is ω × f with the elastic forces f = ∇W(q), because W does not
  // change in a rotation. The forces −∇U of terms that a rotation does not change either turn with
  // the body: their stiffness gives ω × ∇U. Both are in balance at an equilibrium.
  const ForcesOfState forces(system, q, stiffness);
  const Vector& gradient = stiffness.terms_gradient();
  std::optional<SkewLoadStiffness> loads;
  if (under_loads) loads.emplace(system, q, options.time, options.load_factor);
  Matrix resistance(stiffness.size(), allowed.cols());
  Vector sizes(allowed.cols());
  for (Index j = 0; j < allowed.cols(); ++j) {
    const Vector field = motions.fields * allowed.col(j);
    Vector product = Vector::Zero(field.size());
    stiffness.terms().add_product(field, product);
    Vector size =
        term_sizes(stiffness.terms(), field.reshaped(3, system.vertex_count()).colwise().norm());
    if (loads) {
      const Vector more = loads->product(field);
      product += more;
      size += more.reshaped(3, system.vertex_count()).colwise().norm().transpose();
    }
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Index first = 6 * static_cast<Index>(k);
      const Vector3 rotation =
          motions.rotations.middleCols<6>(first) * allowed.col(j).segment<6>(first);
      for (const Index v : parts[k]) {
        const Vector3 turned = vertex_block(gradient, v);
        const Vector3 force = vertex_block(forces.sum, v);
        vertex_block(product, v) += rotation.cross(force) - rotation.cross(turned);
        size[v] += rotation.norm() * (turned.norm() + force.norm() + forces.round_off / kResisted);
      }
    }
    Vector scaled = stiffness.scaled(product);
    sizes[j] = size.cwiseQuotient(system.mass().cwiseSqrt()).norm();
    if (equations.count() > 0) {
      const Vector motion = equations.q.transpose() * (z * allowed.col(j));
      scaled += equations.q * (equations.curvature * motion);
      sizes[j] += (equations.curvature.cwiseAbs() * motion.cwiseAbs()).norm();
    }
    resistance.col(j) = equations.project(scaled);
  }
  const Vector units = (sizes.array() > 0.0).select(sizes.cwiseInverse(), 1.0);
  const Matrix free =
      allowed * units.asDiagonal() * null_space(resistance * units.asDiagonal(), kResisted);
  if (free.cols() == 0) return {Matrix(stiffness.size(), 0)};
  const Matrix basis = along_axes(Eigen::HouseholderQR<Matrix>(free).householderQ() *
                                  Matrix::Identity(free.rows(), free.cols()));
  constexpr double kTurns = 1e-6;
  FreeModes modes{z * basis};
  for (Index j = 0; j < basis.cols(); ++j) {
    modes.is_mechanism.push_back(basis.col(j).tail(mechanisms.cols()).norm() > kTurns);
  }
  return modes;
}

}  // namespace tetraction
