#include "study_track_file.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>
#include <vector>

#include "io/text/byte_stream.h"
#include "io/text/check_sum.h"
#include "io/text/output_file.h"

namespace tetraction {
namespace {

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
