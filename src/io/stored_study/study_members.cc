#include "study_members.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "core/quoting.h"
#include "io/results/result_folders.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"

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
      "{}: the study has not ended: {}. The same command with --resume completes it.", path, why));
}

void StudyMembers::fail(const std::string& what) const {
  throw FileError(fmt::format("{}: this is not the study.json of a study: {}{}.{}", file_, place_,
                              what, hint_));
}

void StudyMembers::require_object(const ForeignJson& json) const {
  if (!json.is_object()) fail("it is not a table");
}

const ForeignJson& StudyMembers::member(const ForeignJson& json, const char* key) const {
  if (!json.contains(key)) fail(fmt::format("\"{}\" is missing", key));
  return json[key];
}

const ForeignJson& StudyMembers::list(const ForeignJson& json, const char* key) const {
  const ForeignJson& value = member(json, key);
  if (!value.is_array()) fail(fmt::format("\"{}\" is not a list", key));
  return value;
}

std::string StudyMembers::text(const ForeignJson& json, const char* key) const {
  const ForeignJson& value = member(json, key);
  if (!value.is_string()) fail(fmt::format("\"{}\" is not a text", key));
  return value.get<std::string>();
}

std::vector<std::string> StudyMembers::texts(const ForeignJson& json, const char* key) const {
  std::vector<std::string> found;
  for (const ForeignJson& value : list(json, key)) {
    if (!value.is_string()) fail(fmt::format("an entry of \"{}\" is not a text", key));
    found.push_back(value.get<std::string>());
  }
  return found;
}

bool StudyMembers::flag(const ForeignJson& json, const char* key) const {
  const ForeignJson& value = member(json, key);
  if (!value.is_boolean()) fail(fmt::format("\"{}\" is neither true nor false", key));
  return value.get<bool>();
}

double StudyMembers::number(const ForeignJson& json, const char* key) const {
  const ForeignJson& value = member(json, key);
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!value.is_number()) fail(fmt::format("\"{}\" is not a number", key));
  return value.get<double>();
}

double StudyMembers::positive(const ForeignJson& json, const char* key) const {
  const double value = number(json, key);
  if (!(value > 0.0)) fail(fmt::format("\"{}\" is not a positive number", key));
  return value;
}

std::size_t StudyMembers::index(const ForeignJson& json, std::size_t count) const {
  const Index value = index_or(json, -1);
  if (value < 0 || static_cast<std::size_t>(value) >= count)
    fail("a number of a list is not in it");
  return static_cast<std::size_t>(value);
}

void StudyMembers::word(const ForeignJson& json, const char* key,
                        const std::vector<std::string>& words) const {
  const std::string value = text(json, key);
  if (std::find(words.begin(), words.end(), value) == words.end()) {
    fail(fmt::format("\"{}\" is {}, which is none of {}", key, in_quotes(value),
                     fmt::join(words, ", ")));
  }
}

std::string StudyMembers::folder(const ForeignJson& json, const char* key) const {
  const std::string name = text(json, key);
  if (!is_folder_name(name)) {
    fail(fmt::format("\"{}\" is {}, which is not the name of a folder in the directory", key,
                     in_quotes(name)));
  }
  return name;
}

}  // namespace tetraction
