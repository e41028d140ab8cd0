// The equations g(w) = 0 of distances and free handles, with their derivatives.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/decompositions.h"
#include "tetraction/core/error.h"
#include "tetraction/core/positive_semidefinite.h"
#include "tetraction/dynamics/constraints/constraints.h"

namespace tetraction {
namespace {

// Some rank + 1 vertices of an affine set, and α with w_j = Σ_a α_ja q_a for positions of the set. Each vertex is the
// one farthest from the flat that those before it span.
std::vector<std::pair<Index, Vector3>> carriers_of(const AffineSet& set) {
  const Index rank = set.rank();
  const Index count = set.coordinates.cols();
  Matrix rest(rank + 1, count);  // of (1, ξ), apart from what the chosen vertices span
  rest << Eigen::RowVectorXd::Ones(count), set.coordinates;
  const Matrix all = rest;
  std::vector<Index> chosen;
  Matrix square(rank + 1, rank + 1);
  for (Index i = 0; i <= rank; ++i) {
    Index best = 0;
    rest.colwise().squaredNorm().maxCoeff(&best);
    chosen.push_back(best);
    square.col(i) = all.col(best);
    const Vector direction = rest.col(best).normalized();
    rest -= direction * (direction.transpose() * rest).eval();
  }
  const Matrix inverse = square.inverse();
  std::vector<std::pair<Index, Vector3>> carriers;
  for (Index i = 0; i <= rank; ++i) {
    Vector3 weights = Vector3::Zero();
    weights.head(rank) = inverse.row(i).tail(rank).transpose();
    carriers.emplace_back(
        set.vertices[static_cast<std::size_t>(chosen[static_cast<std::size_t>(i)])], weights);
  }
  return carriers;
}

}  // namespace

std::vector<AffineSet> Constraints::add_handles(const std::map<Index, Prescribed>& vertices,
                                                const TetMesh& mesh) {
  std::vector<AffineSet> sets;
  std::map<Index, const std::string*> owner;
  for (const RigidHandle& handle : list_.handles) {
    const auto count = static_cast<Index>(handle.vertices.size());
    double total = 0.0;
    Vector3 center = Vector3::Zero();
    for (Index i = 0; i < count; ++i) {
      const Index v = handle.vertices[static_cast<std::size_t>(i)];
      const bool held = vertices.count(v) > 0;
      if (held || owner.count(v) > 0) {
        throw InputError(fmt::format(
            "{}: vertex {} is already {}. The vertices of a rigid handle cannot be constrained in "
            "another way: let only one of them select it.",
            handle.name, mesh.vertex_id(v), held ? "fixed or guided" : "in " + *owner[v]));
      }
      owner[v] = &handle.name;
      total += mass_[v];
      center += mass_[v] * handle.shape.col(i);
    }
    center /= total;
    Matrix3 moment = Matrix3::Zero();
    for (Index i = 0; i < count; ++i) {
      const Vector3 arm = handle.shape.col(i) - center;
      moment += mass_[handle.vertices[static_cast<std::size_t>(i)]] / total * arm * arm.transpose();
    }
    // Radii of gyration along the principal axes, largest first; flat directions have none.
    constexpr double kFlat = 1e-6;  // round-off in the squares is of the order of 1e-8
    const SymmetricEigen3 axes = symmetric_eigen(moment);
    Matrix3 directions;  // right-handed, so that w never has to be a mirror image
    directions.col(0) = axes.vectors.col(2);
    directions.col(1) = axes.vectors.col(1);
    directions.col(2) = directions.col(0).cross(directions.col(1));
    const double largest = std::sqrt(std::max(0.0, axes.values[2]));
    int rank = 0;
    while (rank < 3 && std::sqrt(std::max(0.0, axes.values[2 - rank])) > kFlat * largest) {
      ++rank;
    }
    if (rank == 0) {
      throw InputError(fmt::format(
          "{}: all its vertices are in one place: a rigid handle needs two or more.", handle.name));
    }

    Equation equation;
    equation.first_entry = configuration_size_;
    equation.first_equation = equation_count_;
    equation.rank = rank;
    equation.name = handle.name;
    AffineSet set;
    set.vertices = handle.vertices;
    set.coordinates.resize(rank, count);
    for (Index i = 0; i < count; ++i) {
      const Index v = handle.vertices[static_cast<std::size_t>(i)];
      Vector3 weights = Vector3::Zero();
      for (int j = 0; j < rank; ++j) {
        const double radius = std::sqrt(axes.values[2 - j]);
        equation.scale[j] = radius;
        set.coordinates(j, i) = directions.col(j).dot(handle.shape.col(i) - center) / radius;
        weights[j] = mass_[v] / total * set.coordinates(j, i);
      }
      equation.weights.emplace_back(v, weights);
    }
    equation.carriers = carriers_of(set);
    configuration_size_ += equation.entries();
    equation_count_ += equation.count();
    equations_.push_back(std::move(equation));
    sets.push_back(std::move(set));
  }
  return sets;
}

void Constraints::add_distances(const TetMesh& mesh) {
  for (const FixedDistance& distance : list_.distances) {
    if (distance.a == distance.b || !(distance.length > 0.0) || !std::isfinite(distance.length)) {
      throw InputError(fmt::format(
          "{}: a distance must be kept between two different vertices and be above 0; between {} "
          "and {} it is {} m.",
          distance.name, mesh.vertex_id(distance.a), mesh.vertex_id(distance.b), distance.length));
    }
    Equation equation;
    equation.first_entry = configuration_size_;
    equation.first_equation = equation_count_;
    equation.scale[0] = distance.length;
    equation.weights = {{distance.a, Vector3::UnitX()}, {distance.b, -Vector3::UnitX()}};
    equation.carriers = equation.weights;
    equation.name = distance.name;
    configuration_size_ += equation.entries();
    equation_count_ += equation.count();
    equations_.push_back(std::move(equation));
  }
}

void Constraints::set_distance_length(std::size_t i, double length) {
  FixedDistance& distance = list_.distances.at(i);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw InputError(
        fmt::format("{}: the length must be above 0 and finite, not {} m.", distance.name, length));
  }
  distance.length = length;
  equations_[list_.handles.size() + i].scale[0] = length;
}

void Constraints::make_selector() {
  std::vector<Eigen::Triplet<double>> entries;
  Vector force = Vector::Zero(coordinates_.dof_count());
  for (const Equation& equation : equations_) {
    for (Index i = 0; i < equation.entries(); ++i) {
      const Index j = i / 3;
      for (const auto& [v, weights] : equation.weights) force[3 * v + i % 3] = weights[j];
      const Vector column = coordinates_.restrict(force);
      for (const auto& [v, weights] : equation.weights) force[3 * v + i % 3] = 0.0;
      for (Index row = 0; row < column.size(); ++row) {
        if (column[row] != 0.0) {
          entries.emplace_back(static_cast<int>(row), static_cast<int>(equation.first_entry + i),
                               column[row]);
        }
      }
    }
  }
  selector_.resize(coordinates_.count(), configuration_size_);
  selector_.setFromTriplets(entries.begin(), entries.end());
  reduced_mass_ = coordinates_.reduced_mass(mass_);
  const SparseMatrix weighted = reduced_mass_.cwiseInverse().asDiagonal() * selector_;
  inverse_mass_ = SparseMatrix(selector_.transpose()) * weighted;
}

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
  add_vertex_forces(u, forces);
  return forces;
}

void Constraints::add_vertex_forces(const Vector& u, Vector& forces) const {
  for (const Equation& equation : equations_) {
    for (const auto& [v, weights] : equation.weights) {
      for (Index j = 0; j < equation.entries() / 3; ++j) {
        forces.segment<3>(3 * v) += weights[j] * u.segment<3>(equation.first_entry + 3 * j);
      }
    }
  }
}

// All equations are of one form: g_ij = ½(w_i·w_j/s_ij − δ_ij), s_ij = ρ_iρ_j or L².
template <class Visit>
void Constraints::for_each_equation(const Visit& visit) const {
  for (const Equation& equation : equations_) visit_equations(equation, visit);
}

template <class Visit>
void Constraints::visit_equations(const Equation& equation, const Visit& visit) {
  Index number = equation.first_equation;
  for (Index i = 0; i < equation.entries() / 3; ++i) {
    for (Index j = 0; j <= i; ++j) {
      visit(number++, equation.first_entry + 3 * i, equation.first_entry + 3 * j,
            equation.scale[i] * equation.scale[j]);
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
  return sparse_gradients(w);
}

Constraints::SparseMatrix Constraints::sparse_gradients(const Vector& w) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](Index k, Index at, const Vector3& values) {
    for (int c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<int>(at) + c, static_cast<int>(k), values[c]);
    }
  };
  for_each_equation([&](Index k, Index i, Index j, double s) {
    add(k, i, 0.5 / s * w.segment<3>(j));
    add(k, j, 0.5 / s * w.segment<3>(i));
  });
  SparseMatrix gradients(configuration_size_, equation_count_);
  gradients.setFromTriplets(entries.begin(), entries.end());
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

void Constraints::add_equation_hessian(const Vector& w, const Vector& stiffness,
                                       const Vector& multipliers, HessianForm form,
                                       HessianBlocks& hessian) const {
  for (const Equation& equation : equations_) {
    const Index size = equation.entries();
    const Index begin = equation.first_entry;
    Matrix block = Matrix::Zero(size, size);
    visit_equations(equation, [&](Index k, Index i, Index j, double s) {
      Vector gradient = Vector::Zero(size);
      gradient.segment<3>(i - begin) += 0.5 / s * w.segment<3>(j);
      gradient.segment<3>(j - begin) += 0.5 / s * w.segment<3>(i);
      const double value = 0.5 * (w.segment<3>(i).dot(w.segment<3>(j)) / s - (i == j ? 1.0 : 0.0));
      block += stiffness[k] * gradient * gradient.transpose();
      const double curvature = 0.5 / s * (stiffness[k] * value - multipliers[k]);
      block.block<3, 3>(i - begin, j - begin).diagonal().array() += curvature;
      block.block<3, 3>(j - begin, i - begin).diagonal().array() += curvature;
    });
    if (form == HessianForm::kConvex) block = positive_semidefinite_part(block);
    for (std::size_t a = 0; a < equation.carriers.size(); ++a) {
      const auto& [row, row_weights] = equation.carriers[a];
      for (std::size_t b = 0; b <= a; ++b) {
        const auto& [column, column_weights] = equation.carriers[b];
        Matrix3 sum = Matrix3::Zero();
        for (Index i = 0; i < size / 3; ++i) {
          for (Index j = 0; j < size / 3; ++j) {
            sum += row_weights[i] * column_weights[j] * block.block<3, 3>(3 * i, 3 * j);
          }
        }
        if (a == b) {
          hessian.add(row, sum);
        } else {
          hessian.add_pair(row, column, sum);
        }
      }
    }
  }
}

Vector Constraints::retract(Vector w) const {
  for (const Equation& equation : equations_) {
    const Index vectors = equation.entries() / 3;
    Matrix a(3, vectors);
    for (Index j = 0; j < vectors; ++j) {
      a.col(j) = w.segment<3>(equation.first_entry + 3 * j) / equation.scale[j];
    }
    const SingularVectors singular = singular_vectors(a);
    Matrix u = singular.u.leftCols(vectors);
    // A handle never turns into its mirror image.
    if (vectors == 3 && Matrix3(u * singular.v.transpose()).determinant() < 0.0) u.col(2) *= -1.0;
    const Matrix nearest = u * singular.v.transpose();
    for (Index j = 0; j < vectors; ++j) {
      w.segment<3>(equation.first_entry + 3 * j) = equation.scale[j] * nearest.col(j);
    }
  }
  return w;
}

Vector Constraints::configuration_lengths() const {
  Vector lengths(configuration_size_);
  for (const Equation& equation : equations_) {
    for (Index j = 0; j < equation.entries() / 3; ++j) {
      lengths.segment<3>(equation.first_entry + 3 * j).setConstant(equation.scale[j]);
    }
  }
  return lengths;
}

Constraints::Units Constraints::units_of(const Vector& response) const {
  const Vector lengths = configuration_lengths();
  Units units{lengths, Vector(equation_count_)};
  for (Index i = 0; i < configuration_size_; i += 3) {
    // The three components of a vector share one unit, because a component of it may be small by
    // intention.
    const double most = response.segment<3>(i).maxCoeff();
    if (most > 0.0) units.displacement.segment<3>(i).setConstant(std::sqrt(most));
  }
  const Vector strains = units.displacement.cwiseQuotient(lengths);
  for_each_equation([&](Index k, Index i, Index j, double) {
    units.multiplier[k] = 1.0 / std::max(strains[i], strains[j]);
  });
  return units;
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
