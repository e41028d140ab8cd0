#include "kept_states.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetraction::viewer {
namespace {

constexpr std::size_t kMost = 5000;       // more could not be told apart on a time line
constexpr std::size_t kSmallData = 2500;  // of one state: its balance and the objects themselves

std::size_t bytes_of(const Vector& vector) {
  return static_cast<std::size_t>(vector.size()) * sizeof(double);
}

std::size_t bytes_of(const KeptSettings& kept) {
  std::size_t bytes = sizeof kept + kept.fixed.size();
  for (const PrescribedVertices& fix : kept.settings.constraints.fixes) {
    // Number and start of a vertex, and its number and target in the settings.
    bytes += fix.vertices.size() * 2 * (sizeof(Index) + sizeof(Vector3));
  }
  return bytes;
}

// The settings count if the state before has others.
std::size_t bytes_of(const KeptState& kept, const KeptSettings* before) {
  const State& state = kept.state;
  const std::size_t own =
      kSmallData + bytes_of(state.position) + bytes_of(state.momentum) + bytes_of(state.velocity);
  return own + (kept.settings.get() != before ? bytes_of(*kept.settings) : 0);
}

}  // namespace

void KeptStates::count() {
  bytes_ = 0;
  const KeptSettings* settings = nullptr;
  for (const auto& kept : states_) {
    bytes_ += bytes_of(*kept, std::exchange(settings, kept->settings.get()));
  }
}

void KeptStates::add(std::shared_ptr<const KeptState> state) {
  bytes_ += bytes_of(*state, states_.empty() ? nullptr : states_.back()->settings.get());
  states_.push_back(std::move(state));
  // Two states stay, however large they are: the first and the last one.
  while ((bytes_ > budget_ || states_.size() > kMost) && states_.size() > 2) {
    stride_ *= 2;
    std::erase_if(states_, [&](const auto& kept) {
      return !wants(kept->state.step) && kept != states_.front() && kept != states_.back();
    });
    count();
  }
}

void KeptStates::go_back_to(Index step) {
  std::erase_if(states_, [step](const auto& kept) { return kept->state.step > step; });
  count();
}

std::shared_ptr<const KeptState> KeptStates::nearest(double time) const {
  const auto nearest = std::min_element(states_.begin(), states_.end(), [time](auto& a, auto& b) {
    return std::abs(a->state.time - time) < std::abs(b->state.time - time);
  });
  return nearest == states_.end() ? nullptr : *nearest;
}

std::vector<double> KeptStates::times() const {
  std::vector<double> times;
  times.reserve(states_.size());
  for (const auto& kept : states_) times.push_back(kept->state.time);
  return times;
}

}  // namespace tetraction::viewer
