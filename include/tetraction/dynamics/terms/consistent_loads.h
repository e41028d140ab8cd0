// Forces on vertices that are equivalent to loads on surfaces and volumes.
#pragma once

#include <array>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/terms/external_forces.h"

namespace tetraction {

/// The vertices over which a load is distributed, each with its part of a surface (m²), of a mass
/// (kg) or of a number.
struct LoadDistribution {
  std::vector<Index> vertices;  ///< sorted, each once
  Vector weights;
  SharedMeshPart part{};  ///< of the mesh; its vertices have the weights of the whole mesh

  /// The sum of the weights of the whole mesh.
  double total() const;
};

/// ∫ N_v dA at rest over the triangles for their nodes v, m². That is a third of the area at each vertex of a
/// linear triangle; of a quadratic one with straight edges, a third at each middle of an edge and nothing
/// at the corners. Curved faces have a rule of degree 14: exact in a plane, where N_v dA has degree 4.
LoadDistribution surface_distribution(const TetMesh& mesh,
                                      const std::vector<std::array<Index, 3>>& triangles);
/// The volume at rest of each tetrahedron, m³, at its nodes as MechanicalSystem::element_weights()
/// says: a quarter at each vertex of a linear one.
LoadDistribution volume_distribution(const MechanicalSystem& system,
                                     const std::vector<Index>& tetrahedra);
/// The same for the mass of each tetrahedron, kg.
LoadDistribution mass_distribution(const MechanicalSystem& system,
                                   const std::vector<Index>& tetrahedra);
/// The weight 1 at each vertex. `part`: that of their mesh.
LoadDistribution equal_distribution(std::vector<Index> vertices, SharedMeshPart part = nullptr);

/// The force w_v `density` on every vertex v: a traction (Pa) with weights in m², a body force
/// (N/m³) with weights in m³, an acceleration (m/s²) with weights in kg. For constant densities
/// these are the consistent forces of linear tetrahedra.
ExternalForce distributed_force(const LoadDistribution& distribution, const Vector3& density);

/// Forces with the sum `total`, N: the force w_v/Σw `total` on every vertex.
ExternalForce shared_force(const LoadDistribution& distribution, const Vector3& total);

/// Forces without a resultant, whose moment in the rest configuration is `moment`, N m: the force
/// w_v θ × r_v on every vertex, with r_v from the weighted mean of the rest positions, and θ so that
/// Σ r_v × f_v is the moment. Throws InputError if the vertices cannot carry it: a single vertex, or
/// a moment about the line on which all vertices are.
ExternalForce shared_moment(const LoadDistribution& distribution, const TetMesh& mesh,
                            const Vector3& moment);

}  // namespace tetraction
