#include "study_row_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/fingerprint.h"
#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_row_json.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/mesh_fingerprints.h"

namespace tetraction {
namespace {

// The members of a ReferenceDifference, which may be absent.
constexpr std::array<std::pair<const char*, double ReferenceDifference::*>, 3> kDifferences{
    {{"reference_position_difference", &ReferenceDifference::position},
     {"reference_position_difference_rms", &ReferenceDifference::position_rms},
     {"reference_probe_difference", &ReferenceDifference::probe}}};

std::string text_of(const Fingerprint& number) {
  return fmt::format("{:016x}", number.value());
}

std::string digest_of(const TetMesh& mesh) {
  Fingerprint number;
  const MeshFingerprints parts = fingerprints_of(mesh);
  for (const std::uint64_t part : {parts.body, parts.numbers, parts.fields}) number.add(part);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    number.add(static_cast<std::uint64_t>(mesh.region(e)));
  }
  return text_of(number);
}

std::string digest_of(const std::vector<double>& numbers) {
  Fingerprint number;
  for (const double each : numbers) number.add(each);
  return fmt::format("{} of the digest {}", numbers.size(), text_of(number));
}

nlohmann::json scene_json(const StudyVariant& variant) {
  nlohmann::json scene = nlohmann::json::parse(variant.scene.echo, nullptr, false);
  if (scene.is_object()) {
    scene.erase("output");
  } else {
    scene = nullptr;  // that of a program
  }
  Fingerprint files;
  for (const AmplitudeSettings& amplitude : variant.scene.amplitude) {
    for (const auto& [time, value] : amplitude.points) {
      files.add(time);
      files.add(value);
    }
  }
  return {{"name", variant.name}, {"scene", scene}, {"amplitudes", text_of(files)}};
}

}  // namespace

StudyInputs::StudyInputs(const StudyPlan& plan, const TetMesh& mesh) {
  std::map<const TetMesh*, std::string> digests;
  std::vector<nlohmann::json> scenes;
  for (const StudyVariant& variant : plan.variants) {
    const TetMesh& own = variant.mesh ? *variant.mesh : mesh;
    std::string& digest = digests[&own];
    if (digest.empty()) digest = digest_of(own);
    scenes.push_back(scene_json(variant));
    scenes.back()["mesh"] = digest;
  }
  const auto reference_json = [&](const PlannedReference& reference) {
    nlohmann::json runs = nlohmann::json::array();
    for (const PlannedRun& run : reference.runs) {
      runs.push_back({run.directory, to_string(run.integrator), run.step, run.solver});
    }
    return nlohmann::json{{"variant", scenes[reference.variant()]}, {"runs", runs}};
  };
  // Runs are compared with the reference at times that depend on all steps.
  std::vector<double> steps;
  for (const PlannedRun& run : plan.runs) steps.push_back(run.step);
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  nlohmann::json json;
  json["version"] = version();
  json["end"] = plan.end;
  json["error_probe"] = plan.error_probe;
  json["steps"] = digest_of(steps);
  // Further references are compared with the first one.
  const nlohmann::json first = reference_json(plan.references.front());
  const bool has_others = plan.references.size() > 1;
  for (std::size_t i = 0; i < plan.variants.size(); ++i) {
    const PlannedReference& reference = plan.references[plan.reference_of[i]];
    json["variant"] = scenes[i];
    json["reference"] = reference_json(reference);
    json["first_reference"] = has_others ? first : nlohmann::json();
    texts_.push_back(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
}

void write_study_row(const std::string& path, const StudyRow& row, const std::string& inputs) {
  nlohmann::ordered_json json;
  json["row"] = study_row_json(row);
  if (row.extrapolation) json["extrapolation"] = extrapolation_json(*row.extrapolation);
  const ReferenceDifference& difference = row.reference_difference;
  for (const auto& [key, value] : kDifferences) {
    if (std::isfinite(difference.*value)) json[key] = difference.*value;
  }
  json["inputs"] = nlohmann::ordered_json::parse(inputs);
  write_text_file(
      path, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<StudyRow> read_study_row(const std::string& path, const PlannedRun& planned,
                                       const std::string& inputs) {
  const auto json = parse_foreign_json(read_output(path));
  const auto wanted = nlohmann::json::parse(inputs);
  if (member_of(json, "inputs") != wanted) return {};
  std::optional<StudyRow> row = study_row_from_json(member_of(json, "row"));
  if (!row || row->integrator != planned.integrator || row->step != planned.step ||
      row->solver != planned.solver || row->directory != planned.directory ||
      member_of(member_of(wanted, "variant"), "name") != row->variant) {
    return {};
  }
  if (json.contains("extrapolation")) {
    row->extrapolation = extrapolation_from_json(json["extrapolation"]);
    if (!row->extrapolation) return {};
  }
  for (const auto& [key, value] : kDifferences) {
    if (!json.contains(key)) continue;
    if (!json[key].is_number()) return {};
    row->reference_difference.*value = json[key].get<double>();
  }
  return row;
}

}  // namespace tetraction
