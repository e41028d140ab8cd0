#include "constraint_potential.h"

#include <Eigen/SparseCore>
#include <cmath>
#include <map>

namespace tetraction {
namespace {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// T a for each column a of free coordinates: 3 rows per vertex.
RowMatrix extend_columns(const FreeCoordinates& coordinates,
                         const Constraints::SparseMatrix& free) {
  RowMatrix rows = free;
  std::vector<Eigen::Triplet<double>> entries;
  for (Index v = 0; v < coordinates.vertex_count(); ++v) {
    const FreeCoordinates::VertexMap map = coordinates.map(v);
    for (int j = 0; j < map.count; ++j) {
      for (RowMatrix::InnerIterator entry(rows, map.first + j); entry; ++entry) {
        for (int i = 0; i < 3; ++i) {
          const double value = map.columns(i, j) * entry.value();
          if (value != 0.0)
            entries.emplace_back(static_cast<int>(3 * v) + i, static_cast<int>(entry.col()), value);
        }
      }
    }
  }
  RowMatrix extended(coordinates.dof_count(), free.cols());
  extended.setFromTriplets(entries.begin(), entries.end());
  return extended;
}

}  // namespace

void ConstraintPotential::set_stiffness(const ElasticPotential& elastic,
                                        const Vector& rest_positions, const Vector& coefficient) {
  const Constraints::SparseMatrix gradients =
      constraints_.sparse_gradients(constraints_.configuration(rest_positions));
  const Constraints::SparseMatrix free = constraints_.sparse_selector() * gradients;
  const RowMatrix moved = extend_columns(constraints_.coordinates(), free);
  Vector resistance = Vector::Zero(constraints_.equation_count());
  for (Index i = 0; i < moved.rows(); ++i) {
    for (RowMatrix::InnerIterator entry(moved, i); entry; ++entry) {
      resistance[entry.col()] += coefficient[i] * entry.value() * entry.value();
    }
  }
  const RestState& rest = elastic.rest();
  ElasticPotential::ElementTerms terms;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    std::map<Index, Vector> displacements;  // of the element's vertices, by equation
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (int i = 0; i < 3; ++i) {
        for (RowMatrix::InnerIterator entry(moved, 3 * nodes[a] + i); entry; ++entry) {
          Vector& d = displacements[entry.col()];
          if (d.size() == 0) d = Vector::Zero(3 * static_cast<Index>(nodes.size()));
          d[3 * static_cast<Index>(a) + i] = entry.value();
        }
      }
    }
    if (displacements.empty() || !elastic.element_terms(e, rest_positions, true, terms)) continue;
    for (const auto& [equation, d] : displacements) {
      resistance[equation] += d.dot(terms.hessian * d);
    }
  }
  stiffness_.resize(constraints_.equation_count());
  for (Index k = 0; k < stiffness_.size(); ++k) {
    const double square = free.col(k).squaredNorm();
    stiffness_[k] = square > 0.0 ? resistance[k] / (square * square) : 0.0;
  }
}

Vector ConstraintPotential::total_multipliers(const Vector& u) const {
  return multipliers_ - stiffness_.cwiseProduct(values(u));
}

double ConstraintPotential::value(const Vector& u) const {
  const Vector g = values(u);
  return g.dot(0.5 * stiffness_.cwiseProduct(g) - multipliers_);
}

void ConstraintPotential::add_gradient(const Vector& u, Vector& gradient) const {
  const Vector w = configuration(u);
  const Vector total = multipliers_ - stiffness_.cwiseProduct(constraints_.values(w));
  constraints_.add_vertex_forces(-(constraints_.sparse_gradients(w) * total), gradient);
}

void ConstraintPotential::add_hessian(const Vector& u, HessianForm form,
                                      HessianBlocks& hessian) const {
  constraints_.add_equation_hessian(configuration(u), stiffness_, multipliers_, form, hessian);
}

}  // namespace tetraction
