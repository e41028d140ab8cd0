// The quantities of a body that frames, probes, the colours of the window and Python offer, in one table.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/dynamics/nodal_volume/volume_rule.h"

namespace tetraction {

class BodyFields;
class MechanicalSystem;
class Session;
struct State;

/// The quantities of [[probe]].
enum class ProbeQuantity {
  kDisplacement,
  kPosition,
  kVelocity,
  kMomentum,
  kForce,
  kReaction,
  kCauchyStress,
  kVonMises,
  kJacobian,
  kContactForce,
  kContactMoment
};
template <>
struct EnumNames<ProbeQuantity> {
  static constexpr std::array names{"displacement", "position",      "velocity",      "momentum",
                                    "force",        "reaction",      "cauchy_stress", "von_mises",
                                    "jacobian",     "contact_force", "contact_moment"};
};

enum class ValueShape {
  kScalar,
  kVector,
  kSymmetricTensor,  ///< six components XX YY ZZ XY YZ XZ
  kTensor,           ///< nine components, row by row
  kPrincipalValues   ///< three, the largest first
};
enum class ValueDomain { kVertices, kTetrahedra };

/// The frames that have a quantity.
enum class InFrames {
  kNone,
  kNamed,      ///< those of scenes that name it in output.fields
  kNodal,      ///< by default those of bodies with VolumeRule::kNodal, otherwise as kNamed
  kQuadratic,  ///< by default those of bodies with quadratic tetrahedra, otherwise as kNamed
  kContact,    ///< by default those of bodies that may touch obstacles, otherwise as kNamed
  kDefault     ///< all by default
};

/// A place in a tetrahedron where a quantity is evaluated.
struct ElementPlace {
  const MechanicalSystem& system;
  Index tetrahedron = 0;
  const Vector& q;  ///< positions
  /// The volume coordinates of a point. Null: the values are means over the tetrahedron.
  const std::array<double, 4>* point = nullptr;

  /// W must be defined at q.
  Matrix3 cauchy_stress() const;
  double jacobian() const;
};

/// How the window offers a quantity as a colour.
struct ColorUse {
  const char* name = nullptr;  ///< null: it does not
  int place = 0;               ///< in the list of colours, which the settings of the window store
  /// The middle of the range of colours. Without it the range begins at zero.
  std::optional<double> middle{};
};

/// One row of the table. All values come from of_body or of_vertices, those of one tetrahedron from of_element. Probes
/// of an obstacle have the forces of the session (Session::obstacle_forces()).
struct Quantity {
  const char* name = "";  ///< of the array of frames
  const char* unit = "";  ///< SI, "" for a pure number
  ValueShape shape = ValueShape::kScalar;
  ValueDomain domain = ValueDomain::kVertices;
  InFrames frames = InFrames::kNamed;
  std::optional<ProbeQuantity> probe{};  ///< needs of_vertices or of_element, or is_of_obstacle
  bool is_sum = false;          ///< whether a probe is the sum over its vertices, not the mean
  bool is_of_obstacle = false;  ///< whether a probe names an obstacle instead of a place
  ColorUse color{};             ///< of scalars, of vectors by their lengths, and of components
  bool is_integral = false;     ///< flags and numbers of regions
  bool is_relative = false;     ///< whether the rest positions are subtracted from of_vertices

  /// A vector for each vertex without a copy; empty where all are zero.
  const Vector& (*of_vertices)(const Session&) = nullptr;
  /// The components at a place.
  void (*of_element)(const ElementPlace&, double*) = nullptr;
  /// All values: components × vertices, or components × tetrahedra.
  Matrix (*of_body)(BodyFields&) = nullptr;
};

/// All quantities. Those of frames are in the order in which frames have them.
const std::vector<Quantity>& quantities();
/// Null if there is none of that name with values on the body.
const Quantity* find_quantity(const std::string& name);
/// Throws InputError, with the names that there are.
const Quantity& named_quantity(const std::string& name);
const Quantity& quantity_of(ProbeQuantity probe);
/// The endings of the names of components after the name of the quantity: "_x", "_y", "_z" for a vector, "_xx",
/// "_yy", "_zz", "_xy", "_yz", "_xz" for a symmetric tensor, and one empty text for a scalar.
const std::vector<const char*>& component_endings(ValueShape shape);

/// In a list of fields it stands for all default fields: ["default", "pressure"].
inline constexpr const char* kDefaultFields = "default";

/// The quantities that frames can have, in their order.
std::vector<const Quantity*> frame_quantities();
/// Those that a list of names, as OutputSettings::fields, chooses. An empty list chooses the default ones
/// of a body with this rule, linear or quadratic tetrahedra, and with or without obstacles.
std::vector<const Quantity*> chosen_quantities(const std::vector<std::string>& names,
                                               VolumeRule volume, bool is_quadratic,
                                               bool has_contact);
/// The quantities by which the window colours a body, in its order.
const std::vector<const Quantity*>& color_quantities();
/// The quantity whose values are drawn for a colour: where quadratic tetrahedra have values at their vertices
/// ("NAME_nodal"), these, because strain and stress vary inside them.
const Quantity& drawn_quantity(const Quantity& color, bool is_quadratic);

/// The values at the present state of a session: components × vertices, or components × tetrahedra. Loops over
/// the tetrahedra serve all quantities together. Collective for a body in parts.
std::vector<Matrix> values_of(const Session& session, const std::vector<const Quantity*>& list);
/// The values of one quantity, which take less time alone.
Matrix values_of(const Session& session, const Quantity& quantity);
/// The same at another state of the body, with the present materials. Forces are those of the session.
Matrix values_of(const Session& session, const Quantity& quantity, const State& state);

}  // namespace tetraction
