// What follows from the numbers of a step-size study, in words.
#pragma once

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
/// out. With variants of the scene, only runs of the first one have errors and orders.
std::vector<StudyConclusion> study_conclusions(const StudyResult& result);

/// A number with up to three digits in the shortest form: 7.2e-5, 0.018, 12.
std::string short_number(double value);

/// The name of a run's integrator with what tells it from others: "midpoint (ceres)".
std::string run_label(const StudyRow& row);

/// The reference of the study: "midpoint with h = 1e-4 s", or "Richardson extrapolation of midpoint
/// with h = 1e-4 s and 5e-5 s".
std::string reference_name(const StudyResult& result);

/// What the steps of the explicit integrators are compared with: whether this step is longer than
/// the stability limit of the run's row.
bool is_above_stability_limit(const StudyRow& row);

/// The largest relative energy error that rounding explains: each step adds at most about one
/// rounding of the energies.
double round_off_level(const StudyRow& row);

}  // namespace tetraction
