// Prescribed positions and momenta, penalty springs, and the deviation of a state from its
// constraints.
#include <algorithm>
#include <cmath>
#include <set>

#include "tetraction/dynamics/constraints/constraints.h"

namespace tetraction {

bool Constraints::is_constrained(Index vertex) const {
  if (!coordinates_.is_free(vertex)) return true;
  for (const Equation& equation : equations_) {
    for (const auto& [v, weights] : equation.weights) {
      if (v == vertex) return true;
    }
  }
  return springs_.holds(vertex);
}

std::vector<Index> Constraints::constrained_vertices() const {
  std::set<Index> vertices;
  for (const Prescribed& vertex : prescribed_) vertices.insert(vertex.vertex);
  for (const Equation& equation : equations_) {
    for (const auto& [v, weights] : equation.weights) vertices.insert(v);
  }
  for (Index i = 0; i < springs_.stiffness().size(); ++i) {
    if (springs_.stiffness()[i] > 0.0) vertices.insert(i / 3);
  }
  return {vertices.begin(), vertices.end()};
}

// The position of a vertex with its prescribed components at `time` and its other components from
// q.
Vector3 Constraints::axis_target(const Prescribed& vertex, double time, const Vector3& q) const {
  Vector3 x = q;
  for (std::size_t i = 0; i < 3; ++i) {
    if (vertex.held[i] < 0) continue;
    const PrescribedVertices& by = held(vertex.held[i]);
    x[static_cast<Index>(i)] =
        by.motion.position(by.start.col(vertex.place[i]), time)[static_cast<Index>(i)];
  }
  return x;
}

// The rates of the prescribed components at `time`; zero for the others.
Vector3 Constraints::axis_rate(const Prescribed& vertex, double time) const {
  Vector3 rate = Vector3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    if (vertex.held[i] < 0) continue;
    const PrescribedVertices& by = held(vertex.held[i]);
    rate[static_cast<Index>(i)] =
        by.motion.rate(by.start.col(vertex.place[i]), time)[static_cast<Index>(i)];
  }
  return rate;
}

void Constraints::prescribe(double time, Vector& q) const {
  for (const Prescribed& vertex : prescribed_) {
    Vector3 x = q.segment<3>(3 * vertex.vertex);
    if (vertex.guided) {
      x = (vertex.point + vertex.freedom.project(x - vertex.point)).eval();
    }
    q.segment<3>(3 * vertex.vertex) = axis_target(vertex, time, x);
  }
  for (std::size_t s = 0; s < coordinates_.sets().size(); ++s) {
    const AffineSet& set = coordinates_.sets()[s];
    const Equation& equation = equations_[s];  // handles come first
    double total = 0.0;
    Vector3 center = Vector3::Zero();
    Matrix3 vectors = Matrix3::Zero();
    for (const auto& [v, weights] : equation.weights) {
      total += mass_[v];
      center += mass_[v] * q.segment<3>(3 * v);
      for (int j = 0; j < set.rank(); ++j) vectors.col(j) += weights[j] * q.segment<3>(3 * v);
    }
    center /= total;
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      q.segment<3>(3 * set.vertices[i]) =
          center + vectors.leftCols(set.rank()) * set.coordinates.col(static_cast<Index>(i));
    }
  }
}

void Constraints::for_each_prescribed_displacement(
    const Vector& from, double time,
    const std::function<void(Index, const Vector3&)>& visit) const {
  if (!moving_) return;
  for (const Prescribed& vertex : prescribed_) {
    const Vector3 x = from.segment<3>(3 * vertex.vertex);
    visit(vertex.vertex, axis_target(vertex, time, x) - x);
  }
}

void Constraints::prescribe_momentum(double time, Vector& momentum) const {
  for (const Prescribed& vertex : prescribed_) {
    const Vector3 rate = axis_rate(vertex, time);
    for (std::size_t i = 0; i < 3; ++i) {
      if (vertex.held[i] < 0) continue;
      const auto axis = static_cast<Index>(i);
      momentum[3 * vertex.vertex + axis] = mass_[vertex.vertex] * rate[axis];
    }
  }
}

double Constraints::error(const Vector& q, double time) const {
  double error = 0.0;
  for (const Prescribed& vertex : prescribed_) {
    const Vector3 x = q.segment<3>(3 * vertex.vertex);
    error = std::max(error, (x - axis_target(vertex, time, x)).cwiseAbs().maxCoeff());
    if (vertex.guided) {
      const Vector3 arm = x - vertex.point;
      error = std::max(error, (arm - vertex.freedom.project(arm)).norm());
    }
  }
  if (!has_equations()) return error;
  const Vector g = values(configuration(q));
  for (const Equation& equation : equations_) {
    const double scale = equation.scale.head(equation.entries() / 3).maxCoeff();
    for (Index i = 0; i < equation.count(); ++i) {
      error = std::max(error, scale * std::abs(g[equation.first_equation + i]));
    }
  }
  return error;
}

double Constraints::relative_error(const Vector& q) const {
  return has_equations() ? values(configuration(q)).cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace tetraction
