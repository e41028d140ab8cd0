// Plain data as bytes, for handing a mesh from one process to another of the same program.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetraction {

/// Appends values to a string of bytes.
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put_text(const std::string& text) {
    put<std::uint64_t>(text.size());
    bytes_ += text;
  }
  template <class T>
  void put_all(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    put<std::uint64_t>(count);
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }
  std::string take_bytes() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Takes the values out again. `good()` is false from the first missing value on.
class ByteReader {
 public:
  explicit ByteReader(const std::string& bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    T value{};
    if (!take(sizeof(T))) return value;
    std::memcpy(&value, bytes_.data() + position_ - sizeof(T), sizeof(T));
    return value;
  }
  std::string get_text() {
    const auto size = get<std::uint64_t>();
    if (!take(size)) return {};
    return bytes_.substr(position_ - size, size);
  }
  template <class T>
  std::vector<T> get_all() {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / sizeof(T) || !take(count * sizeof(T))) {
      good_ = false;
      return {};
    }
    std::vector<T> values(count);
    if (count > 0) {
      std::memcpy(values.data(), bytes_.data() + position_ - count * sizeof(T), count * sizeof(T));
    }
    return values;
  }
  bool good() const { return good_; }

 private:
  bool take(std::uint64_t size) {
    good_ = good_ && size <= bytes_.size() - position_;
    if (good_) position_ += size;
    return good_;
  }

  const std::string& bytes_;
  std::size_t position_ = 0;
  bool good_ = true;
};

}  // namespace tetraction
