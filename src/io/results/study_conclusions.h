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
/// out. With variants of the scene, only runs of the first one have errors and orders. With several
/// meshes this holds for each mesh, and each has its own conclusions.
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

/// The reference that the runs of a variant are compared with. nullptr if the study has only one.
const MeshReference* reference_of_variant(const StudyResult& result, const std::string& variant);

/// The part of a study with several meshes that belongs to one of them, as a study of its own.
StudyResult part_of_mesh(const StudyResult& result, const MeshReference& reference);

/// What the steps of the explicit integrators are compared with: whether this step is longer than
/// the stability limit of the run's row.
bool is_above_stability_limit(const StudyRow& row);

/// The largest relative energy error that rounding explains: each step adds at most about one
/// rounding of the energies.
double round_off_level(const StudyRow& row);

}  // namespace tetraction
