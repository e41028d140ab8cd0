// The frames of a mode that swings.
#include "replay.h"

namespace tetraction::viewer {
namespace {

constexpr int kFrames = 48;  // of a period

}  // namespace

Replay::Replay(const StoredModes& modes, std::size_t mode)
    : directory_(modes.directory()),
      mesh_(modes.mesh()),
      rest_(mesh_.rest_positions()),
      motion_(modes.motion(mode)),
      kind_(RunKind::kMode) {
  for (int k = 0; k < kFrames; ++k) times_.push_back(static_cast<double>(k) / kFrames);
}

std::shared_ptr<const Snapshot> Replay::frame_of_mode(std::size_t i, ColorField field) const {
  auto snapshot = std::make_shared<Snapshot>(snapshot_at(i));
  const Vector displacement = motion_->displacement(times_[i]);
  snapshot->position = motion_->middle + displacement;
  snapshot->velocity = snapshot->momentum = snapshot->external_force = snapshot->reaction_force =
      Vector::Zero(rest_.size());
  snapshot->fixed.assign(static_cast<std::size_t>(mesh_.vertex_count()), 0);
  snapshot->field = field;
  // A shape has no other fields. The colours are those of the motion about the middle position.
  if (field.quantity == find_quantity("displacement")) {
    const Matrix values = displacement.reshaped(3, mesh_.vertex_count());
    snapshot->field_values = color_values(values, field.component);
  }
  return snapshot;
}

}  // namespace tetraction::viewer
