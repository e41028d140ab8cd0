#include "common_outcome.h"

#include <array>
#include <vector>

namespace tetraction {
namespace {

// The numbers of an outcome that parts add up.
constexpr std::size_t kOutcome = 13;

// All parts have failed as the first one that did.
void fail_together(const MeshPart& part, StepOutcome& outcome) {
  // A part that only waited for the others knows no element.
  const bool has_reason = outcome.status != StepStatus::kInverted || outcome.element >= 0;
  const int place = part.rank() + (outcome.ok() ? 2 * part.count() : has_reason ? 0 : part.count());
  const auto least = static_cast<int>(least_of_parts(&part, place));
  const int first = least % part.count();
  const bool is_first = place == least;
  std::array<double, 2> reason{-1.0, -1.0};
  if (is_first) {
    reason = {static_cast<double>(outcome.status), static_cast<double>(outcome.obstacle)};
  }
  part.largest(reason.data(), 2);
  outcome.status = static_cast<StepStatus>(static_cast<int>(reason[0]));
  outcome.obstacle = static_cast<StepObstacle>(static_cast<int>(reason[1]));
  if (!is_first) outcome.element = -1;
  part.broadcast(outcome.message, first);
}

}  // namespace

void make_common(const MeshPart* part, StepOutcome& outcome) {
  if (part == nullptr) return;
  std::vector<double> sums{outcome.ok() ? 0.0 : 1.0, outcome.elastic_energy, outcome.external_work,
                           outcome.dissipated_energy, outcome.constraint_work};
  sums.resize(kOutcome);
  for (Index k = 0; k < 3; ++k) {
    sums[static_cast<std::size_t>(5 + k)] = outcome.linear_impulse[k];
    sums[static_cast<std::size_t>(8 + k)] = outcome.angular_impulse[k];
  }
  sums[11] = outcome.impulse_size;
  sums[12] = outcome.angular_impulse_size;
  sums.insert(sums.end(), outcome.balance_sums.begin(), outcome.balance_sums.end());
  part->sum(sums.data(), static_cast<Index>(sums.size()));
  if (sums[0] > 0.0) {
    fail_together(*part, outcome);
    return;
  }
  outcome.elastic_energy = sums[1];
  outcome.external_work = sums[2];
  outcome.dissipated_energy = sums[3];
  outcome.constraint_work = sums[4];
  for (Index k = 0; k < 3; ++k) {
    outcome.linear_impulse[k] = sums[static_cast<std::size_t>(5 + k)];
    outcome.angular_impulse[k] = sums[static_cast<std::size_t>(8 + k)];
  }
  outcome.impulse_size = sums[11];
  outcome.angular_impulse_size = sums[12];
  outcome.balance_sums.assign(sums.begin() + kOutcome, sums.end());
}

}  // namespace tetraction
