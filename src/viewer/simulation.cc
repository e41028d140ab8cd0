#include "simulation.h"

#include <algorithm>
#include <utility>

#include "solver_thread.h"

namespace tetraction::viewer {

struct Simulation::Impl : SolverThread {
  using SolverThread::SolverThread;
};

Simulation::Simulation(Scene scene, TetMesh mesh)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(mesh))) {
  impl_->thread = std::thread([impl = impl_.get()] { impl->work(); });
}

Simulation::~Simulation() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stop = true;
  }
  impl_->wake.notify_one();
  impl_->thread.join();
}

const TetMesh& Simulation::mesh() const {
  return impl_->mesh;
}
const Scene& Simulation::scene() const {
  return impl_->scene;
}

void Simulation::run() {
  impl_->send(Run{});
}
void Simulation::pause() {
  impl_->send(Pause{});
}
void Simulation::step() {
  impl_->send(Step{});
}
void Simulation::restart() {
  impl_->send(Restart{});
}
void Simulation::reset() {
  impl_->send(Reset{});
}
void Simulation::go_back() {
  impl_->send(GoBack{});
}

void Simulation::set_steps_per_snapshot(int steps) {
  const std::lock_guard lock(impl_->mutex);
  impl_->steps_per_snapshot = std::max(steps, 1);
}

void Simulation::set_speed_limit(double real_time_factor) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->speed_limit = real_time_factor > 0.0 ? real_time_factor : 0.0;
  }
  impl_->wake.notify_one();
}

void Simulation::set_color_field(ColorField field) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->field = field;
  }
  impl_->send(NewSnapshot{});
}

void Simulation::edit(Edit edit, std::string what, bool goes_on) {
  impl_->send(MakeEdit{std::move(edit), std::move(what), goes_on});
}
void Simulation::grab(std::vector<Index> vertices) {
  impl_->send(Grab{std::move(vertices)});
}
void Simulation::lead_to(const Vector3& place) {
  impl_->send(LeadTo{place});
}
void Simulation::release() {
  impl_->send(Release{});
}
void Simulation::undo() {
  impl_->send(Undo{});
}
void Simulation::redo() {
  impl_->send(Redo{});
}

void Simulation::observe(std::unique_ptr<Observer> observer) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->observed = observer != nullptr;
  }
  impl_->send(Observe{std::move(observer)});
}
bool Simulation::observed() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->observed;
}

std::string Simulation::undo_text() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->undo_text;
}
std::string Simulation::redo_text() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->redo_text;
}

std::shared_ptr<const Snapshot> Simulation::snapshot() const {
  const std::lock_guard lock(impl_->mutex);
  impl_->snapshot_taken = true;
  return impl_->snapshot;
}
Settings Simulation::settings() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->settings;
}

std::vector<HistoryRow> Simulation::history(std::size_t from) const {
  const std::lock_guard lock(impl_->mutex);
  const std::vector<HistoryRow>& rows = impl_->history.rows();
  return {rows.begin() + static_cast<std::ptrdiff_t>(std::min(from, rows.size())), rows.end()};
}
std::size_t Simulation::history_generation() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->history.generation();
}
std::vector<EditMark> Simulation::marks() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->marks;
}
std::vector<Notice> Simulation::take_notices() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->notices, {});
}

bool Simulation::idle() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->idle();
}
bool Simulation::wait_until_idle(double seconds) const {
  std::unique_lock lock(impl_->mutex);
  return impl_->became_idle.wait_for(lock, std::chrono::duration<double>(seconds),
                                     [this] { return impl_->idle(); });
}

Scene Simulation::recorded_scene() const {
  return impl_->recording.scene();
}

}  // namespace tetraction::viewer
