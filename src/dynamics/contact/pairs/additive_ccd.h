// Continuous collision detection of contact pairs.
#pragma once

#include "dynamics/contact/pairs/pair_distance.h"

namespace tetraction {

/// A time t in [0, 1] such that the two sides of a pair do not touch on [0, t] while their points go from
/// p to p + t m in straight lines, m for the moves. With d the distance at the start,
///
///     distance ≥ 0.01 min(d, cap)  on [0, t],
///
/// and if t < 1, the distance at t is below 0.1 min(d, cap). A pair that comes no nearer than that
/// has t = 1; `cap` keeps pairs that start far from each other from being stopped far from each other. Zero
/// if the sides touch at the start.
///
/// Conservative advances (M. Li, D. M. Kaufman, C. Jiang, Codimensional incremental potential contact, ACM
/// Trans. Graph. 40, 2021): from distance d it is safe to go on until the sides could have come closer by
/// 0.9 d, for which each side's largest move from the mean move is the bound. The gap along the line that joins
/// the closest points is a concave function of time and a second bound, so that a pair that slides, or that
/// separates, takes one advance. Only distances and signs of linear functions decide.
double first_touch(PairKind kind, const PairPoints& points, const PairPoints& moves, double cap);

}  // namespace tetraction
