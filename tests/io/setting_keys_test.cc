// The descriptions of keys against what is made from them: scene reader, writer, echo, checks, docs/scene.md.
#include "simulation/scene/setting_keys.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/toml/toml_text.h"
#include "support/messages.h"
#include "support/scene_parts.h"
#include "support/temporary_folder.h"
#include "tetraction/io/key_tables.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

// A scene in which the keys of a section can change, one at a time: the settings of the section in
// it, and the path of their table in the file.
struct Base {
  const SceneSection* section;
  std::string path;
  Scene scene;
  std::function<void*(Scene&)> at;

  void* settings() { return at(scene); }
};

AmplitudeSettings amplitude_named(const char* name) {
  return corners(name, {{0.0, 1.0}});
}

Scene plain_scene() {
  Scene scene = scene_of(GeneratorSettings{}, elastic(1e6, 0.3));
  scene.material_region.resize(1);
  scene.material_region[0].material = scene.material;
  scene.fix.resize(1);
  scene.constraint.resize(1);
  scene.force.resize(1);
  scene.initial.momentum.resize(1);
  scene.probe.resize(1);
  scene.probe[0].name = "tip";
  scene.amplitude = {amplitude_named("hat"), amplitude_named("other")};  // a changed key names it
  return scene;
}

// Collects the bases of one section.
struct Bases {
  const SceneSection* section;
  std::vector<Base> all{};

  // `change` makes the settings in a plain scene those of the base.
  template <class At>
  void add(const std::string& path, At at, const std::function<void(Scene&)>& change = nullptr) {
    Scene scene = plain_scene();
    if (change) change(scene);
    all.push_back({section, path, scene, [at](Scene& s) -> void* { return at(s); }});
  }
};

// Both ways of giving every model. All their parameters are used.
void add_materials(Bases& bases) {
  for (const MaterialChoice& choice : material_choices()) {
    for (const bool by_young : {false, true}) {
      MaterialSettings material;
      material.model = choice.name;
      for (const MaterialParameter& parameter : by_young ? choice.instead : choice.parameters) {
        if (parameter.most_entries == 0) set_number(material, parameter.name, 0.25);
        for (int i = 0; i < parameter.most_entries; ++i) {
          set_number(material, entry_of(parameter, i).name, 0.25);
        }
      }
      bases.add(
          "material", [](Scene& s) { return &s.material; },
          [&](Scene& s) { s.material = material; });
    }
  }
}

template <class Kind>
void add_selection(Bases& bases, const std::string& kind, const Kind& selection = {}) {
  bases.add(
      "force.0.select." + kind, [](Scene& s) { return std::get_if<Kind>(&s.force[0].select); },
      [&](Scene& s) { s.force[0].select = selection; });
}

// Scenes with which any one key of the section can change. Other code reads the keys of the table
// of selections.
std::vector<Base> bases_of(const SceneSection& section) {
  Bases bases{&section};
  const std::string name = section.name;
  if (name == "mesh") {
    bases.add(
        name, [](Scene& s) { return &s.mesh; },
        [](Scene& s) {
          s.mesh.generate.reset();
          s.mesh.file = "body.vtu";
        });
  } else if (name == "mesh.generate") {
    bases.add(name, [](Scene& s) { return &*s.mesh.generate; });
  } else if (name == "material") {
    add_materials(bases);
  } else if (name == "environment") {
    bases.add(
        name, [](Scene& s) { return &s.environment; },
        [](Scene& s) { s.environment = gravity(3.0); });
  } else if (name == "pull") {
    bases.add(
        name, [](Scene& s) { return &s.pull; }, [](Scene& s) { s.pull.vertices = {4}; });
  } else if (name == "fix") {
    for (const bool is_moving : {false, true}) {
      bases.add(
          "fix.0", [](Scene& s) { return &s.fix[0]; },
          [&](Scene& s) {
            s.fix[0].select = SelectVertices{{4, 9}};
            s.fix[0].penalty = 2.0;
            if (is_moving) s.fix[0].offset = Vector3(1.0, 0.0, 0.0);
          });
    }
  } else if (name == "constraint") {
    const auto add = [&](ConstraintKind kind, bool is_driven) {
      bases.add(
          "constraint.0", [](Scene& s) { return &s.constraint[0]; },
          [&](Scene& s) {
            s.constraint[0].kind = kind;
            if (is_driven) s.constraint[0].velocity = Vector3(1.0, 0.0, 0.0);
          });
    };
    for (const ConstraintKind kind : values_of<ConstraintKind>()) add(kind, false);
    add(ConstraintKind::kRigid, true);
  } else if (const auto load = find_named<LoadKind>(name)) {
    for (const bool has_total : {false, true}) {
      if (has_total && *load != LoadKind::kForce) continue;
      bases.add(
          name + ".0", [load](Scene& s) { return &s.list(*load).at(0); },
          [&](Scene& s) {
            s.list(*load).resize(1);
            s.list(*load)[0].kind = *load;
            if (has_total) s.force[0].total = Vector3(1.0, 0.0, 0.0);
          });
    }
  } else if (name == "amplitude") {
    bases.add(
        "amplitude.0", [](Scene& s) { return &s.amplitude[0]; },
        [](Scene& s) { s.amplitude.pop_back(); });
  } else if (name == "initial.momentum") {
    bases.add("initial.momentum.0", [](Scene& s) { return &s.initial.momentum[0]; });
  } else if (name == "event") {
    bases.add(
        "event.0", [](Scene& s) { return &s.event[0]; },
        [](Scene& s) {
          s.event.resize(1);
          s.event[0].edits = {SetDamping{{1.0, 0.0, 0.0}}};
        });
  } else if (name == "shift") {
    bases.add(
        "event.0.shift", [](Scene& s) { return &std::get<ShiftState>(s.event[0].edits[0]).change; },
        [](Scene& s) {
          s.event.resize(1);
          s.event[0].edits = {ShiftState{{{2, 7},
                                          {Vector3(1, 0, 0), Vector3(0, 1, 0)},
                                          {Vector3(1, 0, 0), Vector3(0, 1, 0)},
                                          {}}}};
        });
  } else if (name == "select.plane") {
    add_selection<SelectPlane>(bases, "plane");
  } else if (name == "select.box") {
    add_selection(bases, "box", SelectBox{Vector3::Zero(), Vector3::Ones()});
  } else if (name == "select.sphere") {
    add_selection(bases, "sphere", SelectSphere{Vector3::Zero(), 1.0});
  } else if (name == "select.faces") {
    add_selection(bases, "faces", SelectFaces{Vector3::UnitZ(), 30.0});
  } else if (name == "probe") {
    bases.add("probe.0", [](Scene& s) { return &s.probe[0]; });
    bases.add(
        "probe.0", [](Scene& s) { return &s.probe[0]; },
        [](Scene& s) { s.probe[0] = probe_on("lift", "floor", ProbeQuantity::kContactMoment); });
  } else {
    for (const ScenePart& part : scene_parts()) {
      if (part.section == &section && !part.is_list) bases.add(name, part.add);
    }
  }
  return bases.all;
}

// Whether the settings can have another value of the key while the others stay as they are.
bool can_change(const SceneSection& section, const void* settings, const SceneKey& key) {
  const std::string name = key.info.name;
  if (key.value->form() == SettingValue::Form::kSelection ||
      key.value->form() == SettingValue::Form::kTable ||
      key.value->form() == SettingValue::Form::kTables ||
      key.value->form() == SettingValue::Form::kOther) {
    return false;
  }
  if (section.type == typeid(MeshSettings)) return name != "file";  // the path depends on a folder
  if (section.type == typeid(AmplitudeSettings)) return name != "file";
  // An amplitude is the factor of an offset, beside which there is no target.
  if (section.type == typeid(FixSettings)) {
    const auto& fix = *static_cast<const FixSettings*>(settings);
    if (name == "amplitude") return fix.offset.has_value();
    return !fix.offset || (name != "target" && name != "targets");
  }
  // An amplitude is the factor of the velocities of a driven handle.
  if (section.type == typeid(ConstraintSettings)) {
    const auto& constraint = *static_cast<const ConstraintSettings*>(settings);
    if (name == "amplitude") return constraint.is_driven();
    if (name == "about") return constraint.angular_velocity.has_value();
  }
  // A total is shared out; a vector is not, and the two exclude each other.
  if (name == "share" && std::string(section.name) == "force") {
    return static_cast<const ForceSettings*>(settings)->total.has_value();
  }
  // An obstacle has quantities of its own.
  if (section.type == typeid(ProbeSettings) && name == "quantity") {
    return static_cast<const ProbeSettings*>(settings)->obstacle.empty();
  }
  if (!key.is_written(settings)) return false;
  // The parameters of a material must be those of its model.
  if (section.type == typeid(MaterialSettings)) {
    const auto& material = *static_cast<const MaterialSettings*>(settings);
    if (name == "model") {
      return material.model == "stvk" || material.model == "neo-hookean";  // of the same parameters
    }
    if (key.value->form() == SettingValue::Form::kPlainOrTable) {
      return !key.value->json(settings).is_null();
    }
    return key.is_used(settings);
  }
  return !section.refuses_unused || key.is_used(settings);
}

// Another value than the settings hold.
Json other_value(const SceneKey& key, const void* settings) {
  const Json present = key.value->json(settings);
  const std::vector<const char*> names = key.value->names();
  if (!names.empty()) return present == names.front() ? names[1] : names.front();
  const Json vector{0.36, 0.48, 0.8};  // of length 1, for directions
  const std::map<std::string, Json> by_type{
      {"number", key.info.range.contains(0.375) ? 0.375 : 2.5},
      {"three numbers", vector},
      {"three numbers or one", vector},
      {"three whole numbers or one", {2, 3, 4}},
      {"text", std::string(key.info.name) == "components" ? "xz" : "other"},
      {"two whole numbers", {3, 5}},
      {"list of whole numbers", {5, 8}},
      {"list of two numbers each", {{0.0, 2.0}, {1.0, 3.0}}},
      {"list of three numbers each", {vector, {-0.36, -0.48, -0.8}}},
      {"list of texts", {"pressure", "displacement"}},
      {"number or array", key.info.range.contains(0.375) ? 0.375 : 2.5},
      {"three numbers or a table", vector}};
  const double number = key.info.range.contains(0.375) ? 0.375 : 2.5;
  if (key.value->type().find("numbers or arrays") != std::string::npos) {
    if (!present.is_array()) return number;
    Json list = present;
    list[0] = number;
    return list;
  }
  if (present.is_boolean()) return !present.get<bool>();
  if (present.is_number_integer()) return present.get<int>() + 7;
  return by_type.at(key.value->type());
}

// The parameter of a material of that name, but for the density. Null if the key is none.
const MaterialParameter* named_parameter(const SceneKey& key, const SceneSection& section) {
  if (section.type != typeid(MaterialSettings)) return nullptr;
  for (const MaterialParameter& parameter : material_parameters()) {
    if (std::string(parameter.name) == key.info.name) return &parameter;
  }
  return nullptr;
}

// The range of a number of the key; of a list that of its entries.
NumberRange range_of(const SceneKey& key, const SceneSection& section, const void* settings) {
  if (named_parameter(key, section) == nullptr || !key.value->json(settings).is_array()) {
    return key.info.range;
  }
  const std::vector<MaterialParameter>& all = material_parameters();
  const auto list = std::find_if(all.begin(), all.end(), [&](const MaterialParameter& parameter) {
    return std::string(parameter.name) == key.info.name && parameter.most_entries > 0;
  });
  return list->range;
}

// Puts a number into a key that takes numbers; false for other keys.
bool put_number(const SceneKey& key, const SceneSection& section, void* settings, double value) {
  void* member = const_cast<void*>(key.value->member(settings));
  if (member == nullptr) return false;
  const bool is_optional =
      key.value->json(section.defaults.get()).is_null() && !key.info.range.infinity;
  const std::string type = key.value->type();
  const Vector3 vector(0.5, value, 0.5);
  if (const MaterialParameter* parameter = named_parameter(key, section)) {
    const bool is_list = key.value->json(settings).is_array();
    auto& material = *static_cast<MaterialSettings*>(settings);
    set_number(material, is_list ? entry_of(*parameter, 0).name : parameter->name, value);
  } else if (type == "whole number") {
    *static_cast<int*>(member) = static_cast<int>(value);
  } else if (type == "number" || type == "number or array") {
    if (is_optional) {
      *static_cast<std::optional<double>*>(member) = value;
    } else {
      *static_cast<double*>(member) = value;
    }
  } else if (type == "three numbers" || type == "three numbers or a table") {
    if (is_optional) {
      *static_cast<std::optional<Vector3>*>(member) = vector;
    } else {
      *static_cast<Vector3*>(member) = vector;
    }
  } else if (type == "list of three numbers each") {
    *static_cast<std::vector<Vector3>*>(member) = {vector, Vector3(0.5, 0.5, 0.5)};
  } else {
    return false;
  }
  return true;
}

std::string text_of(const Json& value) {
  return value.is_null() ? "" : toml_value(value);
}

// Numbers just outside a range.
std::vector<double> outside(const NumberRange& range, bool is_whole) {
  std::vector<double> numbers;
  if (std::isfinite(range.least)) {
    numbers.push_back(range.least_itself ? std::floor(range.least) - 1.0 : range.least);
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
  std::string path() const { return (folder_ / "scene.toml").string(); }

  void expect_survival(Base base, const SceneKey& key) const {
    const SceneSection& section = *base.section;
    SCOPED_TRACE(std::string(section.name) + "." + key.info.name);
    const std::string before = text_of(key.value->json(base.settings()));
    key.value->read(other_value(key, base.settings()), key.info.range, {[] { return "refused:"; }},
                    base.settings());
    const std::string value = text_of(key.value->json(base.settings()));
    ASSERT_NE(value, before);
    ASSERT_NO_THROW(check_settings(section, base.settings()));
    write_scene(base.scene, path());
    Scene read = read_scene(path());
    EXPECT_EQ(text_of(key.value->json(base.at(read))), value);
    EXPECT_EQ(scene_text(read, folder_.string()), scene_text(base.scene, folder_.string()));
    // The echo holds it by its name.
    if (key.is_used(base.settings())) {
      EXPECT_NE(read.echo.find('"' + std::string(key.info.name) + '"'), std::string::npos);
    }
  }

  void expect_refusals(const Base& base, const SceneKey& key) const {
    const SceneSection& section = *base.section;
    Base right = base;
    const NumberRange allowed = range_of(key, section, right.settings());
    for (const double number : outside(allowed, key.value->type() == "whole number")) {
      Base wrong = base;
      if (!put_number(key, section, wrong.settings(), number)) return;
      const std::string name = key.info.name;
      const std::string value = fmt_number(number);
      const std::string range = std::isnan(number) ? "finite"
                                : number == 1e31   ? "between 1e-30 and 1e30"
                                                   : allowed.text();
      SCOPED_TRACE(std::string(section.name) + "." + name + " = " + value);
      const auto expect_message = [&](const std::string& message, const std::string& place) {
        EXPECT_NE(message.find(place + "." + name), std::string::npos) << message;
        EXPECT_NE(message.find(value), std::string::npos) << message;
        EXPECT_NE(message.find(range), std::string::npos) << message;
      };
      write_scene(base.scene, path());
      const Json json = key.value->json(wrong.settings());
      std::string text = json.is_null() ? value : toml_value(json);
      // JSON has no NaN.
      if (const auto null = text.find("null"); null != std::string::npos) {
        text.replace(null, 4, value);
      }
      const std::string change = base.path + "." + name + "=" + text;
      expect_message(message_of([&] { read_scene(path(), {change}); }), base.path);
      if (!key.is_used(wrong.settings())) continue;
      expect_message(message_of([&] { check_settings(section, wrong.settings()); }), section.name);
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

TEST_F(SettingKeys, EveryKeySurvivesWritingAndReading) {
  int count = 0;
  for (const SceneSection& section : documented_sections()) {
    for (Base& base : bases_of(section)) {
      for (const SceneKey& key : section.keys) {
        if (!can_change(section, base.settings(), key)) continue;
        expect_survival(base, key);
        ++count;
      }
    }
  }
  EXPECT_GT(count, 80);
}

TEST_F(SettingKeys, NumbersOutOfRangeAreRefusedWithKeyValueAndRange) {
  int count = 0;
  for (const SceneSection& section : documented_sections()) {
    for (Base& base : bases_of(section)) {
      for (const SceneKey& key : section.keys) {
        if (!can_change(section, base.settings(), key)) continue;
        expect_refusals(base, key);
        ++count;
      }
    }
  }
  EXPECT_GT(count, 80);
}

TEST_F(SettingKeys, NamesAreFoundByTheirMembers) {
  EXPECT_STREQ(key_info(&Damping::drag).name, "drag");
  EXPECT_STREQ(key_info(&TimeSettings::step).unit, "s");
  EXPECT_STREQ(key_info(&SolverSettings::max_iterations).name, "max_iterations");
  EXPECT_STREQ(key_info(&ForceSettings::vector).unit, "N");
}

TEST_F(SettingKeys, EveryKeyHasAMeaningAndANameOfItsOwn) {
  for (const SceneSection& section : documented_sections()) {
    std::vector<std::string> names;
    for (const SceneKey& key : section.keys) {
      EXPECT_STRNE(key.info.help, "") << section.name << "." << key.info.name;
      names.emplace_back(key.info.name);
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << section.name;
  }
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
