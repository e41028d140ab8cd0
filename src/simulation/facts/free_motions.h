// The motions without strain that nothing restrains: of bodies as a whole, and of pieces of a mechanism.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/state.h"

namespace tetraction {

/// A part of the body whose pieces touch only in edges and vertices and can turn against each other.
struct Mechanism {
  Index vertex = 0;             ///< its first vertex
  std::size_t pieces = 0;       ///< that hang together through faces (mesh/mesh_pieces.h)
  Index motions = 0;            ///< of the pieces against each other, without supports
  Index free_motions = 0;       ///< those that the supports leave
  std::vector<Index> joints{};  ///< vertices at which pieces turn
  std::string place{};          ///< of the joints, for messages
};

struct FreeMotions {
  std::size_t parts = 0;           ///< that do not touch each other
  std::size_t pieces = 0;          ///< that hang together through faces
  std::vector<std::string> whole;  ///< "move along x", …: free motions of parts as rigid bodies
  std::vector<Mechanism> mechanisms;  ///< also those that the supports hold
  /// Whether every part was examined. Parts of more than JointedPieces::kMost pieces are not, and none of
  /// a body of more than 1,000 parts.
  bool is_complete = true;
};

/// The free motions of the undeformed body, with the potentials of force terms at `time`. Uniform fields
/// and dead loads restrain nothing. By default obstacles count as supports that the body may come to touch, as in
/// an equilibrium.
FreeMotions find_free_motions(const MechanicalSystem& system, double time = 0.0,
                              Contact::Support support = Contact::Support::kPossible);
/// Motions that the body has beside the obstacles that it touches at these positions, in words, or nothing if it is held
/// or there are no obstacles.
std::vector<std::string> motions_beside_obstacles(const MechanicalSystem& system, const State& at,
                                                  double time);

/// The free motions of a mechanism, as the end of the sentence "the body can still …".
std::string mechanism_text(const Mechanism& mechanism);

/// A warning of mechanisms whose pieces can move. Empty if there are none.
std::string mechanism_warning(const FreeMotions& motions);

}  // namespace tetraction
