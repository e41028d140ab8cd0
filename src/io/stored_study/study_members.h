// The members of a study.json, which anybody may have written or changed.
#pragma once

#include <string>
#include <vector>

#include "io/text/foreign_json.h"

namespace tetraction {

/// A study.json. `json` is an object with the list `runs`.
struct StudyText {
  std::string path;  ///< of the file
  std::string text;
  ForeignJson json;
};

/// Reads the study.json of a directory, or a file with its text. Throws FileError if there is none, if it is none, or
/// if the study has not written its results yet.
StudyText read_study_text(const std::string& path);

/// The FileError of a study that was interrupted, or that has not ended for another reason.
[[noreturn]] void refuse_incomplete_study(const std::string& path, const std::string& why);

/// Takes members of a known kind. All functions throw FileError, which names file, place and member, if there is none
/// of that kind.
class StudyMembers {
 public:
  /// `place` is where the members stand, as "in entry 3 of \"runs\", ". It may be empty.
  StudyMembers(std::string file, std::string place, std::string hint = {})
      : file_(std::move(file)), place_(std::move(place)), hint_(std::move(hint)) {}

  /// The members of a part of these.
  StudyMembers in(const std::string& place) const { return {file_, place_ + place, hint_}; }

  [[noreturn]] void fail(const std::string& what) const;
  void require_object(const ForeignJson& json) const;
  const ForeignJson& member(const ForeignJson& json, const char* key) const;
  const ForeignJson& list(const ForeignJson& json, const char* key) const;
  std::string text(const ForeignJson& json, const char* key) const;
  std::vector<std::string> texts(const ForeignJson& json, const char* key) const;
  bool flag(const ForeignJson& json, const char* key) const;
  /// NaN for null.
  double number(const ForeignJson& json, const char* key) const;
  double positive(const ForeignJson& json, const char* key) const;
  /// A number of the list, less than `count`.
  std::size_t index(const ForeignJson& json, std::size_t count) const;
  /// One of these words.
  void word(const ForeignJson& json, const char* key, const std::vector<std::string>& words) const;
  /// The plain name of a folder, which does not lead out of the directory.
  std::string folder(const ForeignJson& json, const char* key) const;

 private:
  std::string file_;
  std::string place_;
  std::string hint_;  // what to do, at the end of each message
};

}  // namespace tetraction
