// The members of a row of a study in one table, over which files, tables, the page and comparisons loop.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

class StudyGrid;

/// Where a member appears.
enum StudyPlace : unsigned {
  kInCsv = 1U,     ///< study.csv
  kInJson = 2U,    ///< study.json and study_row.json
  kDerived = 4U,   ///< not read again, because it follows from other members or runs
  kInTable = 8U,   ///< the long table of the terminal
  kOnPage = 16U,   ///< study.html
  kInDiff = 32U,   ///< differences between two studies
  kIsError = 64U,  ///< a difference from the reference: the reference itself has none
};

/// A member of StudyRow, or a column of study.csv that belongs to the whole study.
struct StudyField {
  /// The words "alone" and "shared".
  struct Timing {
    bool StudyRow::*is_shared;
    bool operator==(const Timing&) const = default;
  };
  using Member = std::variant<std::monostate, double StudyRow::*, Index StudyRow::*,
                              int StudyRow::*, bool StudyRow::*, std::string StudyRow::*,
                              Integrator StudyRow::*, RunStatus StudyRow::*, StudyRole StudyRow::*,
                              Timing, double (*)(const StudyRow&)>;

  const char* name;  ///< the column and the member of the files
  Member member;     ///< std::monostate: of the whole study
  unsigned places;
  int rank = 0;               ///< order of the columns of tables
  const char* heading = "";   ///< in tables, with the unit
  const char* format = "{}";  ///< of numbers in tables

  bool is_in(unsigned place) const { return (places & place) != 0U; }
  bool is_number() const;
  bool is_step() const { return member == Member(&StudyRow::step); }
};

/// All members, in the order of the columns of study.csv.
std::span<const StudyField> study_fields();

/// The members that tables of this kind show, in the order of their columns.
std::vector<const StudyField*> shown_fields(StudyPlace place);

/// The heading of its column in the tables of a study.
std::string heading_of(const StudyField& field, const StudyResult& result);

/// The value as a file has it. Numbers that are not known are null.
nlohmann::ordered_json field_value(const StudyField& field, const StudyRow& row);

/// Takes the value from a file. Throws nlohmann::json::exception or InputError for another kind of
/// value.
void read_field(const StudyField& field, const nlohmann::json& value, StudyRow& row);

/// Adds a cell with the value to a table.
void add_field(StudyGrid& grid, const StudyField& field, const StudyRow& row);

/// The inverse of to_string(). Throws InputError for another word.
RunStatus status_from_string(const std::string& word);

/// The words that a file may have for the member. Empty if it is no choice of words.
std::vector<std::string> field_words(const StudyField& field);

}  // namespace tetraction
