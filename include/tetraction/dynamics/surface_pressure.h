// Pressure on parts of a body's boundary. It follows the deformation.
#pragma once

#include <array>
#include <vector>

#include "tetraction/dynamics/amplitude.h"
#include "tetraction/dynamics/force_term.h"
#include "tetraction/fem/free_coordinates.h"

namespace tetraction {

/// A pressure p on triangles of the boundary. The force on a triangle is −p times its present area
/// times its present outward normal; a third of it acts on each of its vertices.
struct PressureLoad {
  std::vector<std::array<Index, 3>> triangles;  ///< outward, each once
  double value = 0.0;                           ///< p, Pa; positive values push inwards
  LoadHistory history;
};

/// All pressures on a body.
///
/// With the volume V_o(x) = Σ (a − o)·((b − o) × (c − o))/6 of the cones from a point o to the
/// triangles (a, b, c), the force of a pressure is −p ∂V_o/∂x plus forces on the vertices of the
/// rim of its surface. So it has the potential U = p V_o, except for the forces on the rim:
/// −p (u − o) × (w − o)/6 on both ends of each edge u → w of the rim. A closed surface has no rim.
/// The forces on a rim do not move the body where its vertices are held, or where they may only
/// move in a plane through o. The point o is therefore put into the planes in which the vertices of
/// the rim are held. Otherwise the forces on the rim enter as loads that depend on
/// positions (ForceTerm::add_load()). The sum of all forces of a closed surface is zero
/// up to round-off.
///
/// The decrease of U counts as external work, together with what the dependence of p on the time
/// adds. In a step p is its mean over the step.
class SurfacePressure : public ForceTerm {
 public:
  SurfacePressure() = default;
  /// `rest`: rest positions, 3 per vertex, m. `coordinates`: what the vertices may do.
  SurfacePressure(std::vector<PressureLoad> loads, const Vector& rest,
                  const FreeCoordinates& coordinates);

  const std::vector<PressureLoad>& list() const { return loads_; }

  std::string name() const override { return "surface_pressure"; }
  EnergyAccount account() const override { return EnergyAccount::kExternalWork; }
  bool has_potential() const override { return !loads_.empty(); }
  bool has_load() const override;
  bool load_depends_on_position() const override { return true; }
  bool couples_vertices() const override { return !loads_.empty(); }
  bool couples_only_neighbors() const override { return true; }
  double energy(const ForcePoint& at) const override;
  double energy_change(const ForcePoint& from, const ForcePoint& to) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override;
  /// V_o is of the third degree in the positions, so that ΔV_o = ∇V_o(m)·Δq + 2 V_0(Δq/2) with the
  /// midpoint m and the volume V_0 of cones from 0. The second part becomes a force on the vertices of
  /// each triangle. If the surface is closed, it is a force along the part of Δq that is not a rigid
  /// motion, so that the pressure changes neither momentum.
  void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                             Vector& gradient) const override;
  void add_load(const ForcePoint& at, Vector& force) const override;
  void add_load_stiffness(const ForcePoint& at, HessianBlocks& stiffness) const override;

 private:
  // What belongs to each load.
  struct Surface {
    Vector3 origin = Vector3::Zero();       // o
    std::vector<std::array<Index, 2>> rim;  // directed as the triangles are
  };
  // V_o(to) − V_o(from) without cancellation of the volumes.
  double volume_change(std::size_t load, const Vector& from, const Vector& to) const;

  std::vector<PressureLoad> loads_;
  std::vector<Surface> surfaces_;
};

}  // namespace tetraction
