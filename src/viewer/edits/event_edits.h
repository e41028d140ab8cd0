// Edits as a scene has them: their values are in the ranges of the documents, and those of events must
// not put back settings that the user has changed.
#pragma once

#include <span>

#include "viewer/simulation.h"

namespace tetraction::viewer {

/// Checks an edit as the scene reader does, so that every run in the window can be saved as a scene.
/// Throws InputError for numbers outside the ranges of docs/scene.md, even if a Session would accept
/// them. Normalises directions.
void check_edit(Edit& edit);

/// An edit of a section of the scene (material, time, solver, damping, environment) contains all keys of
/// the section, with the values that the scene alone would have given them. This function returns the
/// edit with the present values of all keys that the event does not name. If the named keys do not go
/// with the present ones, such as moduli of another model, it returns the edit as it is, and also if it is
/// an edit of another kind or the event does not say which keys it names (EventSettings::changed_keys).
Edit with_present_settings(const Edit& edit, const EventSettings& event, const Settings& present);

/// Whether an event would change a fix or a constraint that the user has taken away, and so bring it back.
/// `edit` has the number of the scene, and `translated` that of the session. `earlier` are the events up
/// to this one: what one of them removes, another may make anew.
bool changes_what_was_removed(const Edit& edit, const Edit& translated, const EntryNumbers& present,
                              std::span<const EventSettings> earlier);

}  // namespace tetraction::viewer
