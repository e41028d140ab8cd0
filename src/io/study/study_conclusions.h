// What follows from the numbers of a step-size study, in words.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// Sentences on one topic.
struct StudyConclusion {
  std::string topic;
  std::vector<std::string> sentences;
};

/// The conclusions of a study, in plain text. A topic about which the numbers say nothing is left
/// out. With several references each has its own conclusions, on the first variant that is compared with
/// it.
std::vector<StudyConclusion> study_conclusions(const StudyResult& result);

/// "a", "a and b", "a, b and c".
std::string enumeration(const std::vector<std::string>& words);

/// A number with up to three digits in the shortest form: 7.2e-5, 0.018, 12.
std::string short_number(double value);

/// The name of a run's integrator with what tells it from others: "midpoint (ceres)".
std::string run_label(const StudyRow& row);

/// The reference of the study: "midpoint with h = 1e-4 s", or "Richardson extrapolation of midpoint
/// with h = 1e-4 s and 5e-5 s".
std::string reference_name(const StudyResult& result);

/// For each variant its place in StudyResult::references. Empty if the study has only one reference.
std::map<std::string, std::size_t> references_of_variants(const StudyResult& result);

/// For each of StudyResult::references the part of the study that belongs to it, as a study of its own.
std::vector<StudyResult> parts_of_study(const StudyResult& result);

/// Whether the error that the orders are computed from is a difference from an extrapolation.
bool is_extrapolated(const StudyResult& result);

/// What the steps of the explicit integrators are compared with: whether this step is longer than
/// the stability limit of the run's row.
bool is_above_stability_limit(const StudyRow& row);

/// The largest relative energy error that rounding explains: each step adds at most about one
/// rounding of the energies.
double round_off_level(const StudyRow& row);

}  // namespace tetraction
