#include "tetraction/solver/normal_modes.h"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>

#include "core/decompositions.h"
#include "fem/connected_parts.h"
#include "fem/jointed_pieces.h"
#include "lowest_eigenpairs.h"
#include "small_motions.h"
#include "tetraction/core/error.h"
#include "unsymmetric_modes.h"

namespace tetraction {
namespace {

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();

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
        kMargin * 0.5 * kRoundOff * std::sqrt(system.stiffness_sums(0.0).with_edges);
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

// Modes without stiffness, in the coordinates of S.
struct FreeModes {
  Matrix vectors;                    // orthonormal columns
  std::vector<bool> is_mechanism{};  // whether pieces turn against each other, for each column
};

// Rigid motions of the body, and of the pieces of a mechanism, that the constraints allow and that meet no
// stiffness. Whether a motion is free follows from the constraints and from the terms that could
// resist it, each compared with its own size. The elements do not resist it, so that their stiffness
// does not matter.
FreeModes free_rigid_motions(const MechanicalSystem& system, const Vector& q,
                             const NormalModeOptions& options, const ScaledStiffness& stiffness,
                             const LinearisedEquations& equations, bool under_loads) {
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
  // What the constraints keep from moving, weighted by the mass.
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

// (c/L)² with the highest wave speed c and the diagonal L of the body, 1/s².
double waves_across(const MechanicalSystem& system) {
  double fastest = 0.0;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    fastest = std::max(fastest, wave_speed(system.lame(e), system.density(e)));
  }
  const Vector rest = system.mesh().rest_positions();
  const auto corners = rest.reshaped(3, system.vertex_count());
  const double length = (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).norm();
  return fastest * fastest / (length * length);
}

// What round-off leaves of eigenvalues.
struct RoundOff {
  double largest = 0.0;  // of S
  double turning = 0.0;  // (c/L)² with the wave speed c and the size L of the body, 1/s²
  double beyond = std::numeric_limits<double>::infinity();  // |ω²| that no mode left out is below

  // The part of an eigenvector that belongs to modes that were left out has changed ω² by this part.
  // S as a matrix, which gives the eigenvectors, has an error of about ε max S_ii.
  double of_vector(double omega_squared) const {
    const double error = kRoundOff * largest;
    if (error == 0.0 || std::isinf(beyond)) return 0.0;
    return (error / std::abs(omega_squared)) * (error / beyond);
  }
  // The relative error of a frequency.
  double of_frequency(double omega_squared) const {
    constexpr double kProduct = 4.0;
    if (omega_squared == 0.0) return 1.0;
    const double size = std::abs(omega_squared);
    // Strains have round-off of displacements. Stresses have that of F = 1, which rotations feel.
    const double product = kProduct * kRoundOff * (std::sqrt(largest / size) + turning / size);
    return std::min(1.0, 0.5 * (product + of_vector(omega_squared)));
  }
};

// The eigenpairs of S + Q D Qᵀ in the space of these vectors (Rayleigh–Ritz), ascending. The products
// with S have far less round-off than the eigenvalues that an iteration with a factor of S finds.
std::vector<Eigenpair> sharpened(const ScaledStiffness& stiffness,
                                 const LinearisedEquations& equations,
                                 const std::vector<Eigenpair>& pairs) {
  const auto count = static_cast<Index>(pairs.size());
  Matrix vectors(stiffness.size(), count);
  Matrix images(stiffness.size(), count);
  for (Index j = 0; j < count; ++j) {
    Vector z = pairs[static_cast<std::size_t>(j)].vector;
    for (int pass = 0; pass < 2; ++pass) {
      z -= vectors.leftCols(j) * (vectors.leftCols(j).transpose() * z);
    }
    vectors.col(j) = z.normalized();
    const Vector unit = vectors.col(j);
    images.col(j) = stiffness.product(unit) + equations.curvature_product(unit);
  }
  const Matrix matrix = vectors.transpose() * images;
  const SymmetricEigen eigen = jacobi_eigen(0.5 * (matrix + matrix.transpose()));
  std::vector<Eigenpair> result;
  result.reserve(pairs.size());
  for (Index j = 0; j < count; ++j) {
    result.push_back({eigen.values[j], vectors * eigen.vectors.col(j)});
  }
  return result;
}

// The `count` lowest eigenpairs and a few more, which sharpen them.
std::vector<Eigenpair> sharp_pairs(ModeSearch& search, const ScaledStiffness& stiffness,
                                   const LinearisedEquations& equations, Index count,
                                   RoundOff& round_off) {
  constexpr Index kFew = 4;
  constexpr Index kMany = 64;
  constexpr double kEnough = 1e-8;
  for (Index more = kFew;; more *= 4) {
    const std::vector<Eigenpair> pairs =
        sharpened(stiffness, equations, search.lowest(count + more));
    const bool all = static_cast<Index>(pairs.size()) < count + more;
    if (!all) round_off.beyond = std::abs(pairs.back().value);
    if (all || more >= kMany || round_off.of_vector(pairs.front().value) <= kEnough) return pairs;
  }
}

NormalMode make_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                     const RoundOff& round_off, double omega_squared, const Vector& z) {
  NormalMode mode;
  mode.round_off = round_off.of_frequency(omega_squared);
  // If nothing is known of ω², its sign is not known either.
  const bool is_known = mode.round_off < 1.0;
  mode.kind = omega_squared < 0.0 && is_known ? ModeKind::kUnstable : ModeKind::kElastic;
  mode.omega_squared = is_known ? omega_squared : std::abs(omega_squared);
  mode.shape = stiffness.displacements(z);
  Index largest = 0;
  mode.shape.cwiseAbs().maxCoeff(&largest);
  if (mode.shape[largest] < 0.0) mode.shape = -mode.shape;
  const Vector momentum = stiffness.momentum(mode.shape);
  mode.effective_mass = momentum.reshaped(3, system.vertex_count()).rowwise().sum().cwiseAbs2();
  return mode;
}

NormalMode make_rigid_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                           const Vector& z, bool is_mechanism = false) {
  NormalMode mode = make_mode(system, stiffness, {}, 1.0, z);
  mode.kind = is_mechanism ? ModeKind::kMechanism : ModeKind::kRigid;
  mode.omega_squared = 0.0;
  mode.round_off = 0.0;
  return mode;
}

// ζ = φᵀCφ/(2ω).
void enter_damping(const DampingMatrix& damping, NormalMode& mode) {
  const double rate = std::max(0.0, mode.shape.dot(damping.product(mode.shape)));
  if (is_vibration(mode.kind) && mode.omega_squared > 0.0) {
    mode.damping_ratio = 0.5 * rate / std::sqrt(mode.omega_squared);
  } else if (is_free_of_strain(mode.kind) && rate > 0.0) {
    // A rigid motion strains nothing, so that viscosity gives it round-off only.
    if (mode.shape.dot(damping.product_of_terms(mode.shape)) > 0.0) {
      mode.damping_ratio = std::numeric_limits<double>::infinity();
    }
  }
}

// A mode of a complex ω², if it is one, has the frequency and the rate of growth of e^(iωt).
NormalMode make_complex_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                             const RoundOff& round_off, std::complex<double> omega_squared,
                             const Vector& z) {
  // Two equal frequencies may become conjugates by round-off.
  constexpr double kReal = 1e-6;
  NormalMode mode = make_mode(system, stiffness, round_off, omega_squared.real(), z.normalized());
  if (std::abs(omega_squared.imag()) <= kReal * std::abs(omega_squared)) return mode;
  const std::complex<double> omega = std::sqrt(omega_squared);
  mode.kind = ModeKind::kFlutter;
  mode.omega_squared = omega.real() * omega.real();
  mode.growth_rate = std::abs(omega.imag());
  return mode;
}

// Eigenvectors of a matrix and of its transpose, ψᵢᵀφⱼ = δᵢⱼ, for numbers of modes in ascending order.
struct BothEigenvectors {
  std::vector<std::size_t> modes;
  Eigen::VectorXcd values;
  Eigen::MatrixXcd right;
  Eigen::MatrixXcd left;
};

// Finds the left eigenvectors of the modes that are not rigid. There are fewer modes if the last ones have
// no partner, because their multiple eigenvalue was cut.
BothEigenvectors find_left(const std::vector<ComplexEigenpair>& pairs,
                           const std::vector<NormalMode>& modes,
                           const std::vector<ComplexEigenpair>& transposed) {
  constexpr double kSame = 1e-4;
  constexpr double kRegular = 1e-9;
  BothEigenvectors both;
  std::vector<std::size_t> partners;
  std::vector<bool> taken(transposed.size());
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    if (modes[j].kind == ModeKind::kRigid) continue;
    std::size_t best = transposed.size();
    double least = kSame * std::abs(pairs[j].value);
    for (std::size_t k = 0; k < transposed.size(); ++k) {
      const double distance = std::abs(transposed[k].value - pairs[j].value);
      if (taken[k] || !(distance <= least)) continue;
      least = distance;
      best = k;
    }
    if (best == transposed.size()) continue;
    taken[best] = true;
    both.modes.push_back(j);
    partners.push_back(best);
  }
  for (auto count = static_cast<Index>(partners.size()); count > 0; --count) {
    both.modes.resize(static_cast<std::size_t>(count));
    both.values.resize(count);
    both.right.resize(pairs.front().vector.size(), count);
    both.left.resize(both.right.rows(), count);
    for (Index i = 0; i < count; ++i) {
      const ComplexEigenpair& pair = pairs[both.modes[static_cast<std::size_t>(i)]];
      both.values[i] = pair.value;
      both.right.col(i) = pair.vector;
      both.left.col(i) = transposed[partners[static_cast<std::size_t>(i)]].vector;
    }
    const Eigen::MatrixXcd products = both.left.transpose() * both.right;
    const Eigen::PartialPivLU<Eigen::MatrixXcd> lu(products);
    if (!(lu.rcond() > kRegular)) continue;
    both.left = both.left * lu.inverse().transpose();
    return both;
  }
  return {};
}

// The damped motions Σ cⱼ φⱼ e^(λt) are those of formula (34) of docs/theory.md. Each mode has the one that
// consists of it more than of any other mode.
void enter_damping(const DampingMatrix& damping, const ScaledStiffness& stiffness,
                   const BothEigenvectors& both, std::vector<NormalMode>& modes) {
  using Complex = std::complex<double>;
  constexpr double kRoundOffOfRate = 1e-9;  // of |λ|
  const Index count = both.values.size();
  Eigen::MatrixXcd images(both.right.rows(), count);
  const auto image = [&](const Vector& z) {
    return stiffness.scaled(damping.product(stiffness.displacements(z)));
  };
  for (Index j = 0; j < count; ++j) {
    images.col(j).real() = image(both.right.col(j).real());
    images.col(j).imag() = image(both.right.col(j).imag());
  }
  const Eigen::MatrixXcd reduced = both.left.transpose() * images;
  // With c = E⁻¹ x and λ c = y the diagonal matrix E of the √|ω²| makes the two halves of the matrix
  // [0 E; −Ω² E⁻¹ −ΨᵀCΦ] comparable, whatever the unit of time.
  Vector scale = both.values.cwiseAbs().cwiseSqrt();
  const double unit = scale.maxCoeff() > 0.0 ? scale.maxCoeff() : 1.0;
  scale = (scale / unit).cwiseMax(kRoundOff);
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Zero(2 * count, 2 * count);
  matrix.topRightCorner(count, count).diagonal() = scale.cast<Complex>();
  matrix.bottomLeftCorner(count, count).diagonal() =
      -(both.values / (unit * unit)).cwiseQuotient(scale.cast<Complex>());
  matrix.bottomRightCorner(count, count) = -reduced / unit;
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(matrix);
  struct Match {
    double part;
    Index eigenvalue;
    Index mode;
  };
  std::vector<Match> matches;
  for (Index k = 0; k < 2 * count; ++k) {
    if (!(solver.eigenvalues()[k].imag() > 0.0)) continue;
    const Eigen::VectorXcd amounts = solver.eigenvectors().col(k).tail(count).normalized();
    for (Index j = 0; j < count; ++j) matches.push_back({std::abs(amounts[j]), k, j});
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.part > b.part; });
  std::vector<bool> is_taken(static_cast<std::size_t>(2 * count));
  std::vector<bool> is_done(static_cast<std::size_t>(count));
  for (const Match& match : matches) {
    const auto j = static_cast<std::size_t>(match.mode);
    if (is_done[j] || is_taken[static_cast<std::size_t>(match.eigenvalue)]) continue;
    is_done[j] = is_taken[static_cast<std::size_t>(match.eigenvalue)] = true;
    NormalMode& mode = modes[both.modes[j]];
    if (!is_vibration(mode.kind)) continue;
    const Complex lambda = unit * solver.eigenvalues()[match.eigenvalue];
    const bool grows = lambda.real() > kRoundOffOfRate * std::abs(lambda);
    mode.damping_ratio = -lambda.real() / std::abs(lambda);
    mode.kind = grows ? ModeKind::kFlutter : ModeKind::kElastic;
    mode.growth_rate = grows ? lambda.real() : 0.0;
  }
}

// The modes with the whole stiffness of the loads. `start`: eigenvectors of S as columns, of which the
// first are the rigid motions, which are eigenvectors of the whole stiffness, too. `units`: the unit
// translations along x, y, z, in the coordinates of S.
std::vector<NormalMode> modes_under_loads(const MechanicalSystem& system, const Vector& q,
                                          const NormalModeOptions& options,
                                          const ScaledStiffness& stiffness,
                                          const LinearisedEquations& equations,
                                          const RoundOff& round_off, const ModeSearch& search,
                                          const Matrix& start, Index rigid, const Matrix& units,
                                          Index count) {
  constexpr double kSame = 0.5;
  const SkewLoadStiffness skew(system, q, options.time, options.load_factor);
  // The transposed matrix has the opposite skew part.
  const auto find = [&](double sign) {
    return lowest_unsymmetric(
        [&](const Vector& z) {
          const Vector forces = stiffness.product(z) + equations.curvature_product(z) +
                                sign * stiffness.scaled(skew.product(stiffness.displacements(z)));
          return equations.project(forces);
        },
        [&](const Vector& r) { return search.solve(r); }, start, count);
  };
  std::vector<NormalMode> modes;
  const std::vector<ComplexEigenpair> pairs = find(1.0);
  for (const ComplexEigenpair& pair : pairs) {
    // The two conjugates have the same plane of motion: one gives the first of its axes, the other
    // one the second.
    const bool second = pair.value.imag() < 0.0;
    const Vector z = second ? Vector(pair.vector.imag()) : Vector(pair.vector.real());
    const bool is_rigid = (start.leftCols(rigid).transpose() * pair.vector).squaredNorm() > kSame;
    modes.push_back(is_rigid ? make_rigid_mode(system, stiffness, z.normalized())
                             : make_complex_mode(system, stiffness, round_off, pair.value, z));
  }
  const BothEigenvectors both = find_left(pairs, modes, find(-1.0));
  for (std::size_t i = 0; i < both.modes.size(); ++i) {
    const auto j = static_cast<Index>(i);
    for (Index d = 0; d < 3; ++d) {
      const Eigen::VectorXcd unit = units.col(d).cast<std::complex<double>>();
      const std::complex<double> product =
          both.left.col(j).cwiseProduct(unit).sum() * both.right.col(j).cwiseProduct(unit).sum();
      modes[both.modes[i]].effective_mass[d] = product.real();
    }
  }
  if (!system.is_dissipative()) return modes;
  const DampingMatrix damping(system, q, options.time);
  for (NormalMode& mode : modes) enter_damping(damping, mode);
  if (!both.modes.empty()) enter_damping(damping, stiffness, both, modes);
  return modes;
}

}  // namespace

const char* to_string(ModeKind kind) {
  switch (kind) {
    case ModeKind::kRigid:
      return "rigid";
    case ModeKind::kElastic:
      return "elastic";
    case ModeKind::kFlutter:
      return "flutter";
    case ModeKind::kMechanism:
      return "mechanism";
    case ModeKind::kUnstable:
      break;
  }
  return "unstable";
}

double NormalMode::frequency() const {
  return std::sqrt(std::abs(omega_squared)) / (2.0 * std::numbers::pi);
}

Vector balancing_multipliers(const MechanicalSystem& system, const Vector& q, const Vector& load,
                             double time, double load_factor) {
  const Constraints& constraints = system.constraints();
  if (!constraints.has_equations()) return {};
  double energy = 0.0;
  Vector force;
  if (!system.elastic_energy_and_gradient(q, energy, force).ok()) {
    throw InputError("The multipliers cannot be computed: the elastic energy is not defined.");
  }
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->account() == EnergyAccount::kExternalWork) continue;
    Vector gradient = Vector::Zero(force.size());
    term->add_gradient(system.force_point(q, time), gradient);
    force += (term->account() == EnergyAccount::kConstraintWork ? 1.0 : load_factor) * gradient;
  }
  force -= load;
  Matrix gradients = constraints.selector() * constraints.gradients(constraints.configuration(q));
  // Long and short constraints have gradients of different size.
  Vector length = gradients.colwise().norm().transpose();
  length = (length.array() > 0.0).select(length, 1.0);
  gradients *= length.cwiseInverse().asDiagonal();
  return -Eigen::CompleteOrthogonalDecomposition<Matrix>(gradients)
              .solve(system.coordinates().restrict(force))
              .cwiseQuotient(length);
}

NormalModes normal_modes(const MechanicalSystem& system, const Vector& q,
                         const NormalModeOptions& options) {
  if (options.count < 1) throw InputError("The number of modes must be 1 or more.");
  if (system.coordinates().count() == 0) {
    throw InputError("The body has no modes, because every vertex is held.");
  }
  Index vertex = -1;
  if (const ForceTerm* term = system.undefined_term(q, options.time, vertex); term != nullptr) {
    throw InputError(fmt::format(
        "The modes cannot be computed: the potential of the force term \"{}\" is not defined.",
        term->name()));
  }
  const ScaledStiffness stiffness(system, q, options.time, options.with_loads, options.load_factor);
  const LinearisedEquations equations(system, stiffness, q, options.multipliers);
  const bool under_loads = options.with_loads && system.has_load_of_position();
  const FreeModes free = free_rigid_motions(system, q, options, stiffness, equations, under_loads);
  const Matrix& rigid = free.vectors;

  NormalModes result;
  result.total = stiffness.size() - equations.count();
  Matrix units(stiffness.size(), 3);  // unit translations
  for (int d = 0; d < 3; ++d) {
    Vector unit = Vector::Zero(system.dof_count());
    for (Index v = 0; v < system.vertex_count(); ++v) unit[3 * v + d] = 1.0;
    units.col(d) = equations.project(stiffness.scaled(stiffness.momentum(unit)));
  }
  result.moved_mass = units.colwise().squaredNorm().transpose();
  for (Index j = 0; !under_loads && j < rigid.cols(); ++j) {
    result.modes.push_back(make_rigid_mode(system, stiffness, rigid.col(j),
                                           free.is_mechanism[static_cast<std::size_t>(j)]));
  }
  const Index others = result.total - rigid.cols();
  if (others > 0 || under_loads) {
    // There may be unstable modes, which come before the rigid ones.
    ModeSearch search(stiffness, equations, rigid);
    RoundOff round_off{stiffness.largest(), waves_across(system)};
    const std::vector<Eigenpair> pairs =
        sharp_pairs(search, stiffness, equations, options.count, round_off);
    if (under_loads) {
      // Modes that are close to each other are needed together for their damping.
      constexpr Index kMore = 4;
      Matrix start(stiffness.size(), rigid.cols() + static_cast<Index>(pairs.size()));
      start.leftCols(rigid.cols()) = rigid;
      for (std::size_t j = 0; j < pairs.size(); ++j) {
        start.col(rigid.cols() + static_cast<Index>(j)) = pairs[j].vector;
      }
      result.modes = modes_under_loads(system, q, options, stiffness, equations, round_off, search,
                                       start, rigid.cols(), units, options.count + kMore);
    } else {
      for (const Eigenpair& pair : pairs) {
        result.modes.push_back(make_mode(system, stiffness, round_off, pair.value, pair.vector));
      }
    }
  }
  std::stable_sort(
      result.modes.begin(), result.modes.end(),
      [](const NormalMode& a, const NormalMode& b) { return a.omega_squared < b.omega_squared; });
  // Of a pair that flutters the mode that grows comes first, lest it be cut off.
  constexpr double kSamePair = 1e-12;
  for (std::size_t i = 1; i < result.modes.size(); ++i) {
    NormalMode& first = result.modes[i - 1];
    NormalMode& second = result.modes[i];
    const bool is_pair = std::abs(second.omega_squared - first.omega_squared) <=
                         kSamePair * std::abs(first.omega_squared);
    if (is_pair && second.growth_rate > first.growth_rate) std::swap(first, second);
  }
  if (static_cast<Index>(result.modes.size()) > options.count) {
    result.modes.resize(static_cast<std::size_t>(options.count));
  }
  if (system.is_dissipative() && !under_loads) {
    const DampingMatrix damping(system, q, options.time);
    for (NormalMode& mode : result.modes) enter_damping(damping, mode);
  }
  return result;
}

std::string round_off_warning(const NormalModes& modes) {
  constexpr double kMuch = 1e-4;
  const NormalMode* worst = nullptr;
  Index count = 0;
  for (const NormalMode& mode : modes.modes) {
    if (!(mode.round_off > kMuch)) continue;
    ++count;
    if (worst == nullptr || mode.round_off > worst->round_off) worst = &mode;
  }
  if (worst == nullptr) return {};
  const std::string error =
      worst->round_off < 1.0
          ? fmt::format("{:.1g} of it", worst->round_off)
          : std::string("as large as the frequency itself, so that only an upper bound is known");
  return fmt::format(
      "round-off: {} of the frequencies {} so far below the highest frequency of the mesh that "
      "round-off spoils {}. The error at {:.4g} Hz is about {}. Elements that are longer along the "
      "body, or a thicker body, lessen it",
      count, count == 1 ? "lies" : "lie", count == 1 ? "it" : "them", worst->frequency(), error);
}

}  // namespace tetraction
