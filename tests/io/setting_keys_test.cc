// The tables of keys against what is made from them: scene reader, writer, echo, checks, docs/scene.md.
#include "tetraction/simulation/setting_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "io/scene/key_text.h"
#include "support/messages.h"
#include "support/scene_parts.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/key_tables.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

// Where the settings of each section lie in a scene: how they get there and back, and the path of
// their table in the file.
template <class S>
struct Place;
#define TETRACTION_PLACE(Type, member, text)                                         \
  template <>                                                                        \
  struct Place<Type> {                                                               \
    static constexpr const char* kPath = text;                                       \
    static void put(Scene& scene, const Type& settings) { scene.member = settings; } \
    static Type get(const Scene& scene) { return scene.member; }                     \
  }
TETRACTION_PLACE(MeshSettings, mesh, "mesh");
TETRACTION_PLACE(MaterialSettings, material, "material");
TETRACTION_PLACE(MaterialRegionSettings, material_region.at(0), "material_region.0");
TETRACTION_PLACE(TimeSettings, time, "time");
TETRACTION_PLACE(SolverSettings, solver, "solver");
TETRACTION_PLACE(Damping, damping, "damping");
TETRACTION_PLACE(EnvironmentSettings, environment, "environment");
TETRACTION_PLACE(FixSettings, fix.at(0), "fix.0");
TETRACTION_PLACE(ConstraintSettings, constraint.at(0), "constraint.0");
TETRACTION_PLACE(ForceSettings, force.at(0), "force.0");
TETRACTION_PLACE(InitialSettings, initial, "initial");
TETRACTION_PLACE(MomentumSettings, initial.momentum.at(0), "initial.momentum.0");
TETRACTION_PLACE(Selection, force.at(0).select, "force.0.select");
TETRACTION_PLACE(OutputSettings, output, "output");
TETRACTION_PLACE(ProbeSettings, probe.at(0), "probe.0");
TETRACTION_PLACE(AmplitudeSettings, amplitude.at(0), "amplitude.0");
#undef TETRACTION_PLACE

// A kind of load that has settings of its own.
template <class Load>
struct LoadPlace {
  static void put(Scene& scene, const Load& load) { scene.list(load.kind) = {load}; }
  static Load get(const Scene& scene) {
    Load load;
    static_cast<ForceSettings&>(load) = scene.list(load.kind).at(0);
    return load;
  }
};
template <>
struct Place<MomentSettings> : LoadPlace<MomentSettings> {
  static constexpr const char* kPath = "moment.0";
};
template <>
struct Place<TractionSettings> : LoadPlace<TractionSettings> {
  static constexpr const char* kPath = "traction.0";
};
template <>
struct Place<PressureSettings> : LoadPlace<PressureSettings> {
  static constexpr const char* kPath = "pressure.0";
};
template <>
struct Place<BodyForceSettings> : LoadPlace<BodyForceSettings> {
  static constexpr const char* kPath = "body_force.0";
};

template <>
struct Place<GeneratorSettings> {
  static constexpr const char* kPath = "mesh.generate";
  static void put(Scene& scene, const GeneratorSettings& settings) {
    scene.mesh.generate = settings;
  }
  static GeneratorSettings get(const Scene& scene) { return *scene.mesh.generate; }
};

template <>
struct Place<EventSettings> {
  static constexpr const char* kPath = "event.0";
  static void put(Scene& scene, const EventSettings& settings) { scene.event = {settings}; }
  static EventSettings get(const Scene& scene) { return scene.event.at(0); }
};

template <>
struct Place<ShiftSettings> {
  static constexpr const char* kPath = "event.0.shift";
  static void put(Scene& scene, const ShiftSettings& settings) {
    EventSettings event;
    event.edits = {ShiftState{settings}};
    scene.event = {event};
  }
  static ShiftSettings get(const Scene& scene) {
    return std::get<ShiftState>(scene.event.at(0).edits.at(0)).shift;
  }
};

template <class Kind>
struct SelectionPlace {
  static void put(Scene& scene, const Kind& kind) { scene.force.at(0).select = kind; }
  static Kind get(const Scene& scene) { return std::get<Kind>(scene.force.at(0).select); }
};
template <>
struct Place<SelectPlane> : SelectionPlace<SelectPlane> {
  static constexpr const char* kPath = "force.0.select.plane";
};
template <>
struct Place<SelectBox> : SelectionPlace<SelectBox> {
  static constexpr const char* kPath = "force.0.select.box";
};
template <>
struct Place<SelectFaces> : SelectionPlace<SelectFaces> {
  static constexpr const char* kPath = "force.0.select.faces";
};
template <>
struct Place<SelectSphere> : SelectionPlace<SelectSphere> {
  static constexpr const char* kPath = "force.0.select.sphere";
};

// Settings with which any one key can change.
template <class S>
std::vector<S> bases() {
  return {S{}};
}
template <>
std::vector<MeshSettings> bases() {
  MeshSettings mesh;
  mesh.file = "body.vtu";
  return {mesh};
}
// Both ways of giving every model. All their parameters are used.
template <>
std::vector<MaterialSettings> bases() {
  using S = MaterialSettings;
  std::vector<MaterialSettings> all;
  for (const MaterialChoice& choice : material_choices()) {
    for (const bool by_young : {false, true}) {
      std::vector<MaterialParameter> given = choice.parameters;
      if (by_young) {
        given = choice.beside_young;
        given.push_back(kYoungsModulus);
        given.push_back(kPoissonsRatio);
      }
      S material;
      material.model = choice.name;
      for (const MaterialParameter& parameter : given) {
        for (const MaterialKey& key : material_keys()) {
          if (std::string(key.parameter.name) == parameter.name) material.*key.value = 0.25;
        }
      }
      all.push_back(material);
    }
  }
  return all;
}
template <>
std::vector<EventSettings> bases() {
  EventSettings event;
  event.edits = {SetDamping{{1.0, 0.0, 0.0}}};
  return {event};
}
template <>
std::vector<EnvironmentSettings> bases() {
  EnvironmentSettings environment;
  environment.kind = EnvironmentKind::kGravity;
  environment.strength = 3.0;
  return {environment};
}
template <>
std::vector<FixSettings> bases() {
  FixSettings fix;
  fix.select = SelectVertices{{4, 9}};
  fix.penalty = 2.0;
  FixSettings moving = fix;
  moving.offset = Vector3(1.0, 0.0, 0.0);
  return {fix, moving};
}
template <>
std::vector<ForceSettings> bases() {
  ForceSettings shared;
  shared.total = Vector3(1.0, 0.0, 0.0);
  return {ForceSettings{}, shared};
}
template <>
std::vector<AmplitudeSettings> bases() {
  AmplitudeSettings amplitude;
  amplitude.name = "hat";
  amplitude.points = {{0.0, 1.0}};
  return {amplitude};
}
template <>
std::vector<ConstraintSettings> bases() {
  std::vector<ConstraintSettings> all(4);  // and a driven one
  all[1].kind = ConstraintKind::kPlane;
  all[2].kind = ConstraintKind::kLine;
  all[3].kind = ConstraintKind::kRigid;
  all.push_back(all[3]);
  all[4].velocity = Vector3(1.0, 0.0, 0.0);
  return all;
}
template <>
std::vector<ShiftSettings> bases() {
  ShiftSettings shift;
  shift.vertices = {2, 7};
  shift.displacement = shift.impulse = {Vector3(1, 0, 0), Vector3(0, 1, 0)};
  return {shift};
}
template <>
std::vector<ProbeSettings> bases() {
  ProbeSettings probe;
  probe.name = "tip";
  return {probe};
}
template <>
std::vector<SelectBox> bases() {
  return {SelectBox{Vector3::Zero(), Vector3::Ones()}};
}
template <>
std::vector<SelectFaces> bases() {
  return {SelectFaces{Vector3::UnitZ(), 30.0}};
}
template <>
std::vector<SelectSphere> bases() {
  return {SelectSphere{Vector3::Zero(), 1.0}};
}

// Whether the settings can have another value of the key while the others stay as they are.
template <class S>
bool can_change(const S& settings, const Key<S>& key) {
  return !section_of<S>().refuses_unused || key.is_used(settings);
}
// An amplitude is the factor of an offset, beside which there is no target.
template <>
bool can_change(const FixSettings& fix, const Key<FixSettings>& key) {
  const std::string name = key.info.name;
  if (name == "amplitude") return fix.offset.has_value();
  return !fix.offset || (name != "target" && name != "targets");
}
// An amplitude is the factor of the velocities of a driven handle.
template <>
bool can_change(const ConstraintSettings& constraint, const Key<ConstraintSettings>& key) {
  const std::string name = key.info.name;
  if (name == "amplitude") return constraint.is_driven();
  if (name == "about") return constraint.angular_velocity.has_value();
  return key.is_used(constraint);
}
// A total is shared out; a vector is not, and the two exclude each other.
template <>
bool can_change(const ForceSettings& force, const Key<ForceSettings>& key) {
  const std::string name = key.info.name;
  if (name == "share") return force.total.has_value();
  return name != "vector" || !force.total;
}
// The parameters of a material must be those of its model.
template <>
bool can_change(const MaterialSettings& material, const Key<MaterialSettings>& key) {
  if (std::string(key.info.name) == "model") {
    return material.model == "stvk" || material.model == "neo-hookean";  // of the same parameters
  }
  if (const auto* value = std::get_if<NumberOrArray<MaterialSettings>>(&key.value)) {
    return value->number(material).has_value();
  }
  return key.is_used(material);
}

// Gives a key another value than the settings hold. Every kind of value has its own function.
template <class S>
struct Change {
  S& settings;
  const KeyInfo& key;

  double number() const { return key.range.contains(0.375) ? 0.375 : 2.5; }
  static Vector3 vector() { return {0.36, 0.48, 0.8}; }  // of length 1, for directions

  void operator()(int S::*member) const { settings.*member += 7; }
  void operator()(double S::*member) const { settings.*member = number(); }
  void operator()(std::optional<double> S::*member) const { settings.*member = number(); }
  void operator()(Vector3 S::*member) const { settings.*member = vector(); }
  void operator()(std::optional<Vector3> S::*member) const { settings.*member = vector(); }
  void operator()(std::array<bool, 3> S::*member) const { settings.*member = {true, false, true}; }
  void operator()(std::string S::*member) const { settings.*member = "other"; }
  void operator()(std::array<std::int64_t, 2> S::*member) const { settings.*member = {3, 5}; }
  void operator()(std::vector<std::int64_t> S::*member) const { settings.*member = {5, 8}; }
  void operator()(std::vector<Vector3> S::*member) const {
    settings.*member = {vector(), -vector()};
  }
  void operator()(std::vector<std::string> S::*member) const {
    settings.*member = {"pressure", "displacement"};
  }
  void operator()(bool S::*member) const { settings.*member = !(settings.*member); }
  void operator()(const Choice<S>& choice) const {
    const bool is_first = choice.get(settings) == choice.names.front();
    choice.set(settings, is_first ? choice.names[1] : choice.names.front());
  }
  void operator()(const NumberOrAuto<S>& value) const { settings.*value.number = number(); }
  void operator()(const NumberOrArray<S>& value) const { value.set(settings, number()); }
  void operator()(const VectorOrField<S>& value) const { settings.*value.vector = vector(); }
  void operator()(const ByHand&) const {}
};

// Puts a number into a key that takes numbers; false for other keys.
template <class S>
struct PutNumber {
  S& settings;
  double value;

  bool operator()(int S::*member) const {
    settings.*member = static_cast<int>(value);
    return true;
  }
  bool operator()(double S::*member) const {
    settings.*member = value;
    return true;
  }
  bool operator()(std::optional<double> S::*member) const {
    settings.*member = value;
    return true;
  }
  bool operator()(Vector3 S::*member) const {
    settings.*member = {0.5, value, 0.5};
    return true;
  }
  bool operator()(std::optional<Vector3> S::*member) const {
    settings.*member = Vector3(0.5, value, 0.5);
    return true;
  }
  bool operator()(std::vector<Vector3> S::*member) const {
    settings.*member = {Vector3(0.5, value, 0.5), Vector3(0.5, 0.5, 0.5)};
    return true;
  }
  bool operator()(const NumberOrAuto<S>& number) const {
    settings.*number.number = value;
    return true;
  }
  bool operator()(const NumberOrArray<S>& number) const {
    number.set(settings, value);
    return true;
  }
  bool operator()(const VectorOrField<S>& either) const {
    settings.*either.vector = {0.5, value, 0.5};
    return true;
  }
  template <class Other>
  bool operator()(const Other&) const {
    return false;
  }
};

// Numbers just outside a range.
std::vector<double> outside(const NumberRange& range, bool is_whole) {
  std::vector<double> numbers;
  if (std::isfinite(range.least)) {
    numbers.push_back(range.least_itself ? range.least - 1.0 : range.least);
  }
  if (std::isfinite(range.most)) {
    numbers.push_back(range.most_itself ? range.most + 1.0 : range.most);
  }
  if (!is_whole) numbers.push_back(std::numeric_limits<double>::quiet_NaN());
  if (range.is_moderate) numbers.push_back(1e31);
  return numbers;
}

class SettingKeys : public testing::Test {
 protected:
  template <class S>
  static Scene scene_with(const S& settings) {
    Scene scene = scene_of({}, elastic(1e6, 0.3));
    scene.material_region.resize(1);
    scene.material_region[0].material = scene.material;
    scene.fix.resize(1);
    scene.constraint.resize(1);
    scene.force.resize(1);
    scene.initial.momentum.resize(1);
    scene.probe.resize(1);
    scene.probe[0].name = "tip";
    scene.amplitude = bases<AmplitudeSettings>();
    Place<S>::put(scene, settings);
    if (scene.amplitude[0].name != "other") {  // to which a changed key refers
      scene.amplitude.push_back(scene.amplitude[0]);
      scene.amplitude[1].name = "other";
    }
    return scene;
  }
  std::string path() const { return (folder_ / "scene.toml").string(); }

  template <class S>
  void expect_survival(const S& base, const Key<S>& key) const {
    SCOPED_TRACE(std::string(section_of<S>().name) + "." + key.info.name);
    S changed = base;
    std::visit(Change<S>{changed, key.info}, key.value);
    const std::string value = std::visit(ValueText<S>{changed}, key.value);
    ASSERT_NE(value, std::visit(ValueText<S>{base}, key.value));
    const Scene scene = scene_with(changed);
    ASSERT_NO_THROW(check_settings(changed));
    write_scene(scene, path());
    const Scene read = read_scene(path());
    EXPECT_EQ(std::visit(ValueText<S>{Place<S>::get(read)}, key.value), value);
    EXPECT_EQ(scene_text(read, folder_.string()), scene_text(scene, folder_.string()));
    // The echo holds it by its name.
    if (key.is_used(changed)) {
      EXPECT_NE(read.echo.find('"' + std::string(key.info.name) + '"'), std::string::npos);
    }
  }

  template <class S>
  void expect_refusals(const S& base, const Key<S>& key) const {
    const bool is_whole = std::holds_alternative<int S::*>(key.value);
    for (const double number : outside(key.info.range, is_whole)) {
      S wrong = base;
      if (!std::visit(PutNumber<S>{wrong, number}, key.value)) return;
      const std::string name = key.info.name;
      const std::string value = fmt_number(number);
      const std::string range = std::isnan(number) ? "finite"
                                : number == 1e31   ? "between 1e-30 and 1e30"
                                                   : key.info.range.text();
      SCOPED_TRACE(std::string(section_of<S>().name) + "." + name + " = " + value);
      const auto expect_message = [&](const std::string& message, const std::string& path) {
        EXPECT_NE(message.find(path + "." + name), std::string::npos) << message;
        EXPECT_NE(message.find(value), std::string::npos) << message;
        EXPECT_NE(message.find(range), std::string::npos) << message;
      };
      write_scene(scene_with(base), this->path());
      const std::string text = std::visit(ValueText<S>{wrong}, key.value);
      const std::string place = Place<S>::kPath;
      const std::string toml = text.empty() ? value : text;
      try {
        read_scene(this->path(), {place + "." + name + "=" + toml});
        ADD_FAILURE() << "the scene reader takes it";
      } catch (const InputError& error) {
        expect_message(error.what(), place);
      }
      if (!key.is_used(wrong)) continue;
      try {
        check_settings(wrong);
        ADD_FAILURE() << "check_settings() takes it";
      } catch (const InputError& error) {
        expect_message(error.what(), section_of<S>().name);
      }
    }
  }

  static std::string fmt_number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

template <class S>
S settings_of(const Section<S>&) {
  return {};
}

TEST_F(SettingKeys, EveryKeySurvivesWritingAndReading) {
  int count = 0;
  for_each_section([&](const auto& section) {
    using S = decltype(settings_of(section));
    for (const S& base : bases<S>()) {
      for (const Key<S>& key : section.keys) {
        if (std::holds_alternative<ByHand>(key.value) || !can_change(base, key)) continue;
        expect_survival(base, key);
        ++count;
      }
    }
  });
  EXPECT_GT(count, 80);
}

TEST_F(SettingKeys, NumbersOutOfRangeAreRefusedWithKeyValueAndRange) {
  for_each_section([&](const auto& section) {
    using S = decltype(settings_of(section));
    for (const S& base : bases<S>()) {
      for (const Key<S>& key : section.keys) {
        if (!can_change(base, key)) continue;
        expect_refusals(base, key);
      }
    }
  });
}

TEST_F(SettingKeys, NamesAreFoundByTheirMembers) {
  EXPECT_STREQ(key_info(&Damping::drag).name, "drag");
  EXPECT_STREQ(key_info(&TimeSettings::step).unit, "s");
  EXPECT_STREQ(key_info(&SolverSettings::max_iterations).name, "max_iterations");
  EXPECT_STREQ(key_info(&ForceSettings::vector).unit, "N");
}

TEST_F(SettingKeys, EveryKeyHasAMeaningAndANameOfItsOwn) {
  for_each_section([](const auto& section) {
    std::vector<std::string> names;
    for (const auto& key : section.keys) {
      EXPECT_STRNE(key.info.help, "") << section.name << "." << key.info.name;
      names.emplace_back(key.info.name);
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << section.name;
  });
}

TEST_F(SettingKeys, RulesBetweenKeysAreChecked) {
  SolverSettings solver;
  solver.kind = "ceres";
  solver.linear = LinearSolver::kCg;
  EXPECT_THROW(check_settings(solver), InputError);
  TimeSettings time;
  time.automatic = true;
  EXPECT_THROW(check_settings(time), InputError);
  time.integrator = Integrator::kVerlet;
  EXPECT_NO_THROW(check_settings(time));
  time.retry = 3;
  EXPECT_THROW(check_settings(time), InputError) << "auto makes smaller steps by itself";
  time.automatic = false;
  EXPECT_NO_THROW(check_settings(time));
  time.retry = 31;
  EXPECT_THROW(check_settings(time), InputError);
  time.retry = 3;
  time.adapt = StepAdaptation::kError;
  EXPECT_THROW(check_settings(time), InputError) << "so does adapt";
  time.retry = 0;
  EXPECT_NO_THROW(check_settings(time));
  for (const double tolerance : {0.0, 1e-13}) {
    time.tolerance = tolerance;
    EXPECT_THROW(check_settings(time), InputError) << "below round-off";
  }
  time.tolerance = 1e-12;
  EXPECT_NO_THROW(check_settings(time));
  time.tolerance = 1e-4;
  time.min_step = 2.0 * time.step;
  EXPECT_NO_THROW(check_settings(time)) << "this is then the first step";
  time.min_step = 0.1 * time.step;
  time.max_step = 0.05 * time.step;
  EXPECT_THROW(check_settings(time), InputError);
  time.max_step = time.step;
  EXPECT_NO_THROW(check_settings(time));
  time.adapt = StepAdaptation::kEnergy;
  for (const Integrator rule : all_integrators()) {
    time.integrator = rule;
    if (is_implicit(rule) && is_variational(rule)) {
      EXPECT_NO_THROW(check_settings(time));
    } else {
      EXPECT_THROW(check_settings(time), InputError) << to_string(rule);
    }
  }
  EnvironmentSettings environment;
  environment.direction.setZero();
  EXPECT_THROW(check_settings(environment), InputError);
  ForceSettings force;
  force.until = force.from;
  EXPECT_THROW(check_settings(force), InputError);
  FixSettings fix;
  fix.target = fix.offset = Vector3(1, 0, 0);
  EXPECT_THROW(check_settings(fix), InputError);
  fix.offset.reset();
  EXPECT_NO_THROW(check_settings(fix));
  fix.components.fill(false);
  EXPECT_THROW(check_settings(fix), InputError);
  EXPECT_THROW(check_settings(SelectBox{Vector3::Ones(), Vector3::Zero()}), InputError);
  EXPECT_THROW(check_settings(ShiftSettings{{1}, {}, {}, {}}), InputError);
}

TEST(NumberRange, SaysWhatItHolds) {
  EXPECT_EQ(kPositive.text(), "above 0");
  EXPECT_EQ(kNotNegative.text(), "0 or more");
  EXPECT_EQ(kFinite.text(), "any number");
  const NumberRange unit{.least = 0.0, .most = 1.0, .least_itself = false, .most_itself = false};
  EXPECT_EQ(unit.text(), "between 0 and 1, both excluded");
  EXPECT_EQ((NumberRange{.least = 0.0, .most = 0.49}.text()), "from 0 to 0.49");
  EXPECT_EQ((NumberRange{.least = 0.0, .most = 1.0, .least_itself = false}.text()),
            "above 0 and 1 or less");
  EXPECT_EQ(kPositive.refusal(0.0), "; it must be above 0.");
  EXPECT_EQ(unit.refusal(1.0), "; it must lie between 0 and 1, both excluded.");
  EXPECT_TRUE(kPositive.contains(1e-300));
  EXPECT_FALSE(kModeratePositive.contains(1e-31));
  EXPECT_TRUE(kModerate.contains(0.0));
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(kFinite.contains(infinity));
  EXPECT_TRUE((NumberRange{.infinity = true}.contains(infinity)));
  EXPECT_FALSE((NumberRange{.infinity = true}.contains(std::nan(""))));
}

// docs/scene.md holds the tables between <!-- keys: NAME --> and <!-- end -->.
TEST(KeyTables, DocumentsAreInStep) {
  const fs::path path = fs::path(TETRACTION_SCENES) / "../../docs/scene.md";
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& name : key_table_names()) {
    const std::string mark = "<!-- keys: " + name + " -->\n";
    const auto start = text.find(mark);
    ASSERT_NE(start, std::string::npos) << "docs/scene.md has no table of " << name;
    EXPECT_EQ(text.find(mark, start + 1), std::string::npos) << name;
    const auto begin = start + mark.size();
    EXPECT_EQ(text.substr(begin, text.find("<!-- end -->", begin) - begin), key_table(name))
        << "run scripts/document_keys";
  }
}

TEST(KeyTables, ErrorsNameThePageOfTheirSection) {
  const std::pair<const char*, const char*> cases[] = {
      {"a.toml:3:1: fix.0.target has two entries", "#fix"},
      {"a.toml:3:1: fix.0: the mesh has no group \"time: mesh\"", "#fix"},
      {"a.toml:3:1: fix.0.select selects nothing", "#selections"},
      {"--set time.step=\"material: 3\": time.step must be a number", "#time"},
      {"--set time.stepp=1: unknown key time.stepp in [time]: did you mean step?", "#time"},
      {"a.toml:1:1: unknown key tim: did you mean time?", ""},
      {"a.toml: event at 0.1 s: time.integrator must be a text", "#event"},
      {"time.end = -1; it must be above 0.", "#time"},
  };
  for (const auto& [error, anchor] : cases) {
    EXPECT_EQ(documentation_of(error), std::string("docs/scene.md") + anchor) << error;
  }
  for (const char* error : {"--steps: 0 is no step", "The mesh is empty: timeless", ""}) {
    EXPECT_EQ(documentation_of(error), "") << error;
  }
  // Each section has a heading from which Markdown makes that anchor.
  std::ifstream file(fs::path(TETRACTION_SCENES) / "../../docs/scene.md");
  std::ostringstream text;
  text << file.rdbuf();
  for (const std::string& name : key_table_names()) {
    const std::string page = documentation_of("a.toml:1:1: " + name + ".0: wrong");
    if (name.rfind("select", 0) == 0 || name == "shift") continue;
    const std::string section = name.substr(0, name.find('.'));
    EXPECT_EQ(page, "docs/scene.md#" + section);
    EXPECT_NE(text.str().find("# [" + section + "]\n"), text.str().find("# [[" + section + "]]\n"))
        << section;
  }
  EXPECT_NE(text.str().find("\n## Selections\n"), std::string::npos);
}

TEST(KeyTables, UnknownSectionIsRefusedWithASuggestion) {
  expect_part(message_of([&] { key_table("dampping"); }), "damping");
}

}  // namespace
}  // namespace tetraction
