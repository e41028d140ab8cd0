// Keys of loads and of their amplitudes: [[amplitude]], [[force]], [[moment]], [[traction]],
// [[pressure]], [[body_force]].
#include <fmt/format.h>

#include "tetraction/simulation/setting_keys.h"

namespace tetraction {
namespace {

constexpr NumberRange kAnyTime{.infinity = true};

template <class S>
std::string times_conflict(const S& load) {
  if (load.until > load.from) return {};
  return fmt::format(
      "does not fit: the force acts from {} s until {} s; until must be later than from.",
      load.from, load.until);
}

std::string total_conflict(const ForceSettings& force) {
  return force.total && !force.vector.isZero(0.0)
             ? "is one key too many: vector and total are both given. A vector is the force on "
               "each "
               "selected vertex, a total the sum of all. Leave one of the two out."
             : "";
}

std::string share_conflict(const ForceSettings& force) {
  return !force.total && force.share != LoadShare::kAuto
             ? "has no effect beside vector, which is the force on each vertex: leave it out, or "
               "give "
               "total."
             : "";
}

std::string acceleration_conflict(const BodyForceSettings& force) {
  return force.acceleration && !force.vector.isZero(0.0)
             ? "is one key too many: vector and acceleration are both given. Leave one of the two "
               "out."
             : "";
}

template <class S>
Key<S> load_select(const char* help) {
  return {{.name = "select", .help = help, .absent = "must be given"},
          ByHand{"[selection](#selections)"}};
}

template <class S>
std::vector<Key<S>> with_times(std::vector<Key<S>> keys) {
  keys.push_back({{.name = "amplitude",
                   .help = "name of an `[[amplitude]]`, the factor of the load",
                   .absent = "the factor 1"},
                  &S::amplitude});
  keys.push_back({{.name = "from", .unit = "s", .help = "when it begins"}, &S::from});
  keys.push_back({{.name = "until",
                   .unit = "s",
                   .help = "when it ends, later than `from`; `inf` for ever",
                   .range = kAnyTime},
                  &S::until});
  return keys;
}

template <class S>
Key<S> share_key(const char* help) {
  return {{.name = "share",
           .help = help,
           .in_file = Written::kUnlessDefault,
           .in_echo = Written::kUnlessDefault},
          Choice<S>{{"auto", "surface", "volume", "vertices"},
                    {},
                    [](const S& s) { return to_string(s.share); },
                    [](S& s, const std::string& name) {
                      for (const LoadShare share : {LoadShare::kAuto, LoadShare::kSurface,
                                                    LoadShare::kVolume, LoadShare::kVertices}) {
                        if (name == to_string(share)) s.share = share;
                      }
                    }}};
}

}  // namespace

template <>
const Section<AmplitudeSettings>& section_of() {
  using S = AmplitudeSettings;
  static const Section<S> section{
      "amplitude",
      {{{.name = "name",
         .help = "by which loads and motions refer to it; each name once",
         .needed = "a name, by which loads refer to the amplitude."},
        &S::name},
       {{.name = "points",
         .help = "`[[t, a], …]`, times in s that increase, and factors: linear between them, "
                 "constant before the first and after the last"},
        ByHand{"list of two numbers each"}},
       {{.name = "file",
         .help =
             "a text file with two columns, time in s and factor, instead of `points`; a relative "
             "path starts at the scene's folder; decimal points, and commas, semicolons, spaces or "
             "tabs between them; a first line with names, and lines that "
             "begin with #, are left out"},
        ByHand{"text"}},
       {{.name = "sine",
         .help =
             "`{ frequency = f, phase = φ, offset = b }`, in Hz and rad: b + sin(2πft + φ); phase "
             "and offset are 0 unless given"},
        ByHand{"table"}},
       {{.name = "smooth_step",
         .help = "`{ from = t₀, until = t₁ }`, in s: 0 before, 1 after, and between them "
                 "s³(10 − 15s + 6s²) with s = (t − t₀)/(t₁ − t₀)"},
        ByHand{"table"}}}};
  return section;
}

template <>
const Section<ForceSettings>& section_of() {
  using S = ForceSettings;
  static const Section<S> section{
      "force",
      with_times<S>(
          {load_select<S>("the vertices; with `total` a surface or a volume"),
           {{.name = "vector",
             .unit = "N",
             .per = "on each vertex",
             .help = "the force on each selected vertex; either this or `total` must be given"},
            &S::vector},
           {{.name = "total",
             .unit = "N",
             .help = "the sum of the forces, which are shared out over the selection"},
            &S::total},
           share_key<S>("how `total` is shared out: by area, by mass, equally, or by what the "
                        "selection contains, see below")}),
      {{{"from", "until"}, times_conflict<S>},
       {{"vector", "total"}, total_conflict},
       {{"share"}, share_conflict}}};
  return section;
}

template <>
const Section<MomentSettings>& section_of() {
  using S = MomentSettings;
  static const Section<S> section{
      "moment",
      with_times<S>({load_select<S>("a surface, a volume or vertices"),
                     {{.name = "vector",
                       .unit = "N m",
                       .help = "the moment; its direction is that of the axis",
                       .needed = "the moment, [mx, my, mz] in N m."},
                      &S::vector},
                     share_key<S>("how its forces are shared out, as with `total` of a force")}),
      {{{"from", "until"}, times_conflict<S>}}};
  return section;
}

template <>
const Section<TractionSettings>& section_of() {
  using S = TractionSettings;
  static const Section<S> section{
      "traction",
      with_times<S>({load_select<S>("triangles of the boundary"),
                     {{.name = "vector",
                       .unit = "Pa",
                       .help = "the force for each area at rest",
                       .needed = "the force for each area, [tx, ty, tz] in Pa."},
                      &S::vector}}),
      {{{"from", "until"}, times_conflict<S>}}};
  return section;
}

template <>
const Section<PressureSettings>& section_of() {
  using S = PressureSettings;
  static const Section<S> section{
      "pressure",
      with_times<S>({load_select<S>("triangles of the boundary"),
                     {{.name = "value",
                       .unit = "Pa",
                       .help = "the pressure, which pushes inwards if it is positive",
                       .needed = "the pressure in Pa."},
                      &S::value}}),
      {{{"from", "until"}, times_conflict<S>}}};
  return section;
}

template <>
const Section<BodyForceSettings>& section_of() {
  using S = BodyForceSettings;
  static const Section<S> section{
      "body_force",
      with_times<S>({load_select<S>("tetrahedra"),
                     {{.name = "vector",
                       .unit = "N/m³",
                       .help = "the force for each volume at rest; either this or `acceleration` "
                               "must be given"},
                      &S::vector},
                     {{.name = "acceleration", .unit = "m/s²", .help = "the force for each mass"},
                      &S::acceleration}}),
      {{{"from", "until"}, times_conflict<S>},
       {{"vector", "acceleration"}, acceleration_conflict}}};
  return section;
}

}  // namespace tetraction
