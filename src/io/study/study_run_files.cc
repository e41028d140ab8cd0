#include "study_run_files.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/fingerprint.h"
#include "io/scene/obstacle_surfaces.h"
#include "io/text/byte_stream.h"
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
  add_surfaces(scene, files);
  files.add(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return text_of(files);
}

// The file has this text, the size and the check sum of the rest, and the rest.
constexpr std::string_view kHead = "tetraction track 1\n";

struct Seal {
  std::uint64_t size = 0;
  std::uint64_t sum = 0;
};

Vector vector_of(std::vector<double> numbers) {
  return Eigen::Map<const Vector>(numbers.data(), static_cast<Index>(numbers.size()));
}

void put(ByteWriter& bytes, const Vector& vector) {
  bytes.put_all(vector.data(), static_cast<std::size_t>(vector.size()));
}

// What follows the seal of the file. Empty if there is none, or if it is damaged.
std::string read_sealed(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(path, error))) return {};
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  const std::size_t begin = kHead.size() + sizeof(Seal);
  if (error || size < begin) return {};
  std::ifstream file(path, std::ios::binary);
  std::string head(begin, '\0');
  file.read(head.data(), static_cast<std::streamsize>(begin));
  const std::string numbers = head.substr(kHead.size());
  const auto seal = ByteReader(numbers).get<Seal>();
  if (!file || !head.starts_with(kHead) || seal.size != size - begin) return {};
  std::string rest(seal.size, '\0');
  file.read(rest.data(), static_cast<std::streamsize>(rest.size()));
  if (!file || check_sum(rest) != seal.sum) return {};
  return rest;
}

// Whether all parts have the sizes that belong to each other.
bool is_consistent(const MotionTrack& track) {
  if (track.count != track_times(track.rest.size()) || track.positions.size() > track.count) {
    return false;
  }
  for (const Vector& position : track.positions) {
    if (position.size() != track.rest.size()) return false;
  }
  for (const ProbeRecord& probe : track.probes) {
    const std::size_t count = probe.times.size();
    if (count == 0 || probe.values.size() % count != 0 ||
        probe.values.size() / count != probe.width) {
      return false;
    }
  }
  return true;
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

std::string study_plan_json(const StudyPlan& plan, const RunDigests& digests) {
  nlohmann::ordered_json json{{"build", digests.build()},
                              {"scenes", digests.scenes()},
                              {"meshes", digests.meshes()},
                              {"reference_of", plan.reference_of}};
  json["references"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    nlohmann::ordered_json folders = nlohmann::ordered_json::array();
    for (const std::size_t run : plan.references[i].runs) {
      folders.push_back(plan.runs[run].directory);
    }
    json["references"].push_back({{"variant", plan.references[i].variant},
                                  {"has_first_mesh", bool{plan.has_first_mesh[i]}},
                                  {"runs", std::move(folders)}});
  }
  json["runs"] = nlohmann::ordered_json::array();
  for (const PlannedRun& run : plan.runs) {
    nlohmann::ordered_json settings = nlohmann::ordered_json::array();
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
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void write_study_row(const std::string& path, const StudyRow& row, const std::string& digest) {
  const nlohmann::ordered_json json{{"digest", digest}, {"row", study_row_json(row)}};
  write_text_file(
      path, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<StudyRow> read_study_row(const std::string& path, const StudyPlan& plan,
                                       const PlannedRun& run, const std::string& digest) {
  const auto json = parse_foreign_json(read_output(path));
  if (member_of(json, "digest") != digest) return {};
  std::optional<StudyRow> row = study_row_from_json(member_of(json, "row"));
  if (!row || row->integrator != run.integrator || row->step != run.step ||
      row->solver != run.solver || row->settings != to_string(run.settings) ||
      row->directory != run.directory) {
    return {};
  }
  // The same run may be named otherwise in another study.
  row->variant = plan.variants[run.variant].name;
  row->role = run.role;
  row->compares_solver = run.compares_solver;
  return row;
}

void write_study_track(const std::string& path, const MotionTrack& track,
                       const std::string& digest) {
  ByteWriter bytes;
  bytes.put_text(digest);
  bytes.put(track.end);
  bytes.put<std::uint64_t>(track.count);
  put(bytes, track.rest);
  bytes.put<std::uint64_t>(track.positions.size());
  for (const Vector& position : track.positions) put(bytes, position);
  bytes.put<std::uint64_t>(track.probes.size());
  for (const ProbeRecord& probe : track.probes) {
    bytes.put_text(probe.name);
    bytes.put<std::uint64_t>(probe.width);
    bytes.put_all(probe.times.data(), probe.times.size());
    bytes.put_all(probe.values.data(), probe.values.size());
  }
  ByteWriter seal;
  seal.put(Seal{bytes.bytes().size(), check_sum(bytes.bytes())});
  ReplacementFile file(path);
  file.write(kHead);
  file.write(seal.bytes());
  file.write(bytes.bytes());
  file.finish();
}

std::shared_ptr<const MotionTrack> read_study_track(const std::string& path,
                                                    const std::string& digest) {
  const std::string rest = read_sealed(path);
  ByteReader bytes(rest);
  if (bytes.get_text() != digest) return nullptr;
  auto track = std::make_shared<MotionTrack>();
  track->end = bytes.get<double>();
  track->count = bytes.get<std::uint64_t>();
  track->rest = vector_of(bytes.get_all<double>());
  const auto positions = bytes.get<std::uint64_t>();
  for (std::uint64_t k = 0; k < positions && bytes.good(); ++k) {
    track->positions.push_back(vector_of(bytes.get_all<double>()));
  }
  const auto probes = bytes.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < probes && bytes.good(); ++i) {
    ProbeRecord probe;
    probe.name = bytes.get_text();
    probe.width = bytes.get<std::uint64_t>();
    probe.times = bytes.get_all<double>();
    probe.values = bytes.get_all<double>();
    track->probes.push_back(std::move(probe));
  }
  return bytes.good() && is_consistent(*track) ? track : nullptr;
}

}  // namespace tetraction
