// Prescribed vertices and the motions that are prescribed to them.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/terms/amplitude.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The motion of a prescribed vertex, x(t) = c + v τ + R(ω τ)(x₀ − c) + a(t) d. Without an amplitude
/// of the velocities τ = t − since, otherwise τ is the integral of that amplitude since then.
struct PrescribedMotion {
  double since = 0.0;                          ///< s
  Vector3 velocity = Vector3::Zero();          ///< v, m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< ω, rad/s
  Vector3 center = Vector3::Zero();            ///< c at τ = 0, m
  Vector3 offset = Vector3::Zero();            ///< d, m
  /// Factor of the velocities. Null: 1.
  std::shared_ptr<const Amplitude> velocity_amplitude = nullptr;
  /// a(t), the factor of the offset. Null: 0.
  std::shared_ptr<const Amplitude> offset_amplitude = nullptr;

  bool at_rest() const {
    return velocity.isZero(0.0) && angular_velocity.isZero(0.0) && !offset_amplitude;
  }
  /// τ, s.
  double elapsed(double time) const;
  Vector3 position(const Vector3& start, double time) const;
  Vector3 rate(const Vector3& start, double time) const;
};

/// Vertices whose named components are prescribed, exactly or by springs.
struct PrescribedVertices {
  std::vector<Index> vertices;
  std::array<bool, 3> components{true, true, true};
  Matrix start;  ///< 3 × vertices: positions at motion.since, m
  PrescribedMotion motion;
  /// 0 if the displacement is prescribed exactly. Otherwise γ of the penalty force −2γ(q − target),
  /// N/m.
  double penalty = 0.0;
  std::string name;  ///< for messages
};

/// Prescribes all components of the vertices to stay at their rest positions.
PrescribedVertices prescribe_at_rest(const TetMesh& mesh, std::vector<Index> vertices,
                                     std::string name = {});

}  // namespace tetraction
