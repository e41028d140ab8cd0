#include "study_members.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/quoting.h"
#include "io/results/result_folders.h"
#include "io/text/output_file.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

// A study of ten thousand runs has some 10 MB.
constexpr std::uintmax_t kMostStudyBytes = std::uintmax_t{256} << 20U;

}  // namespace

StudyText read_study_text(const std::string& path) {
  std::error_code problem;
  const bool is_directory = fs::is_directory(path, problem);
  if (!is_directory && !fs::exists(path, problem)) {
    throw FileError(fmt::format("{}: there is no such directory.", path));
  }
  StudyText study;
  study.path = is_directory ? (fs::path(path) / "study.json").string() : path;
  if (is_directory && !fs::exists(study.path, problem)) {
    throw FileError(fmt::format(
        "{}: this directory does not hold the results of a study: there is no study.json{}.", path,
        fs::exists(fs::path(path) / "history.csv", problem) ? ", but the results of a run" : ""));
  }
  if (fs::is_regular_file(study.path, problem) &&
      fs::file_size(study.path, problem) > kMostStudyBytes) {
    throw FileError(
        fmt::format("{}: the file is too large for the study.json of a study: it has "
                    "more than {} MB.",
                    study.path, kMostStudyBytes >> 20U));
  }
  study.text = read_output(study.path);
  study.json = parse_foreign_json(study.text);
  if (!study.json.is_object() || !study.json.contains("runs") || !study.json["runs"].is_array()) {
    throw FileError(fmt::format("{}: this is not the study.json of a study.", study.path));
  }
  if (study.json.contains("message") && !study.json.contains("reference")) {
    refuse_incomplete_study(path, "it runs, or was cut off");
  }
  return study;
}

void refuse_incomplete_study(const std::string& path, const std::string& why) {
  throw FileError(fmt::format(
      "{}: the study has not ended: {}. Make it again with the same command, which keeps the runs "
      "that are complete.",
      path, why));
}

StudyMembers::StudyMembers(std::string file, std::string place, std::string hint,
                           const ForeignJson* json)
    : file_(std::move(file)), place_(std::move(place)), hint_(std::move(hint)), json_(json) {
  if (json_ != nullptr && !json_->is_object()) fail("it is not a table");
}

void StudyMembers::fail(const std::string& what) const {
  throw FileError(fmt::format("{}: this is not the study.json of a study: {}{}.{}", file_, place_,
                              what, hint_));
}

const ForeignJson& StudyMembers::member(const char* key) const {
  if (!has(key)) fail(fmt::format("\"{}\" is missing", key));
  return (*json_)[key];
}

const ForeignJson& StudyMembers::member(const char* key, IsOfKind is, const char* wrong) const {
  const ForeignJson& value = member(key);
  if (!(value.*is)()) fail(fmt::format("\"{}\" is {}", key, wrong));
  return value;
}

StudyMembers StudyMembers::table(const char* key) const {
  return {file_, fmt::format("{}in \"{}\", ", place_, key), hint_, &member(key)};
}

std::vector<StudyMembers> StudyMembers::tables(const char* key) const {
  std::vector<StudyMembers> found;
  for (const ForeignJson& value : member(key, &ForeignJson::is_array, "not a list")) {
    found.emplace_back(file_,
                       fmt::format("{}in entry {} of \"{}\", ", place_, found.size() + 1, key),
                       hint_, &value);
  }
  return found;
}

std::string StudyMembers::text(const char* key) const {
  return member(key, &ForeignJson::is_string, "not a text").get<std::string>();
}

std::vector<std::string> StudyMembers::texts(const char* key) const {
  std::vector<std::string> found;
  for (const ForeignJson& value : member(key, &ForeignJson::is_array, "not a list")) {
    if (!value.is_string()) fail(fmt::format("an entry of \"{}\" is not a text", key));
    found.push_back(value.get<std::string>());
  }
  return found;
}

bool StudyMembers::flag(const char* key) const {
  return member(key, &ForeignJson::is_boolean, "neither true nor false").get<bool>();
}

double StudyMembers::number(const char* key) const {
  if (member(key).is_null()) return std::numeric_limits<double>::quiet_NaN();
  return member(key, &ForeignJson::is_number, "not a number").get<double>();
}

double StudyMembers::positive(const char* key) const {
  const double value = number(key);
  if (!(value > 0.0)) fail(fmt::format("\"{}\" is not a positive number", key));
  return value;
}

std::size_t StudyMembers::index_of(const ForeignJson& value, std::size_t count) const {
  const Index index = index_or(value, -1);
  if (index < 0 || static_cast<std::size_t>(index) >= count) {
    fail("a number of a list is not in it");
  }
  return static_cast<std::size_t>(index);
}

std::size_t StudyMembers::index(const char* key, std::size_t count) const {
  return index_of(member(key), count);
}

std::vector<std::size_t> StudyMembers::indices(const char* key, std::size_t count) const {
  std::vector<std::size_t> found;
  for (const ForeignJson& value : member(key, &ForeignJson::is_array, "not a list")) {
    found.push_back(index_of(value, count));
  }
  return found;
}

void StudyMembers::word(const char* key, const std::vector<std::string>& words) const {
  const std::string value = text(key);
  if (std::find(words.begin(), words.end(), value) == words.end()) {
    fail(fmt::format("\"{}\" is {}, which is none of {}", key, in_quotes(value),
                     fmt::join(words, ", ")));
  }
}

std::string StudyMembers::folder(const char* key) const {
  const std::string name = text(key);
  if (!is_folder_name(name)) {
    fail(fmt::format("\"{}\" is {}, which is not the name of a folder in the directory", key,
                     in_quotes(name)));
  }
  return name;
}

}  // namespace tetraction
