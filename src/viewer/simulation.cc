#include "simulation.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "solver_thread.h"

namespace tetraction::viewer {

struct Simulation::Impl : SolverThread {
  using SolverThread::SolverThread;
};

Simulation::Simulation(Scene scene, TetMesh mesh)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(mesh))) {
  impl_->start();
}

Simulation::~Simulation() = default;

bool Simulation::end(double seconds) {
  return impl_->end(seconds);
}

const TetMesh& Simulation::mesh() const {
  return *impl_->lock()->mesh;
}
const Scene& Simulation::scene() const {
  return *impl_->lock()->scene;
}

void Simulation::run() {
  impl_->send(Action{&SolverThread::run});
}
void Simulation::pause() {
  impl_->send(Action{&SolverThread::pause});
}
void Simulation::make_due_events() {
  impl_->send(Action{[](SolverThread& solver) { solver.engine().make_due_events(); }});
}
void Simulation::step() {
  impl_->send(Action{&SolverThread::step_once});
}
void Simulation::restart() {
  impl_->send(Action{&SolverThread::restart});
}
void Simulation::reset() {
  impl_->send(Action{&SolverThread::reset});
}
void Simulation::go_back() {
  impl_->send(Action{&SolverThread::go_back});
}

void Simulation::go_before_last_edit() {
  impl_->send(Action{&SolverThread::go_before_last_edit, true});
}
void Simulation::show_at(double time) {
  impl_->send(ShowKept{time});
}
void Simulation::continue_here() {
  impl_->send(Action{[](SolverThread& solver) { solver.continue_shown(); }, true});
}
std::vector<double> Simulation::kept_times() const {
  return impl_->lock()->kept.times();
}
void Simulation::set_pauses(bool at_end, bool at_energy_error) {
  const auto shared = impl_->lock();
  shared->pauses_at_end = at_end;
  shared->pauses_at_energy_error = at_energy_error;
}

void Simulation::set_steps_per_snapshot(int steps) {
  impl_->lock()->steps_per_snapshot = std::max(steps, 1);
}

void Simulation::set_picture_interval(double interval) {
  impl_->lock()->picture_interval = interval > 0.0 ? interval : 0.0;
  impl_->send(Publish{});
}

void Simulation::set_speed_limit(double real_time_factor) {
  impl_->lock()->speed_limit = real_time_factor > 0.0 ? real_time_factor : 0.0;
  impl_->wake();
}

void Simulation::set_color_field(ColorField field) {
  impl_->lock()->field = field;
  impl_->send(Publish{});
}

void Simulation::edit(Edit edit, std::string what, bool continues_previous) {
  impl_->send(MakeEdit{std::move(edit), std::move(what), continues_previous});
}
void Simulation::set_up(Scene scene, std::string what) {
  ++impl_->lock()->set_ups_to_come;
  impl_->send(Action{[scene = std::move(scene), what = std::move(what)](SolverThread& solver) {
                       solver.set_up(scene, what);
                     },
                     true});
}
void Simulation::add_selection(NamedSelection named, std::string what) {
  impl_->send(Action{[named = std::move(named), what = std::move(what)](SolverThread& solver) {
                       solver.add_selection(named, what);
                     },
                     true});
}
std::optional<std::string> Simulation::take_refusal() {
  return std::exchange(impl_->lock()->refusal, {});
}
void Simulation::grab(std::vector<Index> vertices) {
  impl_->send(Action{
      [vertices = std::move(vertices)](SolverThread& solver) { solver.grab(vertices); }, true});
}
void Simulation::pull(std::vector<Index> vertices, double radius) {
  impl_->send(Action{[vertices = std::move(vertices), radius](SolverThread& solver) {
                       solver.pull(vertices, radius);
                     },
                     true});
}
void Simulation::grab_obstacle(std::size_t number, const Vector3& point) {
  impl_->send(
      Action{[number, point](SolverThread& solver) { solver.grab_obstacle(number, point); }, true});
}
void Simulation::set_pull_radius(double radius) {
  impl_->send(
      Action{[radius](SolverThread& solver) { solver.engine().set_pull_radius(radius); }, true});
}
void Simulation::drag_to(const Vector3& position) {
  impl_->send(DragTo{position});
}
void Simulation::release() {
  impl_->send(Action{[](SolverThread& solver) { solver.engine().release(); }});
}
void Simulation::undo() {
  impl_->send(Action{&SolverThread::undo, true});
}
void Simulation::redo() {
  impl_->send(Action{&SolverThread::redo, true});
}

void Simulation::observe(std::unique_ptr<Observer> observer) {
  impl_->lock()->observed = observer != nullptr;
  impl_->send(Observe{std::move(observer)});
}
bool Simulation::observed() const {
  return impl_->lock()->observed;
}

std::string Simulation::undo_text() const {
  return impl_->lock()->undo_text;
}
std::string Simulation::redo_text() const {
  return impl_->lock()->redo_text;
}

std::size_t Simulation::edit_count() const {
  return impl_->lock()->edit_count;
}
bool Simulation::edited_since(std::size_t count) const {
  const auto shared = impl_->lock();
  return shared->edits_waiting || (shared->has_edits && shared->edit_count > count);
}

std::shared_ptr<const Snapshot> Simulation::snapshot() const {
  const auto shared = impl_->lock();
  shared->snapshot_taken = true;
  return shared->snapshot;
}
std::shared_ptr<const Snapshot> Simulation::peek() const {
  return impl_->lock()->snapshot;
}
Settings Simulation::settings() const {
  return impl_->lock()->settings;
}
Present Simulation::present() const {
  const auto shared = impl_->lock();
  return {shared->settings_number, shared->settings, shared->scene};
}
EditedScene Simulation::edited_scene() const {
  return impl_->edited();
}
std::size_t Simulation::settings_number() const {
  return impl_->lock()->settings_number;
}
std::uint64_t Simulation::body() const {
  return impl_->lock()->snapshot->body;
}
bool Simulation::is_setting_up() const {
  return impl_->lock()->set_ups_to_come > 0;
}

std::vector<HistoryRow> Simulation::history(std::size_t from) const {
  const auto shared = impl_->lock();
  const std::vector<HistoryRow>& rows = shared->history.rows();
  return {rows.begin() + static_cast<std::ptrdiff_t>(std::min(from, rows.size())), rows.end()};
}
std::size_t Simulation::history_generation() const {
  return impl_->lock()->history.generation();
}
std::vector<EditMark> Simulation::marks() const {
  return impl_->lock()->marks;
}
std::vector<Notice> Simulation::take_notices() {
  return std::exchange(impl_->lock()->notices, {});
}

std::vector<std::string> Simulation::take_ended_causes() {
  return std::exchange(impl_->lock()->ended_causes, {});
}
bool Simulation::idle() const {
  return impl_->lock()->idle();
}
bool Simulation::wait_until_idle(double seconds) const {
  return impl_->wait_until_idle(seconds);
}

Scene Simulation::recorded_scene() const {
  return impl_->recording().scene();
}

std::string sentence(std::string warning) {
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  const auto end = std::find_if_not(warning.begin(), warning.end(), is_letter);
  if (end != warning.begin() && end != warning.end() && *end != '.' && *end != '_') {
    warning[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(warning[0])));
  }
  return warning;
}

}  // namespace tetraction::viewer
