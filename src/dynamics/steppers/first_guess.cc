#include "first_guess.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/conjugate_gradients.h"
#include "core/decompositions.h"
#include "fem/element_sums.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {

FirstGuess::FirstGuess(const MechanicalSystem& system, bool prescribed_move)
    : system_(system),
      free_(everywhere(system.part(), system.constraints().empty())),
      moving_(anywhere(system.part(), prescribed_move)),
      zero_(Vector::Zero(system.dof_count())) {
  if (!prescribed_move) return;
  const RestState& rest = system.rest();
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    const auto free = std::count_if(nodes.begin(), nodes.end(),
                                    [&](Index v) { return system.coordinates().is_free(v); });
    if (free > 0 && free < static_cast<Index>(nodes.size())) moved_elements_.push_back(e);
  }
}

void FirstGuess::reset() {
  earlier_count_ = 0;
  knows_energy_ = false;
}

FirstGuess::Quality FirstGuess::choose(StepProblem& problem, const State& state) {
  const int favourite = is_possible(best_) ? best_ : 0;
  double least = std::numeric_limits<double>::infinity();
  int best = -1;
  const auto judge = [&](int guess) {
    double phi = 0.0;
    if (guess == kStay && knows_value_of_stay()) {
      phi = elastic_energy_;
    } else {
      make(guess, problem, state, trial_);
      problem.clear_way(trial_);
      problem.set_origin(trial_);
      // The guess that was best in the last step is evaluated last and with its gradient, because
      // the minimiser begins with this evaluation.
      const EvaluationStatus status = guess == favourite
                                          ? problem.value_and_full_gradient(zero_, phi, gradient_)
                                          : problem.value(zero_, phi);
      if (!status.ok()) return;
      phi += problem.origin_value();
    }
    if (!(phi < least)) return;
    least = phi;
    best = guess;
    if (guess != favourite) least_.swap(trial_);
  };
  for (int guess = 0; guess <= kRigid; ++guess) {
    if (guess != favourite && is_possible(guess)) judge(guess);
  }
  judge(favourite);
  if (best < 0) {
    problem.set_origin(problem.base());
    return Quality::kUndefined;
  }
  best_ = best;
  if (best == kStay && knows_value_of_stay()) {
    problem.set_origin(problem.base());
  } else if (best != favourite) {
    problem.set_origin(least_);
  }
  return keeps_volumes(state.position, problem.origin()) ? Quality::kGood : Quality::kCrushed;
}

void FirstGuess::make(int guess, const StepProblem& problem, const State& state, Vector& x) const {
  if (guess == 0) {
    problem.inertial_guess(x);
    return;
  }
  if (guess == kStay) {
    x = problem.base();
    return;
  }
  if (guess == kRigid) {
    problem.inertial_guess(x);
    make_rigid(state.position, x, x);
    return;
  }
  // Polynomials through the last velocities; equal step sizes are assumed.
  const double s = problem.step();
  if (guess == 2) x = s * state.velocity;
  if (guess == 3) x = s * (2.0 * state.velocity - earlier_[0]);
  if (guess == 4) x = s * (3.0 * (state.velocity - earlier_[0]) + earlier_[1]);
  system_.coordinates().project_velocity(system_.mass(), x);
  x += problem.base();
}

void FirstGuess::make_rigid(const Vector& q, const Vector& target, Vector& x) const {
  const Vector3 from = center_of_mass(system_, q);
  const Vector3 to = center_of_mass(system_, target);
  Matrix3 moment = Matrix3::Zero();
  for (Index v = 0; v < system_.owned_vertex_count(); ++v) {
    moment += system_.mass()[v] * (vertex_block(target, v) - to) *
              (vertex_block(q, v) - from).transpose();
  }
  sum_over_parts(system_.part(), moment.data(), 9);
  const Matrix3 rotation = proper_rotation(moment);
  x.resize(q.size());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    vertex_block(x, v) = to + rotation * (vertex_block(q, v) - from);
  }
}

void FirstGuess::keep(const Vector& velocity, double elastic_energy) {
  earlier_[0].swap(earlier_[1]);
  earlier_[0] = velocity;
  earlier_count_ = std::min(earlier_count_ + 1, 2);
  elastic_energy_ = elastic_energy;
  knows_energy_ = true;
}

bool FirstGuess::keeps_volumes(const Vector& from, const Vector& x) const {
  constexpr double kFair = 0.2;
  const RestState& rest = system_.rest();
  const auto volume = [&](const Vector& q, Index point) {
    const RestState::Shape::NodeMatrix nodes = rest.gather_relative(q, point);
    return Matrix3(nodes.rightCols<3>()).determinant();
  };
  const bool keeps = std::all_of(moved_elements_.begin(), moved_elements_.end(), [&](Index e) {
    for (Index i = rest.points_per_element() * e; rest.element_of(i) == e; ++i) {
      const double before = volume(from, i);
      if (before > 0.0 && !(volume(x, i) > kFair * before)) return false;
    }
    return true;
  });
  return everywhere(system_.part(), keeps);
}

// Conjugate gradients, preconditioned with the diagonal, over the free coordinates z of x + T z. A
// few digits are sufficient.
void FirstGuess::carry_along(const PotentialProblem& problem, Vector& x) const {
  constexpr double kEnough = 1e-4;
  const RestState& rest = system_.rest();
  const FreeCoordinates& free = system_.coordinates();
  const int points = rest.points_per_element();
  const auto apply = [&](const Vector& u) {
    Vector result = Vector::Zero(u.size());
    for (Index e = 0; e < rest.element_count(); ++e) {
      NodeGradient sum = NodeGradient::Zero(3, rest.nodes_per_element());
      for (int p = 0; p < points; ++p) {
        const auto point = rest.point(points * e + p);
        const auto& gradients = point.gradients[0];
        add_point_gradient(p,
                           point.weights[0] * rest.gather_relative(u, points * e + p) *
                               (gradients.transpose() * gradients),
                           sum);
      }
      Index a = 0;
      for (const Index v : rest.nodes(e)) vertex_block(result, v) += sum.col(a++);
    }
    return result;
  };
  Vector diagonal = Vector::Zero(system_.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (int p = 0; p < points; ++p) {
      const auto point = rest.point(points * e + p);
      NodeGradient gradients = NodeGradient::Zero(3, rest.nodes_per_element());
      add_point_gradient(p, point.gradients[0], gradients);
      Index a = 0;
      for (const Index v : rest.nodes(e)) {
        diagonal[v] += point.weights[0] * gradients.col(a++).squaredNorm();
      }
    }
  }
  const Vector inverse_diagonal = free.reduced_mass(diagonal).cwiseInverse();

  // The missing displacement of the prescribed components.
  Vector lack = problem.base() - x;
  Vector own = lack;
  free.project_velocity(system_.mass(), own);
  lack -= own;
  x += lack;
  Vector z = Vector::Zero(free.count());
  if (free.count() == 0) return;
  Vector r = -free.restrict(apply(lack));
  const int most = 10 + static_cast<int>(10.0 * std::cbrt(static_cast<double>(free.count())));
  PlainVectors vectors(
      z, r, [&](const Vector& p, Vector& ap) { ap = free.restrict(apply(free.extend(p))); },
      [&](const Vector& residual, Vector& y) { y = inverse_diagonal.cwiseProduct(residual); });
  conjugate_gradients(vectors, kEnough, most);
  x += free.extend(z);
}

}  // namespace tetraction
