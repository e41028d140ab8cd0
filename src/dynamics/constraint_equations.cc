// The equations g(w) = 0 of distances and free handles, with their derivatives.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "tetraction/dynamics/constraints.h"

namespace tetraction {

Vector Constraints::configuration(const Vector& q) const {
  Vector w = Vector::Zero(configuration_size_);
  for (const Equation& equation : equations_) {
    for (const auto& [v, weights] : equation.weights) {
      for (Index j = 0; j < equation.entries() / 3; ++j) {
        w.segment<3>(equation.first_entry + 3 * j) += weights[j] * q.segment<3>(3 * v);
      }
    }
  }
  return w;
}

Vector Constraints::vertex_forces(const Vector& u) const {
  Vector forces = Vector::Zero(coordinates_.dof_count());
  for (const Equation& equation : equations_) {
    for (const auto& [v, weights] : equation.weights) {
      for (Index j = 0; j < equation.entries() / 3; ++j) {
        forces.segment<3>(3 * v) += weights[j] * u.segment<3>(equation.first_entry + 3 * j);
      }
    }
  }
  return forces;
}

// All equations are of one form: g_ij = ½(w_i·w_j/s_ij − δ_ij), s_ij = ρ_iρ_j or L².
template <class Visit>
void Constraints::for_each_equation(const Visit& visit) const {
  for (const Equation& equation : equations_) {
    Index number = equation.first_equation;
    for (Index i = 0; i < equation.entries() / 3; ++i) {
      for (Index j = 0; j <= i; ++j) {
        visit(number++, equation.first_entry + 3 * i, equation.first_entry + 3 * j,
              equation.scale[i] * equation.scale[j]);
      }
    }
  }
}

Vector Constraints::values(const Vector& w) const {
  Vector g(equation_count_);
  for_each_equation([&](Index k, Index i, Index j, double s) {
    g[k] = 0.5 * (w.segment<3>(i).dot(w.segment<3>(j)) / s - (i == j ? 1.0 : 0.0));
  });
  return g;
}

Matrix Constraints::gradients(const Vector& w) const {
  Matrix gradients = Matrix::Zero(configuration_size_, equation_count_);
  for_each_equation([&](Index k, Index i, Index j, double s) {
    gradients.col(k).segment<3>(i) += 0.5 / s * w.segment<3>(j);
    gradients.col(k).segment<3>(j) += 0.5 / s * w.segment<3>(i);
  });
  return gradients;
}

Matrix Constraints::curvature(const Vector& multipliers) const {
  Matrix curvature = Matrix::Zero(configuration_size_, configuration_size_);
  for_each_equation([&](Index k, Index i, Index j, double s) {
    const double factor = 0.5 * multipliers[k] / s;
    curvature.block<3, 3>(i, j).diagonal().array() += factor;
    curvature.block<3, 3>(j, i).diagonal().array() += factor;
  });
  return curvature;
}

Vector Constraints::retract(Vector w) const {
  for (const Equation& equation : equations_) {
    const Index vectors = equation.entries() / 3;
    Matrix a(3, vectors);
    for (Index j = 0; j < vectors; ++j) {
      a.col(j) = w.segment<3>(equation.first_entry + 3 * j) / equation.scale[j];
    }
    const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Matrix u = svd.matrixU();
    // A handle never turns into its mirror image.
    if (vectors == 3 && Matrix3(u * svd.matrixV().transpose()).determinant() < 0.0)
      u.col(2) *= -1.0;
    const Matrix nearest = u * svd.matrixV().transpose();
    for (Index j = 0; j < vectors; ++j) {
      w.segment<3>(equation.first_entry + 3 * j) = equation.scale[j] * nearest.col(j);
    }
  }
  return w;
}

double Constraints::tension(std::size_t i, const Vector& u, const Vector& w) const {
  if (u.size() != configuration_size_) return 0.0;
  const Equation& equation = equations_[list_.handles.size() + i];
  const Vector3 arm = w.segment<3>(equation.first_entry);
  return 0.0 - u.segment<3>(equation.first_entry).dot(arm.normalized());
}

const std::string& Constraints::name_of_equation(Index equation) const {
  std::size_t i = 0;
  while (i + 1 < equations_.size() && equations_[i + 1].first_equation <= equation) ++i;
  return equations_[i].name;
}

}  // namespace tetraction
