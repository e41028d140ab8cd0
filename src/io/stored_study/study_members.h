// The members of a study.json, which anybody may have written or changed.
#pragma once

#include <string>
#include <vector>

#include "io/text/foreign_json.h"
#include "tetraction/core/error.h"

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

/// A table in a study.json, whose members it takes if they are of the kind that is asked for. Otherwise all functions
/// throw FileError, which names file, place and member.
class StudyMembers {
 public:
  /// `place` is where the members stand, as "in entry 3 of \"runs\", ". It may be empty. `hint` says what to do, at the
  /// end of each message.
  StudyMembers(std::string file, std::string place, std::string hint = {},
               const ForeignJson* json = nullptr);

  [[noreturn]] void fail(const std::string& what) const;
  bool has(const char* key) const { return json_->contains(key); }
  const ForeignJson& member(const char* key) const;
  StudyMembers table(const char* key) const;
  /// A list of tables.
  std::vector<StudyMembers> tables(const char* key) const;
  std::string text(const char* key) const;
  std::vector<std::string> texts(const char* key) const;
  bool flag(const char* key) const;
  /// NaN for null.
  double number(const char* key) const;
  double positive(const char* key) const;
  /// A whole number less than `count`, or a list of them.
  std::size_t index(const char* key, std::size_t count) const;
  std::vector<std::size_t> indices(const char* key, std::size_t count) const;
  /// One of these words.
  void word(const char* key, const std::vector<std::string>& words) const;
  /// The plain name of a folder, which does not lead out of the directory.
  std::string folder(const char* key) const;

  /// What `take` makes of the member. Exceptions of another kind and of bad input become those of the member.
  template <class Take>
  auto as(const char* key, const Take& take) const {
    const ForeignJson& value = member(key);
    try {
      return take(value);
    } catch (const nlohmann::json::exception&) {
      fail(std::string("\"") + key + "\" has a value of another kind");
    } catch (const InputError&) {
      fail(std::string("\"") + key + "\" has an unknown value");
    }
  }
  /// The same of a text.
  template <class Take>
  auto named(const char* key, const Take& take) const {
    text(key);
    return as(key, [&](const ForeignJson& value) { return take(value.get<std::string>()); });
  }

 private:
  using IsOfKind = bool (ForeignJson::*)() const noexcept;
  const ForeignJson& member(const char* key, IsOfKind is, const char* wrong) const;
  std::size_t index_of(const ForeignJson& value, std::size_t count) const;

  std::string file_;
  std::string place_;
  std::string hint_;
  const ForeignJson* json_;
};

}  // namespace tetraction
