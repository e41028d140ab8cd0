#include "session.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "tetraction/simulation/probe.h"

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
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Enters rows of the history and calls the observers of Python.
class Caller : public Observer {
 public:
  Caller(PythonSession& session, const py::list& observers, const py::object& self)
      : session_(session), observers_(observers), self_(self) {}

  bool on_step(const Session& /*session*/) override {
    session_.add_row();
    check_();
    session_.refresh();
    if (observers_.empty()) return true;
    const py::gil_scoped_acquire lock;
    for (const py::handle observer : observers_) {
      const py::object answer = observer(self_);
      if (answer.is(py::bool_(false))) return false;
    }
    return true;
  }

 private:
  PythonSession& session_;
  const py::list& observers_;
  const py::object& self_;
  SignalCheck check_;
};

}  // namespace

PythonSession::PythonSession(const Scene& scene, TetMesh mesh, bool is_static,
                             double largest_increment, bool with_history, py::object arrays)
    : arrays_(std::move(arrays)) {
  const py::gil_scoped_release released;
  session_ = std::make_unique<Session>(scene, std::move(mesh),
                                       is_static ? Analysis::kEquilibrium : Analysis::kMotion,
                                       largest_increment);
  if (with_history) columns_ = std::make_unique<HistoryColumns>(*session_);
  add_row();
}

Index PythonSession::step(Index count) {
  const py::gil_scoped_release released;
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
  Caller caller(*this, observers, self);
  std::vector<Observer*> all = own;
  all.push_back(&caller);
  const py::gil_scoped_release released;
  session_->run(all);
  refresh();
}

py::array PythonSession::view(const Vector& field, const py::object& self) {
  py::array array(py::dtype::of<double>(),
                  std::vector<py::ssize_t>{static_cast<py::ssize_t>(field.size() / 3), 3},
                  field.data(), self);
  array.attr("flags").attr("writeable") = false;
  has_views_ = true;
  return array;
}

py::array PythonSession::positions(const py::object& self) {
  return view(session_->state().position, self);
}
py::array PythonSession::velocities(const py::object& self) {
  return view(session_->state().velocity, self);
}
py::array PythonSession::momenta(const py::object& self) {
  return view(session_->state().momentum, self);
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

py::dict PythonSession::history() const {
  py::dict result;
  if (!columns_) return result;
  const std::vector<std::string>& names = columns_->names();
  for (std::size_t c = 0; c < names.size(); ++c) result[py::str(names[c])] = column(c);
  return result;
}

py::dict PythonSession::probes() const {
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
