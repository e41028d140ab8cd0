// Pressure on parts of a body's boundary. It follows the deformation.
#pragma once

#include <array>
#include <vector>

#include "tetraction/dynamics/terms/amplitude.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/fem/free_coordinates.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// A pressure p on faces of the boundary: the force −p n dA on each part of the surface, with the
/// present outward normal n and the present area dA. A third of the force on a triangle acts on each
/// of its vertices. On the faces of quadratic elements the force on node a is −p ∫ N_a n dA with the
/// six shape functions, exact for curved faces, too.
struct PressureLoad {
  std::vector<std::array<Index, 3>> triangles;  ///< outward, each once
  double value = 0.0;                           ///< p, Pa; positive values push inwards
  LoadHistory history;
  /// Faces of quadratic elements: outward corners 0, 1, 2 and the middles of the edges 01, 12, 20.
  std::vector<std::array<Index, 6>> quadratic_faces{};
};

/// The load of p = 0 on outward faces of the mesh, which are given by their corners.
PressureLoad pressure_on(const TetMesh& mesh, const std::vector<std::array<Index, 3>>& faces);

/// All pressures on a body.
///
/// With the volume V_o(x) = Σ w (a − o)·((b − o) × (c − o))/6 of the cones from a point o to the
/// triangles (a, b, c) of weight w = 1, the force of a pressure is −p ∂V_o/∂x plus forces on the
/// vertices of the rim of its surface. So it has the potential U = p V_o, except for the forces on the
/// rim: −p (u − o) × (v − o)/6 on both ends of each edge u → v of the rim. A closed surface has no
/// rim. The volume under a face of six nodes has the same form with 20 weighted triangles between its
/// nodes, and the forces on a curved edge of a rim with products of each two of its three nodes.
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
  void add_load_stiffness(const ForcePoint& at, LoadStiffness& stiffness) const override;

 private:
  // Part of V_o: three nodes and the weight of their cone.
  struct Triangle {
    std::array<Index, 3> vertices;
    double weight = 1.0;
  };
  // The vector w (u − o) × (v − o)/6 at a vertex, for two nodes u and v of an edge of the rim.
  struct RimTerm {
    Index vertex;
    Index u, v;
    double weight = 1.0;
  };
  // The data of each load.
  struct Surface {
    std::vector<Triangle> triangles;
    std::vector<RimTerm> of_gradient;  // Σ w n A/3 of the triangles, minus ∂V_o/∂x
    std::vector<RimTerm> of_load;      // ∫ N n dA − ∂V_o/∂x
    Vector3 origin = Vector3::Zero();  // o
  };
  static std::vector<Triangle> triangles_of(const PressureLoad& load);
  static void add_rim(const PressureLoad& load, Surface& surface);
  static Vector3 origin_of(const Surface& surface, const Vector& rest,
                           const FreeCoordinates& coordinates);
  static Vector3 rim_vector(const RimTerm& term, const Vector3& o, const Vector& x);
  // V_o at positions x.
  static double cone_volume(const Surface& surface, const Vector3& o, const Vector& x);
  // V_o(to) − V_o(from) without cancellation of the volumes.
  static double cone_volume_change(const Surface& surface, const Vector3& o, const Vector& from,
                                   const Vector& to);

  std::vector<PressureLoad> loads_;
  std::vector<Surface> surfaces_;
};

}  // namespace tetraction
