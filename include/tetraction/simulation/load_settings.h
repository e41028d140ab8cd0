// The loads of a scene, as plain data.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {

/// The kinds of loads. Each is a section of a scene: [[force]], [[moment]], [[traction]],
/// [[pressure]], [[body_force]].
enum class LoadKind { kForce, kMoment, kTraction, kPressure, kBodyForce };
template <>
struct EnumNames<LoadKind> {
  static constexpr std::array names{"force", "moment", "traction", "pressure", "body_force"};
};

/// How a total force or a moment is shared out over its selection.
enum class LoadShare {
  kAuto,     ///< kSurface if triangles of the boundary are selected, but not with SelectAll or a
             ///< group of tetrahedra; otherwise kVolume if tetrahedra are selected; else kVertices
  kSurface,  ///< by the area of the selected triangles of the boundary
  kVolume,   ///< by the mass of the selected tetrahedra
  kVertices  ///< equally among the selected vertices
};
template <>
struct EnumNames<LoadShare> {
  static constexpr std::array names{"auto", "surface", "volume", "vertices"};
};

/// A load on a part of the body. All but pressures are dead loads: their directions do not change
/// with the deformation.
struct ForceSettings {
  Selection select = SelectAll{};
  /// Force: N, on every selected vertex. Moment: N m. Traction: Pa. Body force: N/m³.
  Vector3 vector = Vector3::Zero();
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
  std::string where;
  LoadKind kind = LoadKind::kForce;
  std::optional<Vector3> total{};         ///< force: N, shared out over the selection
  LoadShare share = LoadShare::kAuto;     ///< of a total force and of a moment
  double value = 0.0;                     ///< pressure: Pa; positive values push inwards
  std::optional<Vector3> acceleration{};  ///< body force: m/s², instead of `vector`
  std::string amplitude{};                ///< factor; empty: 1
};

/// The loads of a scene or of a run. Those of each kind have numbers of their own.
struct LoadLists {
  std::vector<ForceSettings> force;
  std::vector<ForceSettings> moment;
  std::vector<ForceSettings> traction;
  std::vector<ForceSettings> pressure;
  std::vector<ForceSettings> body_force;

  std::vector<ForceSettings>& list(LoadKind kind) { return this->*member(kind); }
  const std::vector<ForceSettings>& list(LoadKind kind) const { return this->*member(kind); }

 private:
  static std::vector<ForceSettings> LoadLists::*member(LoadKind kind) {
    constexpr std::array kMembers{&LoadLists::force, &LoadLists::moment, &LoadLists::traction,
                                  &LoadLists::pressure, &LoadLists::body_force};
    return kMembers.at(static_cast<std::size_t>(kind));
  }
};

}  // namespace tetraction
