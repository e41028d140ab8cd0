#include "turning_path.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "fem/element_sums.h"

namespace tetraction {
namespace {

// ∇u at a point, for the displacements or positions u.
Matrix3 gradient(const RestState& rest, const RestElement<RestState::Shape>& point, const Vector& u,
                 Index i) {
  return rest.gather_relative(u, i) * point.gradients[0].transpose();
}

Vector3 axis_of(const Matrix3& l) {
  return 0.5 * Vector3(l(2, 1) - l(1, 2), l(0, 2) - l(2, 0), l(1, 0) - l(0, 1));
}

}  // namespace

TurningPath::Laplacian::Laplacian(const MechanicalSystem& system)
    : pattern(system.rest(), system.coordinates()), cholesky(pattern) {
  // The matrix leaves the translation of a body open that no linear constraint holds, but nothing asks for one.
  constexpr double kRoundOff = 1e-12;
  const RestState& rest = system.rest();
  const int points = rest.points_per_element();
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  ElasticPotential::ElementTerms terms;
  for (Index e = 0; e < rest.element_count(); ++e) {
    clear(rest, true, terms);
    for (int p = 0; p < points; ++p) {
      const auto point = rest.point(points * e + p);
      const Eigen::Matrix4d products =
          point.weights[0] * point.gradients[0].transpose() * point.gradients[0];
      LinearTetrahedron::DofMatrix k = LinearTetrahedron::DofMatrix::Zero();
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          k.block<3, 3>(3 * a, 3 * b) = products(a, b) * Matrix3::Identity();
        }
      }
      add_point_matrix(p, k, terms.hessian);
    }
    pattern.scatter(e, Matrix(terms.hessian), values.data());
  }
  const std::vector<int>& begin = pattern.column_begin();
  for (std::size_t j = 0; j + 1 < begin.size(); ++j) {
    values[static_cast<std::size_t>(begin[j])] *= 1.0 + kRoundOff;  // the diagonal comes first
  }
  is_factorized = cholesky.factorize(values);
}

void TurningPath::begin(const Vector& x, const Vector& d) {
  x_ = x;
  d_ = d;
  rate_ = 0.0;
  const RestState& rest = system_.rest();
  for (Index i = 0; i < rest.point_count(); ++i) {
    const auto point = rest.point(i);
    const Matrix3 l = gradient(rest, point, d_, i) * gradient(rest, point, x_, i).inverse();
    rate_ = std::max(rate_, l.norm());
  }
}

Vector TurningPath::at(double t) {
  if (!laplacian_) laplacian_ = std::make_unique<Laplacian>(system_);
  if (!laplacian_->is_factorized) return t * d_;
  const RestState& rest = system_.rest();
  const int points = rest.points_per_element();
  Vector target = Vector::Zero(x_.size());
  for (Index e = 0; e < rest.element_count(); ++e) {
    NodeGradient sum = NodeGradient::Zero(3, rest.nodes_per_element());
    for (int p = 0; p < points; ++p) {
      const Index i = points * e + p;
      const auto point = rest.point(i);
      const Matrix3 f = gradient(rest, point, x_, i);
      const Matrix3 moved = t * gradient(rest, point, d_, i);
      const Matrix3 l = moved * f.inverse();
      const Vector3 axis = axis_of(l);
      const double angle = axis.norm();
      const Matrix3 rotation = angle > 0.0
                                   ? Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix()
                                   : Matrix3(Matrix3::Identity());
      const Matrix3 stretch = Matrix3::Identity() + 0.5 * (l + l.transpose());
      const Matrix3 lack = rotation * stretch * f - f - moved;
      add_point_gradient(p, point.weights[0] * lack * point.gradients[0], sum);
    }
    Index a = 0;
    for (const Index v : rest.nodes(e)) vertex_block(target, v) += sum.col(a++);
  }
  const FreeCoordinates& free = system_.coordinates();
  return t * d_ + free.extend(laplacian_->cholesky.solve(free.restrict(target)));
}

}  // namespace tetraction
