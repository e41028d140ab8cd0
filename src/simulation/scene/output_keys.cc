// Keys of what a run writes: [output] and [[probe]].
#include <fmt/format.h>

#include <algorithm>

#include "core/quoting.h"
#include "core/spelling.h"
#include "sections.h"
#include "setting_values.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

std::string fields_conflict(const OutputSettings& output) {
  NameList known{kDefaultFields};
  for (const Quantity* field : frame_quantities()) known.emplace_back(field->name);
  for (const std::string& name : output.fields) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string_view near = nearest_name(name, known);
    return fmt::format("has {}, which is no field: {}there are {}.", in_quotes(name),
                       near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near),
                       listing(known));
  }
  return {};
}

std::string name_conflict(const ProbeSettings& probe) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  if (!probe.name.empty() && std::all_of(probe.name.begin(), probe.name.end(), fits)) return {};
  return fmt::format("= {} is no name of a column: take letters, digits and underscores.",
                     in_quotes(probe.name));
}

std::string sum_at_point_conflict(const ProbeSettings& probe) {
  if (!probe.point || !quantity_of(probe.quantity).is_sum) return {};
  return fmt::format(
      "= \"{}\" is a sum over vertices, which a point does not have: give select instead of point.",
      to_string(probe.quantity));
}

bool is_of_obstacle(const ProbeSettings& probe) {
  return quantity_of(probe.quantity).is_of_obstacle;
}

bool has_no_obstacle(const ProbeSettings& probe) {
  return probe.obstacle.empty();
}

bool is_moment(const ProbeSettings& probe) {
  return probe.quantity == ProbeQuantity::kContactMoment;
}

std::string obstacle_conflict(const ProbeSettings& probe) {
  if (is_of_obstacle(probe) && probe.obstacle.empty()) {
    return fmt::format(
        "= \"{}\" is the force of an obstacle: give its name, obstacle = \"NAME\", in place of a "
        "selection or a point.",
        to_string(probe.quantity));
  }
  if (is_of_obstacle(probe) || probe.obstacle.empty()) return {};
  return fmt::format(
      "= \"{}\" is none of an obstacle: take \"contact_force\" or \"contact_moment\", or leave "
      "obstacle out.",
      to_string(probe.quantity));
}

std::string about_without_moment(const ProbeSettings& probe) {
  if (is_moment(probe) || probe.about.isZero(0.0)) return {};
  return "is for quantity = \"contact_moment\" only.";
}

std::string needed_select(const ProbeSettings&, const HasKey& has) {
  return has("point") || has("obstacle")
             ? ""
             : "say where the probe is: select = { nearest = [x, y, z] }, any other "
               "selection, or point = [x, y, z].";
}

bool needs_selection(const ProbeSettings& probe) {
  return !probe.point.has_value() && probe.obstacle.empty();
}

}  // namespace

SceneSection output_section() {
  using S = OutputSettings;
  return make_section<S>(
      "output",
      {{{.name = "directory",
         .help = "where results go, a folder below the working directory. `--out`, which may name "
                 "any other, goes before it"},
        &S::directory},
       {{.name = "every",
         .help = "a frame each so many steps, and always the first and the last",
         .range = kAtLeastOne},
        &S::every},
       {{.name = "checkpoint_every",
         .help =
             "a checkpoint after each so many steps, from which `run --resume` goes on; 0: none",
         .range = {.least = 0.0},
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::checkpoint_every},
       {{.name = "history_every",
         .help = "a row of `history.csv` each so many steps, and always the first and the last",
         .range = kAtLeastOne,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::history_every},
       {{.name = "fields",
         .help = "names of the arrays that frames and `final.vtu` have, see below",
         .absent = "`[\"default\"]`"},
        &S::fields},
       {{.name = "precision",
         .help = "of the numbers of frames; those of `final.vtu` are always `float64`",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::precision},
       {{.name = "compression",
         .help = "of frames and `final.vtu`",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::compression}},
      {{{"fields"}, fields_conflict}});
}

SceneSection probe_section() {
  using S = ProbeSettings;
  return make_section<S>(
      "probe",
      {{{.name = "name",
         .help = "of its columns: letters, digits and underscores; each name once",
         .needed = "a name for its columns in probes.csv."},
        &S::name},
       {{.name = "select",
         .help = "the vertices; of stresses and `jacobian` the tetrahedra, as in "
                 "[`[[material_region]]`](#material_region)",
         .absent = "either this, `point` or `obstacle`"},
        SelectionValue<S>(),
        {.used = needs_selection, .needed = needed_select, .written = needs_selection}},
       {{.name = "point",
         .unit = "m",
         .help = "a point of the undeformed body, instead of `select`; not for `momentum`, `force` "
                 "and `reaction`"},
        &S::point,
        {.used = has_no_obstacle, .written = has_no_obstacle}},
       {{.name = "quantity",
         .help = "what is stored, see below",
         .needed = "what to store, for instance \"displacement\"."},
        &S::quantity},
       {{.name = "every",
         .help = "values for each so many steps, and always for the first and the last",
         .range = kAtLeastOne,
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::every},
       {{.name = "obstacle",
         .help =
             "of `contact_force` and `contact_moment`, instead of `select`: the name of the "
             "[`[[obstacle]]`](#obstacle), which an event may add; there is no force before that",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::obstacle,
        {.used = is_of_obstacle, .written = is_of_obstacle}},
       {{.name = "about",
         .unit = "m",
         .help = "of `contact_moment`: the point in space that the moment is about",
         .in_file = Written::kUnlessDefault,
         .in_echo = Written::kUnlessDefault},
        &S::about,
        {.used = is_moment, .written = is_moment}}},
      {{{"name"}, name_conflict},
       {{"quantity"}, sum_at_point_conflict},
       {{"quantity"}, obstacle_conflict},
       {{"about"}, about_without_moment}});
}

}  // namespace tetraction
