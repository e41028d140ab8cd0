// Numbers that follow from the settings of an entry, for people.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "document/scene_tables.h"
#include "viewer/simulation.h"

namespace tetraction::viewer {

/// Names and values, such as {"Wave speed", "12.5 m/s"}.
using Facts = std::vector<std::pair<std::string, std::string>>;
Facts facts_of(const EntryPlace& place, const Settings& settings);

/// Whether the section is that of the materials, and the region of an entry.
bool is_material(const EntryPlace& place, std::size_t& region);

}  // namespace tetraction::viewer
