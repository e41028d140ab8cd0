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

using Members = StudyMembers;

Integrator integrator_in(const Members& read, const char* key) {
  return read.named(key, &integrator_from_string);
}

RunStatus status_in(const Members& read) {
  return read.named("status", &status_from_string);
}

std::optional<ReferenceExtrapolation> extrapolation_in(const Members& read) {
  if (!read.has("extrapolation")) return {};
  return read.as("extrapolation", &extrapolation_from_json);
}

class StudyReader {
 public:
  explicit StudyReader(const std::string& path)
      : text_(read_study_text(path)), read_(text_.path, "", hint(), &text_.json) {}

  StoredStudy study() {
    StoredStudy study;
    study.scene = read_.text("scene");
    study.provenance = {read_.text("command"), read_.text("date")};
    const ForeignJson& made_by = member_of(text_.json, "version");
    if (made_by.is_string()) study.provenance.version = made_by.get<std::string>();
    read_heads();
    read_variants();
    read_rows();
    read_references();
    mark_references();
    if (read_.has("plan")) {
      study.plan = plan(read_.table("plan"));
      study.provenance.plan = text_.json["plan"].dump();
    }
    study.result = std::move(result_);
    study.text = std::move(text_.text);
    return study;
  }

 private:
  std::string hint() const {
    if (member_of(text_.json, "version") == version()) return {};
    return fmt::format(
        " Another version of the program than this one, {}, made it: make the study again.",
        version());
  }

  void read_heads() {
    result_.is_interrupted = read_.flag("interrupted");
    const double limit = read_.number("stable_step");
    result_.stable_step = std::isnan(limit) ? std::numeric_limits<double>::infinity() : limit;
    result_.end = read_.positive("end");
    result_.remarks = read_.texts("remarks");
    if (read_.text("error") != "position") {
      const auto measure = read_.named("error", &read_error_measure);
      result_.error_probe = measure.name;
      result_.error_kind = measure.kind;
    }
    if (!std::isnan(read_.number("target"))) result_.target = read_.positive("target");
    if (read_.has("searched")) {
      result_.findings = read_.as("searched", [&](const ForeignJson& json) {
        return findings_from_json(json, result_.end);
      });
    }
    if (read_.has("mesh_check")) result_.mesh_check = mesh_check(read_.table("mesh_check"));
    std::size_t first = 0;
    for (const Members& read : read_.tables("probes")) {
      const auto quantity = find_named<ProbeQuantity>(read.text("quantity"));
      if (!quantity) read.fail("\"quantity\" is unknown");
      result_.probes.push_back({read.text("name"), *quantity, first, read.texts("columns")});
      first += result_.probes.back().size();
    }
  }

  static MeshCheck mesh_check(const Members& read) {
    constexpr std::size_t kMost = 1'000'000'000'000;
    MeshCheck check;
    check.integrator = integrator_in(read, "integrator");
    check.step = read.number("step");
    check.vertices = static_cast<Index>(read.index("vertices", kMost));
    check.tetrahedra = static_cast<Index>(read.index("tetrahedra", kMost));
    check.status = status_in(read);
    if (!read.text("directory").empty()) check.directory = read.folder("directory");
    check.difference = read.number("difference");
    return check;
  }

  void read_variants() {
    if (!read_.has("variants")) return;
    std::set<std::string> names;
    for (const Members& read : read_.tables("variants")) {
      VariantValues values{read.text("name"), {}};
      const Members list = read.table("values");
      for (const auto& [key, value] : read.member("values").items()) {
        values.values.push_back({key, list.text(key.c_str())});
      }
      if (!names.insert(values.name).second) read.fail("a name is there twice");
      result_.variants.push_back(std::move(values));
    }
  }

  void read_rows() {
    std::set<std::string> folders;
    for (const Members& read : read_.tables("runs")) {
      StudyRow row;
      for (const StudyField& field : study_fields()) {
        if (!field.is_in(kInJson)) continue;
        const std::vector<std::string> words = field_words(field);
        if (!words.empty()) read.word(field.name, words);
        if (field.is_number() && !field.is_in(kDerived)) read.number(field.name);
        read.as(field.name, [&](const ForeignJson& value) { read_field(field, value, row); });
      }
      read.positive("step");
      read.folder("directory");
      require_variant(read, row.variant);
      if (!folders.insert(row.directory).second) read.fail("\"directory\" is that of another run");
      result_.rows.push_back(std::move(row));
    }
  }

  void require_variant(const Members& read, const std::string& name) const {
    const auto& variants = result_.variants;
    const bool is_known = variants.empty()
                              ? name.empty()
                              : std::any_of(variants.begin(), variants.end(),
                                            [&](const auto& other) { return other.name == name; });
    if (!is_known) read.fail("\"variant\" is none of the variants");
  }

  void read_references() {
    const Members reference = read_.table("reference");
    result_.reference_integrator = integrator_in(reference, "integrator");
    result_.reference_step = reference.positive("step");
    result_.reference_status = status_in(reference);
    result_.reference_directory = reference.folder("directory");
    result_.reference_error = reference.number("estimated_error");
    result_.extrapolation = extrapolation_in(reference);
    if (!read_.has("references")) return;
    std::set<std::string> compared;
    for (const Members& read : read_.tables("references")) {
      VariantReference each;
      each.variants = read.texts("variants");
      for (const std::string& variant : each.variants) {
        require_variant(read, variant);
        if (!compared.insert(variant).second) read.fail("a variant has two references");
      }
      if (each.variants.empty()) read.fail("\"variants\" is empty");
      each.variant = each.variants.front();
      each.status = status_in(read);
      each.directory = read.folder("directory");
      each.error = read.number("estimated_error");
      each.difference = {read.number("position_difference"), read.number("position_difference_rms"),
                         read.number("probe_difference")};
      each.extrapolation = extrapolation_in(read);
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

  StoredPlan plan(const Members& read) {
    StudyPlan plan;
    for (const VariantValues& variant : result_.variants) {
      StudyVariant& stored = plan.variants.emplace_back();
      stored.name = variant.name;
      stored.values = variant.values;
    }
    if (plan.variants.empty()) plan.variants.emplace_back();
    plan.stable_step = result_.stable_step;
    plan.end = result_.end;
    plan.error_probe = result_.error_probe;
    plan.error_kind = result_.error_kind;
    plan.probes = result_.probes;
    RunDigests digests(read.text("build"), read.texts("scenes"), read.texts("meshes"));
    const std::size_t variants = plan.variants.size();
    if (digests.scenes().size() != variants || digests.meshes().size() != variants) {
      read.fail("\"scenes\" and \"meshes\" are not those of the variants");
    }
    std::map<std::string, std::size_t> places;
    for (const Members& run : read.tables("runs")) {
      plan.runs.push_back(planned_run(run, variants));
      if (!places.emplace(plan.runs.back().directory, places.size()).second) {
        read.fail("two runs have the same \"directory\"");
      }
      result_.left_out += plan.runs.back().is_left_out ? 1U : 0U;
    }
    for (const Members& reference : read.tables("references")) {
      PlannedReference planned{reference.index("variant", variants), {}};
      for (const std::string& folder : reference.texts("runs")) {
        const auto place = places.find(folder);
        if (place == places.end()) reference.fail("a run of a reference is not among the runs");
        planned.runs.push_back(place->second);
      }
      if (planned.runs.size() != 1 && planned.runs.size() != 3) {
        reference.fail("a reference has neither one run nor three");
      }
      plan.has_first_mesh.push_back(reference.flag("has_first_mesh"));
      plan.references.push_back(std::move(planned));
    }
    if (plan.references.empty()) read.fail("there is no reference");
    plan.reference_of = read.indices("reference_of", plan.references.size());
    if (plan.reference_of.size() != variants) {
      read.fail("\"reference_of\" is not that of the variants");
    }
    for (const StudyRow& row : result_.rows) {
      const auto place = places.find(row.directory);
      const PlannedRun* run = place == places.end() ? nullptr : &plan.runs[place->second];
      if (run == nullptr || run->integrator != row.integrator || run->step != row.step ||
          run->solver != row.solver || to_string(run->settings) != row.settings ||
          plan.variants[run->variant].name != row.variant) {
        read.fail(fmt::format("there is no run {}", row.directory));
      }
    }
    return {std::move(plan), std::move(digests)};
  }

  static PlannedRun planned_run(const Members& read, std::size_t variants) {
    PlannedRun run;
    run.variant = read.index("variant", variants);
    run.directory = read.folder("directory");
    run.integrator = integrator_in(read, "integrator");
    run.step = read.positive("step");
    run.solver = read.text("solver");
    run.compares_solver = read.flag("compares_solver");
    run.is_left_out = read.flag("left_out");
    run.role = read.named("role", &from_string<StudyRole>);
    for (const Members& varied : read.tables("settings")) {
      run.settings.push_back({varied.text("key"), varied.text("value")});
    }
    return run;
  }

  StudyText text_;
  const Members read_;
  StudyResult result_;
};

}  // namespace

StoredStudy read_stored_study(const std::string& path) {
  return StudyReader(path).study();
}

}  // namespace tetraction
