#include "tetraction/dynamics/steppers/stability.h"

#include <Spectra/SymEigsSolver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/decompositions.h"
#include "dynamics/constraints/scaled_matrix.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Eigenpair {
  double value = 0.0;
  Vector vector;  // empty: not found
};

// Small systems: all eigenvalues of the dense matrix.
Eigenpair dense_largest(const ScaledMatrix& op) {
  const Index n = op.rows();
  if (n == 0) return {0.0, Vector(0)};
  Matrix k(n, n);
  for (Index j = 0; j < n; ++j) {
    const Vector unit = Vector::Unit(n, j);
    op.perform_op(unit.data(), k.col(j).data());
  }
  const SymmetricEigen eigen = symmetric_eigen(k);
  return {eigen.values[n - 1], eigen.vectors.col(n - 1)};
}

// The matrix in a unit in which its first product has the length of the vector, since Spectra takes eigenvalues below
// 1e-11 for zero. The unit is a power of two, which changes no digit.
class MatrixInOwnUnit {
 public:
  using Scalar = double;

  explicit MatrixInOwnUnit(const ScaledMatrix& op) : op_(op) {}

  Index rows() const { return op_.rows(); }
  Index cols() const { return op_.cols(); }
  void perform_op(const double* in, double* out) const {
    op_.perform_op(in, out);
    Eigen::Map<Vector> product(out, rows());
    if (unit_ == 0.0) {
      const double size = product.stableNorm() / Eigen::Map<const Vector>(in, rows()).stableNorm();
      unit_ = size > 0.0 && std::isfinite(size) ? std::ldexp(1.0, std::ilogb(size)) : 1.0;
    }
    product /= unit_;
  }
  double unit() const { return unit_; }

 private:
  const ScaledMatrix& op_;
  mutable double unit_ = 0.0;  // 0: there was no product yet
};

// How exactly an eigenpair is wanted, and the work that this may take.
struct Effort {
  Index subspace = 0;
  Index restarts = 0;
  double tolerance = 0.0;
};

// Lanczos iterations with complete orthogonalisation, which begin again with the best vector. They are
// right for matrices of any rank, since they end where the products leave no new direction. All parts of a divided
// body take the same decisions, because their sums have the same bits. `start` may be empty.
Eigenpair plain_lanczos_largest(const ScaledMatrix& op, const Vector& start, const Effort& effort) {
  Vector x = start.size() == op.rows() ? start : op.pseudo_random_start();
  Eigenpair best{0.0, x};
  for (Index restart = 0; restart <= effort.restarts; ++restart) {
    const double norm = std::sqrt(op.dot(x, x));
    if (!(norm > 0.0)) return best;
    std::vector<Vector> basis{x / norm};
    Matrix t = Matrix::Zero(effort.subspace, effort.subspace);
    Vector y(op.rows());
    Index size = 0;
    double left = 0.0;
    while (size < effort.subspace) {
      op.perform_op(basis[static_cast<std::size_t>(size)].data(), y.data());
      for (int pass = 0; pass < 2; ++pass) {
        for (Index i = 0; i <= size; ++i) {
          const double part = op.dot(basis[static_cast<std::size_t>(i)], y);
          y -= part * basis[static_cast<std::size_t>(i)];
          if (i == size) t(size, size) += part;
        }
      }
      if (!std::isfinite(t(size, size))) return {t(size, size), x};
      left = std::sqrt(std::max(0.0, op.dot(y, y)));
      ++size;
      if (size == effort.subspace || !(left > 1e-12 * std::abs(t(0, 0)))) break;
      t(size, size - 1) = t(size - 1, size) = left;
      basis.push_back(y / left);
    }
    const SymmetricEigen eigen = symmetric_eigen(Matrix(t.topLeftCorner(size, size)));
    const Vector weights = eigen.vectors.col(size - 1);
    best.value = eigen.values[size - 1];
    best.vector.setZero(op.rows());
    for (Index i = 0; i < size; ++i) best.vector += weights[i] * basis[static_cast<std::size_t>(i)];
    if (!(left * std::abs(weights[size - 1]) > effort.tolerance * std::abs(best.value))) break;
    x = best.vector;
  }
  return best;
}

// The same by Spectra, which keeps more than one vector when it begins again and therefore needs fewer products.
// Of a matrix of low rank, such as that of a damper at a few vertices, it returns numbers that are no eigenvalue, or it
// throws. Then, and if it does not converge, the plain iterations are taken.
Eigenpair lanczos_largest(const ScaledMatrix& matrix, const Vector& start, const Effort& effort) {
  if (matrix.system().part() == nullptr) {
    try {
      MatrixInOwnUnit op(matrix);
      Spectra::SymEigsSolver<MatrixInOwnUnit> solver(op, 1, effort.subspace);
      if (start.size() > 0) {
        solver.init(start.data());
      } else {
        solver.init();
      }
      solver.compute(Spectra::SortRule::LargestAlge, effort.restarts, effort.tolerance);
      if (solver.info() == Spectra::CompInfo::Successful) {
        const Eigenpair pair{op.unit() * solver.eigenvalues()[0], solver.eigenvectors().col(0)};
        Vector product(matrix.rows());
        matrix.perform_op(pair.vector.data(), product.data());
        const double residual = (product - pair.value * pair.vector).norm();
        if (residual <= 2.0 * effort.tolerance * pair.value) return pair;
      }
    } catch (const std::runtime_error&) {
    } catch (const std::invalid_argument&) {
    }
  }
  return plain_lanczos_largest(matrix, start, effort);
}

// The largest eigenpair. Throws InputError if it is not finite.
Eigenpair largest_eigenpair(ScaledMatrix& op, const Vector& start = {}) {
  constexpr Index kDense = 60;
  const bool divided = op.system().part() != nullptr;
  // The plain iterations begin again with a single vector, which needs a larger space than Spectra does. There each
  // vector more costs as much time as it saves products.
  const Effort effort{.subspace = divided ? 24 : 10, .restarts = 300, .tolerance = 1e-4};
  Eigenpair largest =
      !divided && op.rows() <= kDense ? dense_largest(op) : lanczos_largest(op, start, effort);
  if (std::isfinite(largest.value)) return largest;
  throw InputError(
      "The stability limit cannot be worked out, as the highest frequency of the body overflows: "
      "material.youngs_modulus (or mu, lambda), material.density, mesh.generate.size or "
      "mesh.scale, fix.penalty, damping.viscosity, pull.stiffness, pull.damping and "
      "environment.strength are too far apart in size, or one is too large or too small. Choose "
      "other units or values.");
}

// A start near `last`. A start that is exactly an eigenvector would find nothing else, so that noise is added,
// and `other` if there is one.
Vector start_near(const ScaledMatrix& op, const Vector& last, const Vector& other) {
  const auto normalized = [&op](const Vector& x) -> Vector {
    const double square = op.dot(x, x);
    return square > 0.0 ? Vector(x / std::sqrt(square)) : x;
  };
  Vector start = 0.05 * normalized(op.pseudo_random_start());
  if (last.size() == start.size()) start += normalized(last);
  if (other.size() == start.size()) start += 0.5 * normalized(other);
  return start;
}

// The same with a few products from a start that is near.
Eigenpair follow_largest(ScaledMatrix& op, const Vector& last, const Vector& other) {
  constexpr Index kDense = 8;
  const bool divided = op.system().part() != nullptr;
  const Effort effort{.subspace = divided ? 10 : 5, .restarts = 12, .tolerance = 0.02};
  if (!divided && op.rows() <= kDense) return dense_largest(op);
  return lanczos_largest(op, start_near(op, last, divided ? Vector() : other), effort);
}

double omega_of(double eigenvalue) {
  return std::sqrt(std::max(0.0, eigenvalue));
}

// Whether a term damps single vertices of the whole body. A pull damps its vertices alone.
bool damps_vertices(const ForceTerm& term) {
  return term.has_dissipation() && !term.couples_vertices() &&
         term.account() != EnergyAccount::kExternalWork;
}

// Whether there is other damping, whose rate takes iterations.
bool has_connecting_damping(const MechanicalSystem& system) {
  return system.damping().viscosity > 0.0 ||
         std::any_of(system.force_terms().begin(), system.force_terms().end(),
                     [](const ForceTerm* term) {
                       return term->has_dissipation() && !damps_vertices(*term);
                     });
}

double rayleigh_quotient(const ScaledMatrix& op, const Vector& x) {
  Vector y(x.size());
  op.perform_op(x.data(), y.data());
  if (op.system().part() == nullptr) return x.dot(y) / x.squaredNorm();
  return op.dot(x, y) / op.dot(x, x);
}

// One step towards the h at which the largest eigenvalue of M⁻¹(K + (2/h)C) is 4/h²: exact for the
// eigenvector at h, whose Rayleigh quotients k and c give the next one. Never too small.
double refine_explicit_step(ScaledMatrix& op, const Vector& q, double time, const Eigenpair& at_h,
                            double h) {
  op.set_damping(q, time);
  const double c = std::max(0.0, rayleigh_quotient(op, at_h.vector));
  return explicit_critical_step(omega_of(at_h.value - 2.0 / h * c), c);
}

}  // namespace

double vertex_damping_rate(const MechanicalSystem& system, const Vector& q, double time) {
  HessianBlocks blocks;
  bool any = false;
  for (const ForceTerm* term : system.force_terms()) {
    if (!damps_vertices(*term)) continue;
    if (!any) blocks.reset(system.vertex_count());
    any = true;
    term->add_dissipation_hessian(system.force_point(q, time), Vector::Zero(q.size()),
                                  HessianForm::kExact, blocks);
  }
  double rate = 0.0;
  for (Index v = 0; any && v < system.vertex_count(); ++v) {
    const double largest = symmetric_eigen(Matrix3(blocks.diagonal(v))).values[2];
    rate = std::max(rate, largest * system.inverse_mass()[v]);
  }
  return largest_of_parts(system.part(), rate);
}

// Formula (21) of docs/theory.md for one mode.
double explicit_critical_step(double omega, double rate) {
  const double sum = rate + std::hypot(rate, 2.0 * omega);
  return sum > 0.0 ? 4.0 / sum : kInfinity;
}

// Formula (22) of docs/theory.md.
double verlet_critical_step(double omega, double rate) {
  constexpr double kMostDamped = 1.5436890126920764;  // a with (1−a)(1−a+a²) = −1
  const double undamped = omega > 0.0 ? 2.0 / omega : kInfinity;
  if (rate <= 0.0 || 0.5 * undamped * rate <= 1.0) return undamped;
  const auto stable = [&](double h) {
    const double a = 0.5 * h * rate;
    const double b = 1.0 - a;
    return 0.25 * h * h * omega * omega * (1.0 + b * b) < 1.0 + b * (b + a * a);
  };
  double low = 2.0 / rate;  // a = 1
  double high = std::min(undamped, 2.0 * kMostDamped / rate);
  for (int i = 0; i < 60 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

Index critical_element(const MechanicalSystem& system, const CriticalModes& modes) {
  Vector mode = modes.stiffness;
  if (!everywhere(system.part(), mode.size() == system.coordinates().count())) return -1;
  if (largest_of_parts(system.part(), static_cast<double>(mode.size())) == 0.0) return -1;
  mode = ScaledMatrix(system).displacement(mode);
  Index element = -1;
  double most = -1.0;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    double motion = 0.0;
    for (const Index v : system.rest().nodes(e)) motion += vertex_block(mode, v).squaredNorm();
    if (motion > most) {
      most = motion;
      element = e;
    }
  }
  return most == largest_of_parts(system.part(), most) ? element : -1;
}

StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q, Integrator rule,
                               CriticalModes* modes, double time) {
  StabilityLimit limit;
  if (global_freedom_count(system) == 0) {  // nothing that could oscillate
    limit.critical_step = kInfinity;
    if (modes != nullptr) *modes = {};
    return limit;
  }
  ScaledMatrix op(system);
  op.set_stiffness(q, time);
  Eigenpair largest = largest_eigenpair(op);
  Eigenpair damped;
  limit.omega_max = omega_of(largest.value);
  limit.damping_rate = vertex_damping_rate(system, q, time);
  if (has_connecting_damping(system)) {
    op.set_damping(q, time);
    // A damper at a few vertices may not act on that mode at all, which would then be no start.
    const bool is_viscous = system.damping().viscosity > 0.0;
    damped = largest_eigenpair(op, is_viscous ? largest.vector : Vector());
    limit.damping_rate = std::max(limit.damping_rate, damped.value);
  }
  if (rule == Integrator::kVerlet) {
    limit.critical_step = verlet_critical_step(limit.omega_max, limit.damping_rate);
  } else {
    // The largest ω and the largest c in one mode would give this lower bound of the limit. A few
    // iterations lead from it to the limit itself.
    constexpr int kRounds = 4;
    constexpr double kAccuracy = 1e-4;
    double h = explicit_critical_step(limit.omega_max, limit.damping_rate);
    const bool damping = system.is_dissipative();
    for (int round = 0; round < kRounds && damping && std::isfinite(h); ++round) {
      op.set_stiffness(q, time, 2.0 / h);
      largest = largest_eigenpair(op, start_near(op, largest.vector, damped.vector));
      const double next = refine_explicit_step(op, q, time, largest, h);
      const bool done = std::abs(next - h) <= kAccuracy * h;
      h = next;
      if (done) break;
    }
    limit.critical_step = h;
  }
  CriticalModes found{std::move(largest.vector), std::move(damped.vector)};
  limit.element = critical_element(system, found);
  if (modes != nullptr) *modes = std::move(found);
  return limit;
}

struct StabilityTracker::Impl {
  explicit Impl(const MechanicalSystem& body) : system(body), op(body) {}

  // Counts the work since the last set_…().
  void count() {
    cost += op.is_fast() ? 2.0 + 0.75 * static_cast<double>(op.products())
                         : 3.5 * static_cast<double>(op.products());
  }

  const MechanicalSystem& system;
  ScaledMatrix op;
  double cost = 0.0;
};

StabilityTracker::StabilityTracker(const MechanicalSystem& system)
    : impl_(std::make_unique<Impl>(system)) {}
StabilityTracker::~StabilityTracker() = default;

double StabilityTracker::cost() const {
  return impl_->cost;
}

double StabilityTracker::critical_step(const Vector& q, Integrator rule, CriticalModes& modes,
                                       double time) {
  Impl& s = *impl_;
  s.cost = 0.0;
  const bool connecting = has_connecting_damping(s.system);
  const bool damped = s.system.is_dissipative();
  if (rule != Integrator::kVerlet && damped) {
    // The limit that these modes would have now is where K + (2/h)C is taken.
    double h = 0.0;
    if (everywhere(s.system.part(), modes.stiffness.size() == s.op.rows())) {
      s.op.set_stiffness(q, time);
      const double k = rayleigh_quotient(s.op, modes.stiffness);
      s.op.set_damping(q, time);
      h = explicit_critical_step(omega_of(k), rayleigh_quotient(s.op, modes.stiffness));
      s.count();
    }
    if (!(h > 0.0) || !std::isfinite(h)) {
      return stability_limit(s.system, q, rule, &modes, time).critical_step;
    }
    s.op.set_stiffness(q, time, 2.0 / h);
    Eigenpair largest = follow_largest(s.op, modes.stiffness, s.op.stiffest_vertex());
    s.count();
    h = refine_explicit_step(s.op, q, time, largest, h);
    s.count();
    modes.stiffness = std::move(largest.vector);
    return h;
  }
  s.op.set_stiffness(q, time);
  Eigenpair largest = follow_largest(s.op, modes.stiffness, s.op.stiffest_vertex());
  s.count();
  double rate = vertex_damping_rate(s.system, q, time);
  if (connecting) {
    s.op.set_damping(q, time);
    Eigenpair most = follow_largest(s.op, modes.damping, largest.vector);
    s.count();
    rate = std::max(rate, most.value);
    modes.damping = std::move(most.vector);
  }
  modes.stiffness = std::move(largest.vector);
  return verlet_critical_step(omega_of(largest.value), rate);
}

double largest_impedance(const MechanicalSystem& system) {
  double largest = 0.0;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const double density = system.element_mass(e) / system.rest().volume(e);
    largest = std::max(largest, density * wave_speed(system.lame(e), density));
  }
  return largest;
}

}  // namespace tetraction
