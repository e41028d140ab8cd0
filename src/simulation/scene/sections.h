// The list of all sections and inner tables of a scene. Each is described by a function: [time] by
// time_section().
#pragma once

#include "setting_keys.h"

// Those that have a table in docs/scene.md, in its order.
// clang-format off
#define TETRACTION_DOCUMENTED_SECTIONS(S)                                                        \
  S(mesh) S(generator) S(copy) S(material) S(material_region) S(time) S(solver) S(environment)           \
  S(damping) S(pull) S(fix) S(constraint) S(obstacle) S(contact) S(force) S(moment) S(traction) S(pressure)             \
  S(body_force) S(amplitude) S(initial) S(momentum) S(event) S(shift) S(output) S(probe)         \
  S(selection) S(plane) S(box) S(sphere) S(faces)
// clang-format on

// Inner tables that are explained with their section.
#define TETRACTION_OTHER_SECTIONS(S) S(damping_ratio) S(sine) S(smooth_step) S(array) S(field)

namespace tetraction {

#define TETRACTION_DECLARE_SECTION(name) SceneSection name##_section();
TETRACTION_DOCUMENTED_SECTIONS(TETRACTION_DECLARE_SECTION)
TETRACTION_OTHER_SECTIONS(TETRACTION_DECLARE_SECTION)
#undef TETRACTION_DECLARE_SECTION

}  // namespace tetraction
