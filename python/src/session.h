// A session as Python sees it.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tetraction/simulation/history.h"
#include "tetraction/simulation/session.h"

namespace tetraction::python {

/// Sees to it that one thing at a time is done with a session.
///
/// Steps let other threads of Python run, and they call functions that are written in Python. These may not
/// step or change the same session meanwhile. An observer is called between two steps, and its own thread may
/// make edits.
class Turns {
 public:
  enum class Use { kStep, kEdit };

  /// As long as it lives, the session is in use.
  class Turn {
   public:
    /// Throws InputError if the session is in use already.
    Turn(Turns& turns, Use use);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns* turns_;  // null within an observer
  };
  /// As long as it lives, this thread is in an observer.
  class Observing {
   public:
    explicit Observing(Turns& turns);
    ~Observing();
    Observing(const Observing&) = delete;
    Observing& operator=(const Observing&) = delete;

   private:
    Turns& turns_;
  };
  /// Whether the state is complete for this thread: no step is being made.
  bool may_read();

 private:
  std::mutex mutex_;
  bool in_use_ = false;
  bool observing_ = false;
  std::thread::id observer_;
};

/// The mesh of a session: the given one with what the scene says of it, or the scene's own.
TetMesh session_mesh(const Scene& scene, const std::optional<TetMesh>& given);

/// A Session with the rows of its history, the arrays that its mesh refers to, and views of its state. Steps
/// are made without the interpreter's lock.
class PythonSession {
 public:
  /// `arrays`: what a mesh that is a view refers to, kept as long as the session.
  PythonSession(const Scene& scene, TetMesh mesh, bool is_static, double largest_increment,
                bool with_history, pybind11::object arrays);

  Session& session() { return *session_; }
  Turns& turns() { return turns_; }
  const Session& session() const { return *session_; }

  /// Makes up to `count` steps and returns how many were made. A signal, such as that of Ctrl-C, is looked
  /// for after a step, about ten times a second; its exception passes through between two steps.
  Index step(Index count);
  /// Steps to the end with the observers of the library, and calls each of `observers` with `self` after
  /// each step; the first that returns False ends the run.
  void run(const std::vector<Observer*>& own, const pybind11::list& observers,
           const pybind11::object& self);

  /// Views (n, 3) of the present state, which cannot be written to. They keep their addresses as long as
  /// the session lives, and they always show the present state: refresh() sees to that.
  pybind11::array positions(const pybind11::object& self);
  pybind11::array velocities(const pybind11::object& self);
  pybind11::array momenta(const pybind11::object& self);

  /// Name and values of each column of the history, one value for each step and one for the start.
  pybind11::dict history();
  /// The same for the probes, with step and time; NaN in steps at which a probe is not due.
  pybind11::dict probes();
  /// Enters a row for the present state.
  void add_row();
  /// Takes away the rows of steps after the present one, to which the session has gone back.
  void remove_later_rows();
  /// To be called after the state has changed.
  void refresh() const {
    if (has_views_) session_->state();
  }

 private:
  const State& state();
  pybind11::array view(const Vector& field, const pybind11::object& self);
  std::size_t row_size() const;
  // One column of the rows as an array.
  pybind11::object column(std::size_t place) const;

  Turns turns_;
  pybind11::object arrays_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<HistoryColumns> columns_;  // null without a history
  std::vector<double> rows_;                 // of the history, then of the probes
  const State* seen_ = nullptr;              // Session::state()
  bool has_views_ = false;
};

}  // namespace tetraction::python
