// The edits of a scene's events, which must not put back settings that the user has changed.
#pragma once

#include "simulation.h"

namespace tetraction::viewer {

/// An edit of a section of the scene (material, time, solver, damping, environment) contains all keys of
/// the section, with the values that the scene alone would have given them. This function returns the
/// edit with the present values of all keys that the event does not name. If the named keys do not go
/// with the present ones, such as moduli of another model, it returns the edit as it is, and also if it is
/// an edit of another kind or the event does not say which keys it names (EventSettings::echo).
Edit with_present_settings(const Edit& edit, const EventSettings& event, const Settings& present);

}  // namespace tetraction::viewer
