// Keys of loads and of their amplitudes: [[amplitude]], [[force]], [[moment]], [[traction]],
// [[pressure]], [[body_force]].
#include <fmt/format.h>

#include "sections.h"
#include "setting_values.h"

namespace tetraction {
namespace {

constexpr NumberRange kAnyTime{.infinity = true};

std::string times_conflict(const ForceSettings& load) {
  if (load.until > load.from) return {};
  return fmt::format(
      "does not fit: the force acts from {} s until {} s; until must be later than from.",
      load.from, load.until);
}

std::string total_conflict(const ForceSettings& force) {
  if (!force.total || force.vector.isZero(0.0)) return {};
  return one_key_too_many(
      "vector", "total", ". A vector is the force on each selected vertex, a total the sum of all");
}

std::string share_conflict(const ForceSettings& force) {
  return !force.total && force.share != LoadShare::kAuto
             ? "has no effect beside vector, which is the force on each vertex: leave it out, or "
               "give total."
             : "";
}

std::string acceleration_conflict(const ForceSettings& force) {
  if (!force.acceleration || force.vector.isZero(0.0)) return {};
  return one_key_too_many("vector", "acceleration");
}

using Load = ForceSettings;

std::string needed_force(const Load&, const HasKey& has) {
  return has("total")
             ? ""
             : "the force on each selected vertex, [fx, fy, fz] in N; or give total, their sum.";
}

std::string needed_body_force(const Load&, const HasKey& has) {
  return has("acceleration")
             ? ""
             : "the force for each volume, [fx, fy, fz] in N/m³; or give acceleration.";
}

bool has_vector(const Load& load) {
  return !load.total && !load.acceleration;
}

// A load whose settings are by default of that kind.
SceneSection load_section(LoadKind kind, const std::vector<Key<Load>>& keys,
                          const std::vector<KeyRule<Load>>& rules) {
  Load defaults;
  defaults.kind = kind;
  return make_section<Load>(name_of(kind), keys, rules, false, defaults);
}

std::vector<Key<Load>> with_times(std::vector<Key<Load>> keys) {
  keys.push_back({{.name = "amplitude",
                   .help = "name of an `[[amplitude]]`, the factor of the load",
                   .absent = "the factor 1"},
                  &Load::amplitude});
  keys.push_back({{.name = "from", .unit = "s", .help = "when it begins"}, &Load::from});
  keys.push_back({{.name = "until",
                   .unit = "s",
                   .help = "when it ends, later than `from`; `inf` for ever",
                   .range = kAnyTime},
                  &Load::until});
  return keys;
}

Key<Load> share_key(const char* help) {
  return {{.name = "share",
           .help = help,
           .in_file = Written::kUnlessDefault,
           .in_echo = Written::kUnlessDefault},
          &Load::share};
}

// The table of a kind of amplitude, whose keys are members of the amplitude itself.
template <AmplitudeKind kind>
TableValue<AmplitudeSettings> of_kind() {
  using S = AmplitudeSettings;
  return {[]() -> const SceneSection& {
            return *find_section(std::string("amplitude.") + name_of(kind));
          },
          [](const S& s) -> const void* { return s.kind == kind ? &s : nullptr; },
          [](S& s) -> void* {
            s.kind = kind;
            return &s;
          }};
}

}  // namespace

SceneSection amplitude_section() {
  using S = AmplitudeSettings;
  return make_section<S>(
      "amplitude",
      {{{.name = "name",
         .help = "by which loads and motions refer to it; each name once",
         .needed = "a name, by which loads refer to the amplitude."},
        &S::name},
       {{.name = "points",
         .help = "`[[t, a], …]`, times in s that increase, and factors: linear between them, "
                 "constant before the first and after the last"},
        OwnValue<S>{"list of two numbers each",
                    [](const S& s) {
                      return s.kind == AmplitudeKind::kPoints
                                 ? ValueKind<decltype(s.points)>::json(s.points)
                                 : Json();
                    },
                    [](const Json& node, const NumberRange& range, const Refusal& refuse, S& s) {
                      s.kind = AmplitudeKind::kPoints;
                      ValueKind<decltype(s.points)>::read(node, range, refuse, s.points);
                    }}},
       {{.name = "file",
         .help = "a text file with two columns, time in s and factor, instead of `points`; a "
                 "relative path starts at the scene's folder; decimal points, and commas, "
                 "semicolons, spaces or tabs between them; a first line with names, and lines that "
                 "begin with #, are left out"},
        OwnValue<S>{
            "text",
            [](const S& s) { return s.kind == AmplitudeKind::kFile ? Json(s.file) : Json(); },
            [](const Json& node, const NumberRange& range, const Refusal& refuse, S& s) {
              s.kind = AmplitudeKind::kFile;
              ValueKind<std::string>::read(node, range, refuse, s.file);
            }}},
       {{.name = "sine",
         .help = "`{ frequency = f, phase = φ, offset = b }`, in Hz and rad: b + sin(2πft + φ); "
                 "phase and offset are 0 unless given"},
        of_kind<AmplitudeKind::kSine>()},
       {{.name = "smooth_step",
         .help = "`{ from = t₀, until = t₁ }`, in s: 0 before, 1 after, and between them s³(10 − "
                 "15s + 6s²) with s = (t − t₀)/(t₁ − t₀)"},
        of_kind<AmplitudeKind::kSmoothStep>()}});
}

SceneSection sine_section() {
  using S = AmplitudeSettings;
  return make_section<S>("amplitude.sine", {{{.name = "frequency",
                                              .unit = "Hz",
                                              .range = kNotNegative,
                                              .needed = "the frequency in Hz."},
                                             &S::frequency},
                                            {{.name = "phase", .unit = "rad"}, &S::phase},
                                            {{.name = "offset"}, &S::offset}});
}

SceneSection smooth_step_section() {
  using S = AmplitudeSettings;
  return make_section<S>(
      "amplitude.smooth_step",
      {{{.name = "from", .unit = "s", .needed = "when the factor begins to grow, in s."}, &S::from},
       {{.name = "until", .unit = "s", .needed = "when the factor has become 1, in s."},
        &S::until}});
}

SceneSection force_section() {
  return load_section(
      LoadKind::kForce,
      with_times(
          {select_key<Load>("the vertices; with `total` a surface or a volume"),
           {{.name = "vector",
             .unit = "N",
             .per = "on each vertex",
             .help = "the force on each selected vertex; either this or `total` must be given"},
            &Load::vector,
            {.needed = needed_force, .written = has_vector}},
           {{.name = "total",
             .unit = "N",
             .help = "the sum of the forces, which are shared out over the selection"},
            &Load::total},
           share_key("how `total` is shared out: by area, by mass, equally, or by what the "
                     "selection contains, see below")}),
      {{{"from", "until"}, times_conflict},
       {{"vector", "total"}, total_conflict},
       {{"share"}, share_conflict}});
}

SceneSection moment_section() {
  return load_section(
      LoadKind::kMoment,
      with_times({select_key<Load>("a surface, a volume or vertices"),
                  {{.name = "vector",
                    .unit = "N m",
                    .help = "the moment; its direction is that of the axis",
                    .needed = "the moment, [mx, my, mz] in N m."},
                   &Load::vector},
                  share_key("how its forces are shared out, as with `total` of a force")}),
      {{{"from", "until"}, times_conflict}});
}

SceneSection traction_section() {
  return load_section(LoadKind::kTraction,
                      with_times({select_key<Load>("triangles of the boundary"),
                                  {{.name = "vector",
                                    .unit = "Pa",
                                    .help = "the force for each area at rest",
                                    .needed = "the force for each area, [tx, ty, tz] in Pa."},
                                   &Load::vector}}),
                      {{{"from", "until"}, times_conflict}});
}

SceneSection pressure_section() {
  return load_section(LoadKind::kPressure,
                      with_times({select_key<Load>("triangles of the boundary"),
                                  {{.name = "value",
                                    .unit = "Pa",
                                    .help = "the pressure, which pushes inwards if it is positive",
                                    .needed = "the pressure in Pa."},
                                   &Load::value}}),
                      {{{"from", "until"}, times_conflict}});
}

SceneSection body_force_section() {
  return load_section(
      LoadKind::kBodyForce,
      with_times(
          {select_key<Load>("tetrahedra"),
           {{.name = "vector",
             .unit = "N/m³",
             .help =
                 "the force for each volume at rest; either this or `acceleration` must be given"},
            &Load::vector,
            {.needed = needed_body_force, .written = has_vector}},
           {{.name = "acceleration", .unit = "m/s²", .help = "the force for each mass"},
            &Load::acceleration}}),
      {{{"from", "until"}, times_conflict}, {{"vector", "acceleration"}, acceleration_conflict}});
}

}  // namespace tetraction
