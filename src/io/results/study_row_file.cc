#include "study_row_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_row_json.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

// The members of a ReferenceDifference, which may be absent.
constexpr std::array<std::pair<const char*, double ReferenceDifference::*>, 3> kDifferences{
    {{"reference_position_difference", &ReferenceDifference::position},
     {"reference_position_difference_rms", &ReferenceDifference::position_rms},
     {"reference_probe_difference", &ReferenceDifference::probe}}};

// FNV-1a over the bytes of numbers: it finds changes, not forgeries.
class Digest {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 1099511628211U;
  }
  void add(const std::string& text) {
    add(text.data(), text.size());
    add(std::uint64_t{text.size()});
  }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number number) { add(&number, sizeof(number)); }
  void add(const Matrix& matrix) {
    add(matrix.rows());
    add(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }
  std::string text() const { return fmt::format("{:016x}", value_); }

 private:
  std::uint64_t value_ = 14695981039346656037U;
};

std::string digest_of(const TetMesh& mesh) {
  Digest digest;
  for (const auto vertex : mesh.vertices) {
    for (int d = 0; d < 3; ++d) digest.add(vertex[d]);
  }
  for (const auto tetrahedron : mesh.tetrahedra) {
    for (std::size_t i = 0; i < 4; ++i) digest.add(static_cast<std::int64_t>(tetrahedron[i]));
  }
  for (const auto& middles : mesh.edge_vertices) {
    for (const Index v : middles) digest.add(v);
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) digest.add(mesh.vertex_id(v));
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    digest.add(mesh.tetrahedron_id(e));
    digest.add(mesh.region(e));
  }
  for (const auto* arrays : {&mesh.point_arrays, &mesh.cell_arrays}) {
    for (const auto& [name, values] : *arrays) {
      digest.add(name);
      digest.add(values);
    }
  }
  for (const Group& group : mesh.groups) {
    digest.add(group.name);
    for (const Index v : group.vertices) digest.add(v);
    for (const Index e : group.tetrahedra) digest.add(e);
    for (const auto& triangle : group.triangles) {
      for (const Index v : triangle) digest.add(v);
    }
  }
  return digest.text();
}

std::string digest_of(const std::vector<double>& numbers) {
  Digest digest;
  for (const double number : numbers) digest.add(number);
  return fmt::format("{} of the digest {}", numbers.size(), digest.text());
}

nlohmann::json scene_json(const StudyVariant& variant) {
  nlohmann::json scene = nlohmann::json::parse(variant.scene.echo, nullptr, false);
  if (scene.is_object()) {
    scene.erase("output");
  } else {
    scene = nullptr;  // that of a program
  }
  Digest files;
  for (const AmplitudeSettings& amplitude : variant.scene.amplitude) {
    for (const auto& [time, value] : amplitude.points) {
      files.add(time);
      files.add(value);
    }
  }
  return {{"name", variant.name}, {"scene", scene}, {"amplitudes", files.text()}};
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
