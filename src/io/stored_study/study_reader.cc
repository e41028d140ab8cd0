#include "study_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "io/study/study_answer.h"
#include "io/study/study_fields.h"
#include "io/study/study_row_json.h"
#include "study_members.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"

namespace tetraction {
namespace {

using OrderedJson = nlohmann::ordered_json;

class StudyReader {
 public:
  explicit StudyReader(const std::string& path)
      : text_(read_study_text(path)), json_(text_.json), read_(text_.path, "", hint()) {}

  StoredStudy study() {
    StoredStudy study;
    const ForeignJson& made_by = member_of(json_, "version");
    if (made_by.is_string()) study.version = made_by.get<std::string>();
    study.scene = read_.text(json_, "scene");
    study.provenance = {read_.text(json_, "command"), read_.text(json_, "date")};
    read_heads();
    read_variants();
    read_rows();
    read_references();
    mark_references();
    if (json_.contains("plan")) {
      study.plan = plan();
      study.provenance.plan = json_["plan"].dump();
    }
    study.result = std::move(result_);
    study.text = std::move(text_.text);
    return study;
  }

 private:
  std::string hint() const {
    const ForeignJson& made_by = member_of(json_, "version");
    if (made_by == version()) return {};
    return fmt::format(
        " Another version of the program than this one, {}, made it: make the study again.",
        version());
  }

  // Calls `take` and reports a value of another kind as a wrong member.
  template <class Take>
  auto checked(const StudyMembers& read, const char* key, const Take& take) const {
    try {
      return take();
    } catch (const nlohmann::json::exception&) {
      read.fail(fmt::format("\"{}\" has a value of another kind", key));
    } catch (const InputError&) {
      read.fail(fmt::format("\"{}\" has an unknown value", key));
    }
  }

  Integrator integrator(const StudyMembers& read, const ForeignJson& json, const char* key) const {
    const std::string name = read.text(json, key);
    return checked(read, key, [&] { return integrator_from_string(name); });
  }

  RunStatus status(const StudyMembers& read, const ForeignJson& json) const {
    const std::string word = read.text(json, "status");
    return checked(read, "status", [&] { return status_from_string(word); });
  }

  void read_heads() {
    result_.is_interrupted = read_.flag(json_, "interrupted");
    const double limit = read_.number(json_, "stable_step");
    result_.stable_step = std::isnan(limit) ? std::numeric_limits<double>::infinity() : limit;
    result_.end = read_.positive(json_, "end");
    result_.remarks = read_.texts(json_, "remarks");
    const std::string error = read_.text(json_, "error");
    if (error != "position") {
      const ErrorMeasure measure =
          checked(read_, "error", [&] { return read_error_measure(error); });
      result_.error_probe = measure.name;
      result_.error_kind = measure.kind;
    }
    const double target = read_.number(json_, "target");
    if (!std::isnan(target)) result_.target = read_.positive(json_, "target");
    if (json_.contains("searched")) {
      result_.findings = checked(
          read_, "searched", [&] { return findings_from_json(json_["searched"], result_.end); });
    }
    if (json_.contains("mesh_check")) result_.mesh_check = mesh_check();
    std::size_t first = 0;
    for (const ForeignJson& probe : read_.list(json_, "probes")) {
      const StudyMembers read = read_.in("in \"probes\", ");
      read.require_object(probe);
      const auto quantity = find_named<ProbeQuantity>(read.text(probe, "quantity"));
      if (!quantity) read.fail("\"quantity\" is unknown");
      result_.probes.push_back(
          {read.text(probe, "name"), *quantity, first, read.texts(probe, "columns")});
      first += result_.probes.back().size();
    }
  }

  MeshCheck mesh_check() const {
    const StudyMembers read = read_.in("in \"mesh_check\", ");
    const ForeignJson& json = json_["mesh_check"];
    read.require_object(json);
    constexpr std::size_t kMost = 1'000'000'000'000;
    MeshCheck check;
    check.integrator = integrator(read, json, "integrator");
    check.step = read.positive(json, "step");
    check.vertices = static_cast<Index>(read.index(read.member(json, "vertices"), kMost));
    check.tetrahedra = static_cast<Index>(read.index(read.member(json, "tetrahedra"), kMost));
    check.status = status(read, json);
    check.directory = read.folder(json, "directory");
    check.difference = read.number(json, "difference");
    return check;
  }

  void read_variants() {
    if (!json_.contains("variants")) return;
    std::set<std::string> names;
    for (const ForeignJson& variant : read_.list(json_, "variants")) {
      const StudyMembers read = read_.in("in \"variants\", ");
      read.require_object(variant);
      VariantValues values{read.text(variant, "name"), {}};
      const ForeignJson& list = read.member(variant, "values");
      read.require_object(list);
      for (const auto& [key, value] : list.items()) {
        values.values.push_back({key, read.text(list, key.c_str())});
      }
      if (!names.insert(values.name).second) read.fail("a name is there twice");
      result_.variants.push_back(std::move(values));
    }
  }

  void read_rows() {
    std::set<std::string> folders;
    std::size_t entry = 0;
    for (const ForeignJson& run : json_["runs"]) {
      const StudyMembers read = read_.in(fmt::format("in entry {} of \"runs\", ", ++entry));
      read.require_object(run);
      StudyRow row;
      for (const StudyField& field : study_fields()) {
        if (!field.is_in(kInJson)) continue;
        const std::vector<std::string> words = field_words(field);
        if (!words.empty()) read.word(run, field.name, words);
        if (field.is_number() && !field.is_in(kDerived)) read.number(run, field.name);
        const ForeignJson& value = read.member(run, field.name);
        checked(read, field.name, [&] { read_field(field, value, row); });
      }
      read.positive(run, "step");
      read.folder(run, "directory");
      require_variant(read, row.variant);
      if (!folders.insert(row.directory).second) read.fail("\"directory\" is that of another run");
      result_.rows.push_back(std::move(row));
    }
  }

  void require_variant(const StudyMembers& read, const std::string& name) const {
    const auto& variants = result_.variants;
    const bool is_known = variants.empty()
                              ? name.empty()
                              : std::any_of(variants.begin(), variants.end(),
                                            [&](const auto& other) { return other.name == name; });
    if (!is_known) read.fail("\"variant\" is none of the variants");
  }

  std::optional<ReferenceExtrapolation> extrapolation(const StudyMembers& read,
                                                      const ForeignJson& json) const {
    if (!json.contains("extrapolation")) return {};
    return checked(read, "extrapolation",
                   [&] { return extrapolation_from_json(json["extrapolation"]); });
  }

  void read_references() {
    const StudyMembers read = read_.in("in \"reference\", ");
    const ForeignJson& reference = read_.member(json_, "reference");
    read.require_object(reference);
    result_.reference_integrator = integrator(read, reference, "integrator");
    result_.reference_step = read.positive(reference, "step");
    result_.reference_status = status(read, reference);
    result_.reference_directory = read.folder(reference, "directory");
    result_.reference_error = read.number(reference, "estimated_error");
    result_.extrapolation = extrapolation(read, reference);
    if (!json_.contains("references")) return;
    std::set<std::string> compared;
    for (const ForeignJson& json : read_.list(json_, "references")) {
      const StudyMembers of = read_.in("in \"references\", ");
      of.require_object(json);
      VariantReference each;
      each.variants = of.texts(json, "variants");
      for (const std::string& variant : each.variants) {
        require_variant(of, variant);
        if (!compared.insert(variant).second) of.fail("a variant has two references");
      }
      if (each.variants.empty()) of.fail("\"variants\" is empty");
      each.variant = each.variants.front();
      each.status = status(of, json);
      each.directory = of.folder(json, "directory");
      each.error = of.number(json, "estimated_error");
      each.difference = {of.number(json, "position_difference"),
                         of.number(json, "position_difference_rms"),
                         of.number(json, "probe_difference")};
      each.extrapolation = extrapolation(of, json);
      result_.references.push_back(std::move(each));
    }
    if (result_.references.size() == 1) read_.fail("\"references\" has only one entry");
  }

  // A run is the reference itself unless that is extrapolated.
  void mark_references() {
    const bool has_probe = !result_.error_probe.empty();
    const auto mark = [&](const auto& extrapolation, RunStatus status, const std::string& folder) {
      if (status != RunStatus::kFinished) return;
      if (extrapolation && extrapolation->is_valid_for(has_probe)) return;
      for (StudyRow& row : result_.rows) row.is_reference |= row.directory == folder;
    };
    mark(result_.extrapolation, result_.reference_status, result_.reference_directory);
    for (const VariantReference& each : result_.references) {
      mark(each.extrapolation, each.status, each.directory);
    }
  }

  StoredPlan plan() {
    const StudyMembers read = read_.in("in \"plan\", ");
    const ForeignJson& json = json_["plan"];
    read.require_object(json);
    StudyPlan plan;
    for (const VariantValues& variant : result_.variants) {
      plan.variants.push_back({variant.name, {}, {}, variant.values});
    }
    if (plan.variants.empty()) plan.variants.emplace_back();
    plan.stable_step = result_.stable_step;
    plan.end = result_.end;
    plan.error_probe = result_.error_probe;
    plan.error_kind = result_.error_kind;
    plan.probes = result_.probes;
    RunDigests digests(read.text(json, "build"), read.texts(json, "scenes"),
                       read.texts(json, "meshes"));
    const std::size_t variants = plan.variants.size();
    if (digests.scenes().size() != variants || digests.meshes().size() != variants) {
      read.fail("\"scenes\" and \"meshes\" are not those of the variants");
    }
    std::map<std::string, std::size_t> places;
    for (const ForeignJson& run : read.list(json, "runs")) {
      read.require_object(run);
      PlannedRun planned;
      planned.variant = read.index(read.member(run, "variant"), variants);
      planned.directory = read.folder(run, "directory");
      planned.integrator = integrator(read, run, "integrator");
      planned.step = read.positive(run, "step");
      planned.solver = read.text(run, "solver");
      planned.compares_solver = read.flag(run, "compares_solver");
      planned.is_left_out = read.flag(run, "left_out");
      const std::string role = read.text(run, "role");
      planned.role = checked(read, "role", [&] { return role_from_string(role); });
      for (const ForeignJson& varied : read.list(run, "settings")) {
        read.require_object(varied);
        planned.settings.push_back({read.text(varied, "key"), read.text(varied, "value")});
      }
      if (!places.emplace(planned.directory, plan.runs.size()).second) {
        read.fail("two runs have the same \"directory\"");
      }
      plan.runs.push_back(std::move(planned));
    }
    read_planned_references(read, json, plan, places);
    for (const StudyRow& row : result_.rows) {
      const auto place = places.find(row.directory);
      const PlannedRun* run = place == places.end() ? nullptr : &plan.runs[place->second];
      if (run == nullptr || run->integrator != row.integrator || run->step != row.step ||
          run->solver != row.solver || plan.variants[run->variant].name != row.variant) {
        read.fail(fmt::format("there is no run {}", row.directory));
      }
    }
    for (const PlannedRun& run : plan.runs) result_.left_out += run.is_left_out ? 1U : 0U;
    return {std::move(plan), std::move(digests)};
  }

  static void read_planned_references(const StudyMembers& read, const ForeignJson& json,
                                      StudyPlan& plan,
                                      const std::map<std::string, std::size_t>& places) {
    for (const ForeignJson& reference : read.list(json, "references")) {
      read.require_object(reference);
      PlannedReference planned;
      planned.variant = read.index(read.member(reference, "variant"), plan.variants.size());
      for (const std::string& folder : read.texts(reference, "runs")) {
        const auto place = places.find(folder);
        if (place == places.end()) read.fail("a run of a reference is not among the runs");
        planned.runs.push_back(place->second);
      }
      if (planned.runs.size() != 1 && planned.runs.size() != 3) {
        read.fail("a reference has neither one run nor three");
      }
      const ForeignJson& has_first_mesh = read.member(reference, "has_first_mesh");
      if (!has_first_mesh.is_boolean()) read.fail("\"has_first_mesh\" is neither true nor false");
      plan.has_first_mesh.push_back(has_first_mesh.get<bool>());
      plan.references.push_back(std::move(planned));
    }
    if (plan.references.empty()) read.fail("there is no reference");
    for (const ForeignJson& number : read.list(json, "reference_of")) {
      plan.reference_of.push_back(read.index(number, plan.references.size()));
    }
    if (plan.reference_of.size() != plan.variants.size()) {
      read.fail("\"reference_of\" is not that of the variants");
    }
  }

  StudyText text_;
  const ForeignJson& json_;
  StudyMembers read_;
  StudyResult result_;
};

}  // namespace

std::string study_plan_json(const StudyPlan& plan, const RunDigests& digests) {
  OrderedJson json{{"build", digests.build()},
                   {"scenes", digests.scenes()},
                   {"meshes", digests.meshes()},
                   {"reference_of", plan.reference_of}};
  json["references"] = OrderedJson::array();
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    OrderedJson folders = OrderedJson::array();
    for (const std::size_t run : plan.references[i].runs) {
      folders.push_back(plan.runs[run].directory);
    }
    json["references"].push_back({{"variant", plan.references[i].variant},
                                  {"has_first_mesh", bool{plan.has_first_mesh[i]}},
                                  {"runs", std::move(folders)}});
  }
  json["runs"] = OrderedJson::array();
  for (const PlannedRun& run : plan.runs) {
    OrderedJson settings = OrderedJson::array();
    for (const VariedValue& varied : run.settings) {
      settings.push_back({{"key", varied.key}, {"value", varied.value}});
    }
    json["runs"].push_back({{"directory", run.directory},
                            {"variant", run.variant},
                            {"integrator", to_string(run.integrator)},
                            {"step", run.step},
                            {"solver", run.solver},
                            {"compares_solver", run.compares_solver},
                            {"settings", std::move(settings)},
                            {"role", to_string(run.role)},
                            {"left_out", run.is_left_out}});
  }
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

StoredStudy read_stored_study(const std::string& path) {
  return StudyReader(path).study();
}

}  // namespace tetraction
