#include "study_row_file.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/fingerprint.h"
#include "io/text/check_sum.h"
#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_row_json.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/mesh_fingerprints.h"

namespace tetraction {
namespace {

std::string text_of(const Fingerprint& number) {
  return fmt::format("{:016x}", number.value());
}

// The file with this code: the program, or a library that another program has loaded, as Python does.
std::string this_file() {
  static const char here = 0;
  Dl_info info{};
  void* found = nullptr;
  const bool is_known = ::dladdr1(&here, &info, &found, RTLD_DL_LINKMAP) != 0;
  const char* library = is_known ? static_cast<const link_map*>(found)->l_name : "";
  return *library != '\0' ? library : "/proc/self/exe";
}

// The version of the program, and its file, since builds of the same version may compute something else.
std::string this_build() {
  std::ifstream file(this_file(), std::ios::binary);
  std::vector<char> bytes(std::size_t{1} << 20U);
  std::uint32_t sum = 0;
  while (file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) || file.gcount() > 0) {
    sum = check_sum({bytes.data(), static_cast<std::size_t>(file.gcount())}, sum);
  }
  return fmt::format("{} {:08x}", version(), sum);
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

// Without integrator and step, which are those of the run.
std::string digest_of(const Scene& scene) {
  nlohmann::json json = nlohmann::json::parse(scene.echo, nullptr, false);
  if (json.is_object()) {
    json.erase("output");
    for (const char* key : {"integrator", "step"}) json["time"].erase(key);
  } else {
    json = nullptr;  // that of a program
  }
  Fingerprint files;
  for (const AmplitudeSettings& amplitude : scene.amplitude) {
    for (const auto& [time, value] : amplitude.points) {
      files.add(time);
      files.add(value);
    }
  }
  files.add(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return text_of(files);
}

}  // namespace

RunDigests::RunDigests(const StudyPlan& plan, const TetMesh& mesh) : build_(this_build()) {
  std::map<const TetMesh*, std::string> digests;
  for (const StudyVariant& variant : plan.variants) {
    const TetMesh& own = variant.mesh ? *variant.mesh : mesh;
    std::string& digest = digests[&own];
    if (digest.empty()) digest = digest_of(own);
    scenes_.push_back(digest_of(variant.scene));
    meshes_.push_back(digest);
  }
}

std::string RunDigests::of(const PlannedRun& run) const {
  Fingerprint number;
  number.add(build_);
  number.add(scenes_[run.variant]);
  number.add(meshes_[run.variant]);
  number.add(to_string(run.integrator));
  number.add(run.step);
  number.add(run.solver);
  for (const VariedValue& setting : run.settings) {
    number.add(setting.key);
    number.add(setting.value);
  }
  return text_of(number);
}

void write_study_row(const std::string& path, const StudyRow& row, const std::string& digest) {
  const nlohmann::ordered_json json{{"digest", digest}, {"row", study_row_json(row)}};
  write_text_file(
      path, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<StudyRow> read_study_row(const std::string& path, const PlannedRun& planned,
                                       const std::string& digest) {
  const auto json = parse_foreign_json(read_output(path));
  if (member_of(json, "digest") != digest) return {};
  std::optional<StudyRow> row = study_row_from_json(member_of(json, "row"));
  if (!row || row->integrator != planned.integrator || row->step != planned.step ||
      row->solver != planned.solver || row->directory != planned.directory) {
    return {};
  }
  row->role = planned.role;
  row->compares_solver = planned.compares_solver;
  return row;
}

}  // namespace tetraction
