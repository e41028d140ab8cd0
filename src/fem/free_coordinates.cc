#include "tetraction/fem/free_coordinates.h"

#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {

FreeCoordinates::FreeCoordinates(Index vertex_count) : FreeCoordinates(vertex_count, {}) {}

FreeCoordinates::FreeCoordinates(Index vertex_count, std::map<Index, VertexFreedom> freedoms,
                                 std::vector<AffineSet> sets)
    : kind_(static_cast<std::size_t>(vertex_count), kFree),
      first_(static_cast<std::size_t>(vertex_count), -1),
      freedoms_(std::move(freedoms)),
      sets_(std::move(sets)) {
  if (vertex_count > std::numeric_limits<int>::max() / 3) {
    throw InputError("The mesh has more than 2^31 degrees of freedom: that is not supported.");
  }
  for (const auto& [v, freedom] : freedoms_) {
    kind_[static_cast<std::size_t>(v)] =
        freedom.count == 0 ? kFullyPrescribed : (freedom.count == 3 ? kFree : kPartlyPrescribed);
  }
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    for (std::size_t i = 0; i < sets_[s].vertices.size(); ++i) {
      const Index v = sets_[s].vertices[i];
      if (kind_[static_cast<std::size_t>(v)] != kFree) {
        throw InputError(
            "A vertex of an affine set has a prescribed displacement or is in another set.");
      }
      kind_[static_cast<std::size_t>(v)] = kAffine;
      member_[v] = {static_cast<Index>(s), static_cast<Index>(i)};
    }
  }
  int next = 0;
  for (std::size_t v = 0; v < kind_.size(); ++v) {
    if (kind_[v] == kFullyPrescribed || kind_[v] == kAffine) continue;
    first_[v] = next;
    next += kind_[v] == kFree ? 3 : freedoms_.at(static_cast<Index>(v)).count;
  }
  for (const AffineSet& set : sets_) {
    set_first_.push_back(next);
    next += 3 * (1 + set.rank());
  }
  count_ = next;
}

Index FreeCoordinates::set_of(Index vertex) const {
  const auto found = member_.find(vertex);
  return found == member_.end() ? -1 : found->second.first;
}

FreeCoordinates::VertexMap FreeCoordinates::map(Index vertex) const {
  const auto v = static_cast<std::size_t>(vertex);
  VertexMap map;
  switch (kind_[v]) {
    case kFree:
      map.first = first_[v];
      map.count = 3;
      map.columns = Matrix3::Identity();
      break;
    case kPartlyPrescribed: {
      const VertexFreedom& freedom = freedoms_.at(vertex);
      map.first = first_[v];
      map.count = freedom.count;
      map.columns = freedom.basis.leftCols(freedom.count);
      break;
    }
    case kFullyPrescribed:
      map.columns.resize(3, 0);
      break;
    case kAffine: {
      const auto [s, index] = member_.at(vertex);
      const AffineSet& set = sets_[static_cast<std::size_t>(s)];
      map.first = first_of_set(s);
      map.count = 3 * (1 + set.rank());
      map.columns.resize(3, map.count);
      map.columns.leftCols<3>().setIdentity();
      for (int j = 0; j < set.rank(); ++j) {
        map.columns.middleCols<3>(3 * (j + 1)) = set.coordinates(j, index) * Matrix3::Identity();
      }
      break;
    }
  }
  return map;
}

Vector FreeCoordinates::restrict(const Vector& full) const {
  Vector free = Vector::Zero(count_);
  for (std::size_t v = 0; v < kind_.size(); ++v) {
    const Index vertex = static_cast<Index>(v);
    if (kind_[v] == kFree) {
      free.segment<3>(first_[v]) = full.segment<3>(3 * vertex);
    } else if (kind_[v] == kPartlyPrescribed) {
      const VertexFreedom& freedom = freedoms_.at(vertex);
      for (int i = 0; i < freedom.count; ++i) {
        free[first_[v] + i] = freedom.basis.col(i).dot(full.segment<3>(3 * vertex));
      }
    }
  }
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    const AffineSet& set = sets_[s];
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      const Vector3 force = full.segment<3>(3 * set.vertices[i]);
      free.segment<3>(set_first_[s]) += force;
      for (int j = 0; j < set.rank(); ++j) {
        free.segment<3>(set_first_[s] + 3 * (j + 1)) +=
            set.coordinates(j, static_cast<Index>(i)) * force;
      }
    }
  }
  return free;
}

double FreeCoordinates::restricted_norm(const Vector& full) const {
  double sum = parallel_sum(vertex_count(), [&](Index begin, Index end) {
    double part = 0.0;
    for (Index v = begin; v < end; ++v) {
      if (is_free(v)) part += full.segment<3>(3 * v).squaredNorm();
    }
    return part;
  });
  if (freedoms_.empty() && sets_.empty()) return std::sqrt(sum);
  for (const auto& [v, freedom] : freedoms_) {
    if (is_free(v)) continue;
    for (int i = 0; i < freedom.count; ++i) {
      const double part = freedom.basis.col(i).dot(full.segment<3>(3 * v));
      sum += part * part;
    }
  }
  for (const AffineSet& set : sets_) {
    Eigen::Matrix<double, 3, 4> forces = Eigen::Matrix<double, 3, 4>::Zero();
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      const Vector3 force = full.segment<3>(3 * set.vertices[i]);
      forces.col(0) += force;
      for (int j = 0; j < set.rank(); ++j) {
        forces.col(j + 1) += set.coordinates(j, static_cast<Index>(i)) * force;
      }
    }
    sum += forces.squaredNorm();
  }
  return std::sqrt(sum);
}

Vector FreeCoordinates::extend(const Vector& free) const {
  Vector full = Vector::Zero(dof_count());
  for (std::size_t v = 0; v < kind_.size(); ++v) {
    const Index vertex = static_cast<Index>(v);
    if (kind_[v] == kFree) {
      full.segment<3>(3 * vertex) = free.segment<3>(first_[v]);
    } else if (kind_[v] == kPartlyPrescribed) {
      const VertexFreedom& freedom = freedoms_.at(vertex);
      for (int i = 0; i < freedom.count; ++i) {
        full.segment<3>(3 * vertex) += free[first_[v] + i] * freedom.basis.col(i);
      }
    }
  }
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    const AffineSet& set = sets_[s];
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      Vector3 d = free.segment<3>(set_first_[s]);
      for (int j = 0; j < set.rank(); ++j) {
        d += set.coordinates(j, static_cast<Index>(i)) *
             free.segment<3>(set_first_[s] + 3 * (j + 1));
      }
      full.segment<3>(3 * set.vertices[i]) = d;
    }
  }
  return full;
}

Vector FreeCoordinates::reduced_mass(const Vector& mass) const {
  Vector reduced(count_);
  for (std::size_t v = 0; v < kind_.size(); ++v) {
    if (kind_[v] == kFullyPrescribed || kind_[v] == kAffine) continue;
    const Index vertex = static_cast<Index>(v);
    const int count = kind_[v] == kFree ? 3 : freedoms_.at(vertex).count;
    reduced.segment(first_[v], count).setConstant(mass[vertex]);
  }
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    double total = 0.0;
    for (const Index v : sets_[s].vertices) total += mass[v];
    reduced.segment(set_first_[s], 3 * (1 + sets_[s].rank())).setConstant(total);
  }
  return reduced;
}

void FreeCoordinates::project_momentum(const Vector& mass, Vector& momentum) const {
  for (const auto& [v, freedom] : freedoms_) {
    const Vector3 p = momentum.segment<3>(3 * v);
    momentum.segment<3>(3 * v) = freedom.project(p);
  }
  for (const AffineSet& set : sets_) {
    double total = 0.0;
    Matrix generalised_momentum = Matrix::Zero(3, 1 + set.rank());
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      const Index v = set.vertices[i];
      const Vector3 p = momentum.segment<3>(3 * v);
      total += mass[v];
      generalised_momentum.col(0) += p;
      for (int j = 0; j < set.rank(); ++j) {
        generalised_momentum.col(j + 1) += set.coordinates(j, static_cast<Index>(i)) * p;
      }
    }
    for (std::size_t i = 0; i < set.vertices.size(); ++i) {
      const Index v = set.vertices[i];
      Vector3 rate = generalised_momentum.col(0);
      for (int j = 0; j < set.rank(); ++j) {
        rate += set.coordinates(j, static_cast<Index>(i)) * generalised_momentum.col(j + 1);
      }
      momentum.segment<3>(3 * v) = mass[v] / total * rate;
    }
  }
}

void FreeCoordinates::project_velocity(const Vector& mass, Vector& velocity) const {
  // v ← M⁻¹ P M v with the projection P of momenta. Only the vertices that P may change are scaled
  // by their masses, so that the velocities of free vertices stay bitwise the same.
  for (const auto& [v, freedom] : freedoms_) velocity.segment<3>(3 * v) *= mass[v];
  for (const auto& [v, membership] : member_) velocity.segment<3>(3 * v) *= mass[v];
  project_momentum(mass, velocity);
  for (const auto& [v, freedom] : freedoms_) velocity.segment<3>(3 * v) /= mass[v];
  for (const auto& [v, membership] : member_) velocity.segment<3>(3 * v) /= mass[v];
}

}  // namespace tetraction
