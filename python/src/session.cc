#include "session.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <utility>

#include "interpreter.h"
#include "python_objects.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/scene_objects.h"

namespace py = pybind11;

namespace tetraction::python {
namespace {

// Looks for signals some ten times a second.
class SignalCheck {
 public:
  // Throws the exception of a signal's handler. To be called without the interpreter's lock.
  void operator()() {
    constexpr std::chrono::milliseconds kPause{100};
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < kPause) return;
    last_ = now;
    const Acquired lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Whether an observer asks for the end of the run: with False of Python or of NumPy.
bool is_false(const py::handle& answer) {
  const std::string type = answer.get_type().attr("__name__").cast<std::string>();
  return (type == "bool" || type == "bool_") && !answer.cast<bool>();
}

// Enters rows of the history and calls the observers of Python.
class Caller : public Observer {
 public:
  Caller(PythonSession& session, const py::list& observers, const py::object& self)
      : session_(session), observers_(observers), self_(self) {}

  // Ends the run after an exception, which rethrow() throws when the results have been written.
  bool on_step(const Session& /*session*/) override {
    try {
      return call();
    } catch (...) {
      failure_ = std::current_exception();
      return false;
    }
  }
  // Returns whether the run goes on.
  bool call() {
    session_.add_row();
    check_();
    session_.refresh();
    if (observers_.empty()) return true;
    const Acquired lock;
    const Turns::Observing observing(session_.turns());
    for (const py::handle observer : observers_) {
      const py::object answer = observer(self_);
      if (is_false(answer)) return false;
    }
    return true;
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }
  // Notes on the exception of an observer or of a signal what went wrong after it. Returns whether there is
  // such an exception. To be called without the interpreter's lock.
  bool note(const char* text) const {
    if (!failure_) return false;
    const Acquired lock;
    try {
      std::rethrow_exception(failure_);
    } catch (const py::error_already_set& error) {
      if (py::hasattr(error.value(), "add_note")) error.value().attr("add_note")(text);
    } catch (...) {
    }
    return true;
  }

 private:
  PythonSession& session_;
  const py::list& observers_;
  const py::object& self_;
  SignalCheck check_;
  std::exception_ptr failure_;
};

}  // namespace

Turns::Turn::Turn(Turns& turns, Use use) : turns_(&turns) {
  const std::lock_guard lock(turns.mutex_);
  if (turns.in_use_) {
    const bool is_observer = turns.observing_ && turns.observer_ == std::this_thread::get_id();
    if (!is_observer || use == Use::kStep) {
      throw InputError(
          is_observer
              ? "An observer is called within a run, so it cannot make steps or go back. Return "
                "False to end the run, or call step() in a loop of your own instead of run()."
              : "The session is in use: another thread makes a step, or a function that is called "
                "within a step uses its own session. Use a session from one thread at a time.");
    }
    turns_ = nullptr;
    return;
  }
  turns.in_use_ = true;
}

Turns::Turn::~Turn() {
  if (turns_ == nullptr) return;
  const std::lock_guard lock(turns_->mutex_);
  turns_->in_use_ = false;
}

Turns::Observing::Observing(Turns& turns) : turns_(turns) {
  const std::lock_guard lock(turns.mutex_);
  turns.observing_ = true;
  turns.observer_ = std::this_thread::get_id();
}

Turns::Observing::~Observing() {
  const std::lock_guard lock(turns_.mutex_);
  turns_.observing_ = false;
}

bool Turns::may_read() {
  const std::lock_guard lock(mutex_);
  return !in_use_ || (observing_ && observer_ == std::this_thread::get_id());
}

TetMesh session_mesh(const Scene& scene, const std::optional<TetMesh>& given) {
  if (!given) return read_scene_mesh(scene);
  TetMesh mesh = *given;
  if (scene.mesh.quadratic) mesh = with_edge_vertices(std::move(mesh));
  add_initial_fields(scene.initial, mesh);
  return mesh;
}

PythonSession::PythonSession(const Scene& scene, TetMesh mesh, bool is_static,
                             double largest_increment, bool with_history, py::object arrays)
    : arrays_(std::move(arrays)) {
  const Released released;
  const auto depends_on_place = [](const MaterialSettings& material) {
    const auto* custom = material.custom ? std::get_if<CustomMaterial>(&*material.custom) : nullptr;
    return custom != nullptr && custom->has_places();
  };
  if (depends_on_place(scene.material) ||
      std::ranges::any_of(scene.material_region, [&](const MaterialRegionSettings& region) {
        return depends_on_place(region.material);
      })) {
    // Before a session computes with the law.
    check_placed_materials(*make_system(scene, mesh));
  }
  session_ = std::make_unique<Session>(scene, std::move(mesh),
                                       is_static ? Analysis::kEquilibrium : Analysis::kMotion,
                                       largest_increment);
  seen_ = &session_->state();  // its address never changes
  if (with_history) columns_ = std::make_unique<HistoryColumns>(*session_);
  add_row();
}

Index PythonSession::step(Index count) {
  if (count < 0) throw InputError("step: the number of steps must not be negative.");
  const Turns::Turn turn(turns_, Turns::Use::kStep);
  const Released released;
  const Interruptible until_end(interpreter_end_flag());
  SignalCheck check;
  Index made = 0;
  while (made < count && session_->step()) {
    ++made;
    add_row();
    check();
  }
  refresh();
  return made;
}

void PythonSession::run(const std::vector<Observer*>& own, const py::list& observers,
                        const py::object& self) {
  const Turns::Turn turn(turns_, Turns::Use::kStep);
  Caller caller(*this, observers, self);
  {
    const Released released;
    const Interruptible until_end(interpreter_end_flag());
    if (own.empty() && session_->load_path() == nullptr) {
      // The session can go on if an observer ends the run.
      while (session_->step() && caller.call()) {
      }
    } else {
      std::vector<Observer*> all = own;
      all.push_back(&caller);
      try {
        session_->run(all);
      } catch (const std::exception& error) {
        if (!caller.note(error.what())) throw;
      }
    }
    refresh();
  }
  caller.rethrow();
}

py::array PythonSession::view(const Vector& field, const py::object& self) {
  py::array array(py::dtype::of<double>(),
                  std::vector<py::ssize_t>{static_cast<py::ssize_t>(field.size() / 3), 3},
                  field.data(), self);
  array.attr("flags").attr("writeable") = false;
  has_views_ = true;
  return array;
}

const State& PythonSession::state() {
  // While another thread makes a step, the views show the state before it.
  if (turns_.may_read() || !has_views_) return session_->state();
  return *seen_;
}

py::array PythonSession::positions(const py::object& self) {
  return view(state().position, self);
}
py::array PythonSession::velocities(const py::object& self) {
  return view(state().velocity, self);
}
py::array PythonSession::momenta(const py::object& self) {
  return view(state().momentum, self);
}

std::size_t PythonSession::row_size() const {
  return columns_->names().size() + session_->probes().value_count();
}

py::object PythonSession::column(std::size_t place) const {
  const std::size_t width = row_size();
  const std::size_t count = rows_.size() / width;
  py::array_t<double> array(static_cast<py::ssize_t>(count));
  double* values = array.mutable_data();
  for (std::size_t r = 0; r < count; ++r) values[r] = rows_[r * width + place];
  return array;
}

py::dict PythonSession::history() {
  const Turns::Turn turn(turns_, Turns::Use::kEdit);
  py::dict result;
  if (!columns_) return result;
  const std::vector<std::string>& names = columns_->names();
  for (std::size_t c = 0; c < names.size(); ++c) result[py::str(names[c])] = column(c);
  return result;
}

py::dict PythonSession::probes() {
  const Turns::Turn turn(turns_, Turns::Use::kEdit);
  py::dict result;
  if (!columns_) return result;
  const std::vector<std::string>& names = columns_->names();
  for (const std::string name : {"step", "time"}) {
    const auto place = std::find(names.begin(), names.end(), name) - names.begin();
    result[py::str(name)] = column(static_cast<std::size_t>(place));
  }
  for (const ProbeColumns& probe : session_->probes().probes()) {
    for (std::size_t c = 0; c < probe.size(); ++c) {
      result[py::str(probe.columns[c])] = column(names.size() + probe.first + c);
    }
  }
  return result;
}

void PythonSession::add_row() {
  if (!columns_) return;
  const std::vector<double> row = columns_->values(*session_);
  rows_.insert(rows_.end(), row.begin(), row.end());
  const ProbeSet& probes = session_->probes();
  const std::size_t first = rows_.size();
  rows_.resize(first + probes.value_count(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < probes.probes().size(); ++i) {
    if (probes.is_due(i, session_->step_number())) {
      probes.evaluate(i, *session_, rows_.data() + first);
    }
  }
}

void PythonSession::remove_later_rows() {
  if (!columns_) return;
  // The first column is the step.
  const std::size_t width = row_size();
  const auto step = static_cast<double>(session_->step_number());
  while (!rows_.empty() && rows_[rows_.size() - width] > step) rows_.resize(rows_.size() - width);
}

}  // namespace tetraction::python
