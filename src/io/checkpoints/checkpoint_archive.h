// The numbers of a checkpoint as bytes. One list of members serves writing and reading.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Thrown by ArchiveReader for bytes that cannot be what a ArchiveWriter wrote.
struct BadBytes {
  const char* what;
};

/// Writes: archive(a, b, …) appends the values.
class ArchiveWriter {
 public:
  static constexpr bool kReads = false;

  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }
  void reserve(std::size_t size) { bytes_.reserve(size); }

  void block(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  void number(const double& value) { block(&value, sizeof value); }
  template <std::integral Integer>
  void whole(const Integer& value) {
    const auto stored = static_cast<std::uint64_t>(value);
    block(&stored, sizeof stored);
  }
  std::size_t count(std::size_t present, std::size_t) {
    whole(present);
    return present;
  }

 private:
  std::string bytes_;
};

/// Reads: archive(a, b, …) replaces the values. No count is believed before there are as many bytes.
class ArchiveReader {
 public:
  static constexpr bool kReads = true;

  explicit ArchiveReader(std::string_view bytes) : rest_(bytes) {}
  bool at_end() const { return rest_.empty(); }

  void block(void* data, std::size_t size) {
    if (size > rest_.size()) throw BadBytes{"it ends in the middle of a value"};
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  void number(double& value) { block(&value, sizeof value); }
  template <std::integral Integer>
  void whole(Integer& value) {
    std::uint64_t stored = 0;
    block(&stored, sizeof stored);
    value = static_cast<Integer>(stored);
    if (static_cast<std::uint64_t>(value) != stored) throw BadBytes{"a number is out of range"};
  }
  /// The number of entries of a list, each of which takes `least_size` bytes or more.
  std::size_t count(std::size_t, std::size_t least_size) {
    std::uint64_t stored = 0;
    whole(stored);
    if (stored > rest_.size() / least_size) throw BadBytes{"a list is longer than the file"};
    return static_cast<std::size_t>(stored);
  }

 private:
  std::string_view rest_;
};

template <class T, class U>
concept Is = std::same_as<std::remove_const_t<T>, U>;

template <class Archive, class... T>
void transfer_all(Archive& archive, T&... values);

template <class Archive>
void transfer(Archive& archive,
              auto& value) requires std::floating_point<std::remove_cvref_t<decltype(value)>> {
  archive.number(value);
}
template <class Archive>
void transfer(Archive& archive,
              auto& value) requires std::integral<std::remove_cvref_t<decltype(value)>> {
  archive.whole(value);
}
template <class Archive, Is<std::string> T>
void transfer(Archive& archive, T& text) {
  const std::size_t size = archive.count(text.size(), 1);
  if constexpr (Archive::kReads) text.resize(size);
  archive.block(text.data(), size);
}
template <class Archive, Is<Vector> T>
void transfer(Archive& archive, T& vector) {
  const std::size_t size = archive.count(static_cast<std::size_t>(vector.size()), sizeof(double));
  if constexpr (Archive::kReads) vector.resize(static_cast<Index>(size));
  archive.block(vector.data(), size * sizeof(double));
}
template <class Archive, Is<Vector3> T>
void transfer(Archive& archive, T& vector) {
  archive.block(vector.data(), 3 * sizeof(double));
}
template <class Archive, Is<Matrix3> T>
void transfer(Archive& archive, T& matrix) {
  archive.block(matrix.data(), 9 * sizeof(double));
}
/// A matrix with this many rows.
template <class Archive, Is<Matrix> T>
void transfer_columns(Archive& archive, T& matrix, Index rows) {
  const std::size_t columns = archive.count(static_cast<std::size_t>(matrix.cols()),
                                            static_cast<std::size_t>(rows) * sizeof(double));
  if constexpr (Archive::kReads) matrix.resize(rows, static_cast<Index>(columns));
  archive.block(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
}
template <class Archive, class T, std::size_t N>
void transfer(Archive& archive, std::array<T, N>& values) {
  for (T& value : values) transfer(archive, value);
}
template <class Archive, class T, std::size_t N>
void transfer(Archive& archive, const std::array<T, N>& values) {
  for (const T& value : values) transfer(archive, value);
}
/// An enumerator from the first one up to `last`.
template <class Archive, class Enum>
void transfer_enum(Archive& archive, Enum& value, std::remove_const_t<Enum> last) {
  auto stored = static_cast<std::uint64_t>(value);
  archive.whole(stored);
  if (stored > static_cast<std::uint64_t>(last)) throw BadBytes{"a word is not known"};
  if constexpr (Archive::kReads) value = static_cast<Enum>(stored);
}
/// A list whose entries take 8 bytes or more.
template <class Archive, class List>
void transfer_list(Archive& archive, List& list) {
  const std::size_t size = archive.count(list.size(), sizeof(std::uint64_t));
  if constexpr (Archive::kReads) list.resize(size);
  for (auto& entry : list) transfer(archive, entry);
}
template <class Archive, class... T>
void transfer_all(Archive& archive, T&... values) {
  (transfer(archive, values), ...);
}

}  // namespace tetraction
