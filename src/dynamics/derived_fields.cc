#include "tetraction/dynamics/derived_fields.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>

#include "core/decompositions.h"
#include "core/symmetric_tensor.h"
#include "fem/element_blocks.h"
#include "fem/element_fields.h"
#include "quadratic_element.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

// Calls body(point, F) for the points of element e.
template <class Body>
void for_each_point(const RestState& rest, Index e, const Vector& q, const Body& body) {
  const int points = rest.points_per_element();
  for (Index i = points * e; i < points * (e + 1); ++i) {
    body(i, deformation_gradient(rest, q, i));
  }
}

// The shares of the points in the volume of element e.
std::array<double, 4> shares_of(const RestState& rest, Index e) {
  if (!rest.is_quadratic()) return {1.0};
  std::array<double, 4> shares{};
  double volume = 0.0;
  for (std::size_t p = 0; p < 4; ++p) {
    shares[p] = rest.point_volume(4 * e + static_cast<Index>(p));
    volume += shares[p];
  }
  for (double& share : shares) share /= volume;
  return shares;
}

// Calls body(share of the volume, F, function that returns P) at the points of a rule for means over
// element e. With straight edges these are the points of the energy. With curved ones F varies with the
// cofactors of ∂X/∂ξ as well, and the mean of F takes a rule of degree 3 or more.
template <class Body>
void for_mean(const MechanicalSystem& system, Index e, const Vector& q, const Body& body) {
  const RestState& rest = system.rest();
  if (!is_curved(rest, e)) {
    const std::array<double, 4> shares = shares_of(rest, e);
    std::size_t p = 0;
    for_each_point(rest, e, q, [&](Index i, const Matrix3& f) {
      body(shares[p++], f, [&] { return system.first_piola(i, q); });
    });
    return;
  }
  static constexpr auto kRule = rule_of_degree_five();
  const QuadraticElement element(system, e, q);
  std::array<double, kRule.size()> volumes{};
  double sum = 0.0;
  for (std::size_t k = 0; k < kRule.size(); ++k) {
    volumes[k] = kRule[k].weight * element.rest_determinant(kRule[k].l);
    sum += volumes[k];
  }
  for (std::size_t k = 0; k < kRule.size(); ++k) {
    const Matrix3 f = element.deformation_gradient(kRule[k].l);
    body(volumes[k] / sum, f, [&] { return element.first_piola(f); });
  }
}

// √(3/2 s:s) of the deviator s of a stress with six components.
inline double von_mises_of(const double* s) {
  const double xy = s[0] - s[1];
  const double yz = s[1] - s[2];
  const double zx = s[2] - s[0];
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) +
                   3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

// The stresses of the elements with the tensions that nodal volumes add to them.
Matrix with_nodal_tensions(const MechanicalSystem& system, const Vector& q, Matrix stresses) {
  if (const NodalVolume* volume = system.nodal_volume(); volume != nullptr) {
    stresses.topRows<3>().rowwise() += volume->mean_tensions(q).transpose();
  }
  return stresses;
}

}  // namespace

Vector6 six_components(const Matrix3& s) {
  return symmetric_components(s);
}

Matrix3 cauchy_stress(const MechanicalSystem& system, Index e, const Vector& q) {
  Matrix3 mean = Matrix3::Zero();
  for_mean(system, e, q, [&](double share, const Matrix3& f, const auto& first_piola) {
    mean += share * cauchy_of(first_piola(), f);
  });
  return mean;
}

double volume_ratio(const MechanicalSystem& system, Index e, const Vector& q) {
  const RestState& rest = system.rest();
  if (!rest.is_quadratic()) return deformation_gradient(rest, q, e).determinant();
  PointEdges edges;
  for (std::size_t p = 0; p < edges.size(); ++p) {
    edges[p] = rest.gather(q, 4 * e + static_cast<Index>(p)).rightCols<3>();
  }
  return curved_volume(edges) / rest.volume(e);
}

double least_jacobian(const MechanicalSystem& system, Index e, const Vector& q) {
  double least = std::numeric_limits<double>::infinity();
  for_each_point(system.rest(), e, q, [&](Index, const Matrix3& f) {
    const double jacobian = f.determinant();
    if (!(jacobian >= least)) least = jacobian;  // also if it is not a number
  });
  return least;
}

double von_mises(const Matrix3& stress) {
  const Matrix3 deviator = stress - stress.trace() / 3.0 * Matrix3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

double von_mises(const Vector6& s) {
  return von_mises_of(s.data());
}

Matrix cauchy_stresses(const MechanicalSystem& system, const Vector& q) {
  const RestState& rest = system.rest();
  if (!rest.is_quadratic()) {
    return with_nodal_tensions(system, q, BlockAccess::cauchy_stresses(system.elastic(), q));
  }
  Matrix stresses(6, rest.element_count());
  parallel_for(stresses.cols(), 512, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      stresses.col(e) = six_components(cauchy_stress(system, e, q));
    }
  });
  return stresses;
}

Matrix von_mises_stresses(const Matrix& cauchy_stress) {
  Matrix values(1, cauchy_stress.cols());
  parallel_for(values.cols(), 4096, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) values(0, i) = von_mises_of(cauchy_stress.col(i).data());
  });
  return values;
}

Matrix green_strains(const MechanicalSystem& system, const Vector& q) {
  const RestState& rest = system.rest();
  if (!rest.is_quadratic()) return green_strains(system.elastic(), q);
  Matrix strains(6, rest.element_count());
  parallel_for(strains.cols(), 512, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      Matrix3 mean = Matrix3::Zero();
      for_mean(system, e, q, [&](double share, const Matrix3& f, const auto&) {
        mean += 0.5 * share * (f.transpose() * f - Matrix3::Identity());
      });
      strains.col(e) = six_components(mean);
    }
  });
  return strains;
}

Matrix energy_densities(const MechanicalSystem& system, const Vector& q) {
  const RestState& rest = system.rest();
  Vector of_points;
  system.elastic_energy_densities(q, of_points);
  if (!rest.is_quadratic()) return of_points.transpose();
  Matrix densities = Matrix::Zero(1, rest.element_count());
  for (Index e = 0; e < densities.cols(); ++e) {
    const std::array<double, 4> shares = shares_of(rest, e);
    for (std::size_t p = 0; p < shares.size(); ++p) {
      densities(0, e) += shares[p] * of_points[4 * e + static_cast<Index>(p)];
    }
  }
  return densities;
}

ElementFields element_fields(const MechanicalSystem& system, const Vector& q) {
  ElementFields fields;
  stresses_and_energies(system, q, fields.cauchy_stress, fields.energy_density);
  strains_and_ratios(system, q, fields.green_strain, fields.jacobian);
  fields.von_mises = von_mises_stresses(fields.cauchy_stress);
  return fields;
}

Vector volume_ratios(const MechanicalSystem& system, const Vector& q) {
  if (!system.rest().is_quadratic()) return volume_ratios(system.elastic(), q);
  Vector values(system.rest().element_count());
  parallel_for(values.size(), 512, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) values[e] = volume_ratio(system, e, q);
  });
  return values;
}

void stresses_and_energies(const MechanicalSystem& system, const Vector& q, Matrix& cauchy_stress,
                           Matrix& energy_density) {
  if (system.rest().is_quadratic()) {
    cauchy_stress = cauchy_stresses(system, q);
    energy_density = energy_densities(system, q);
    return;
  }
  Vector energies;
  cauchy_stress =
      with_nodal_tensions(system, q, BlockAccess::cauchy_stresses(system.elastic(), q, &energies));
  if (system.nodal_volume() != nullptr) system.nodal_volume()->add_energy_densities(q, energies);
  energy_density = energies.transpose();
}

void strains_and_ratios(const MechanicalSystem& system, const Vector& q, Matrix& green_strain,
                        Matrix& jacobian) {
  if (system.rest().is_quadratic()) {
    green_strain = green_strains(system, q);
    jacobian = volume_ratios(system, q).transpose();
    return;
  }
  Vector ratios;
  green_strain = green_strains(system.elastic(), q, &ratios);
  jacobian = ratios.transpose();
}

Matrix first_piola_stress(const MechanicalSystem& system, const Vector& q) {
  Matrix stress(9, system.rest().element_count());
  parallel_for(stress.cols(), 512, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) {
      Matrix3 mean = Matrix3::Zero();
      for_mean(system, e, q, [&](double share, const Matrix3&, const auto& first_piola) {
        mean += share * first_piola().transpose();
      });
      stress.col(e) = mean.reshaped();
    }
  });
  return stress;
}

Matrix principal_stresses(const Matrix& cauchy_stress) {
  Matrix principal(3, cauchy_stress.cols());
  parallel_for(principal.cols(), 512, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto s = cauchy_stress.col(i);
      Matrix3 stress;
      stress << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
      principal.col(i) = symmetric_eigen(stress).values.reverse();
    }
  });
  return principal;
}

Matrix pressures(const Matrix& cauchy_stress) {
  return -cauchy_stress.topRows(3).colwise().mean();
}

Matrix nodal_average(const MechanicalSystem& system, const Matrix& element_field) {
  const RestState& rest = system.rest();
  Matrix sum = Matrix::Zero(element_field.rows(), system.vertex_count());
  Vector volume = Vector::Zero(system.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const double element_volume = rest.volume(e);
    for (const Index v : rest.nodes(e)) {
      sum.col(v) += element_volume * element_field.col(e);
      volume[v] += element_volume;
    }
  }
  if (system.part() != nullptr) {
    system.part()->add_shared(sum.data(), sum.rows());
    system.part()->add_shared(volume.data(), 1);
  }
  return sum * volume.cwiseInverse().asDiagonal();
}

Matrix deformation_field(const MechanicalSystem& system, const Vector& q) {
  const Vector rest = system.mesh().rest_positions();
  const Vector3 rest_center = center_of_mass(system, rest);
  const Vector3 center = center_of_mass(system, q);
  Matrix3 moment = Matrix3::Zero();
  for (Index v = 0; v < system.owned_vertex_count(); ++v) {
    moment += system.mass()[v] * (vertex_block(q, v) - center) *
              (vertex_block(rest, v) - rest_center).transpose();
  }
  sum_over_parts(system.part(), moment.data(), 9);
  const Matrix3 rotation = proper_rotation(moment);
  Matrix deformation(3, system.vertex_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    deformation.col(v) =
        vertex_block(q, v) - center - rotation * (vertex_block(rest, v) - rest_center);
  }
  return deformation;
}

Displacement largest_displacement(const MechanicalSystem& system, const Vector& q) {
  const Vector moved = q - system.mesh().rest_positions();
  Displacement largest;
  largest.length =
      moved.reshaped(3, system.vertex_count()).colwise().norm().maxCoeff(&largest.vertex);
  return largest;
}

Vector3 resultant(const Vector& force) {
  Vector3 sum = Vector3::Zero();
  for (Index v = 0; v < force.size() / 3; ++v) sum += vertex_block(force, v);
  return sum;
}

}  // namespace tetraction
