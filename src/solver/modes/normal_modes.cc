#include "tetraction/solver/normal_modes.h"

#include <fmt/format.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/decompositions.h"
#include "free_modes.h"
#include "lowest_eigenpairs.h"
#include "mode_construction.h"
#include "modes_under_loads.h"
#include "small_motions.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

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

}  // namespace

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
  // The growing mode of a pair that flutters comes first, so that it is not cut off.
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
    const DampingMatrix damping(system, q, options.time, options.with_loads);
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
