// The extension module tetraction._core. The package around it (python/tetraction) gives its classes the form
// that users see and documents them.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "interpreter.h"
#include "io/results/result_folders.h"
#include "python_objects.h"
#include "session.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"
#include "tetraction/core/version.h"
#include "tetraction/fem/rest_state.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/key_tables.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_echo.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/scene_modes.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/step_failure.h"
#include "tetraction/simulation/study.h"
#include "tetraction/solver/normal_modes.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace tetraction::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style>;
using DoublesOfAnyKind = py::array_t<double, py::array::c_style | py::array::forcecast>;
using WithoutLock = py::call_guard<Released>;

// A matrix with one column for each item as an array with one row for each item.
py::array rows_of(const Matrix& columns) {
  py::array_t<double> array({columns.cols(), columns.rows()});
  std::copy(columns.data(), columns.data() + columns.size(), array.mutable_data());
  return array;
}
py::array vectors_of(const Vector& field) {
  py::array_t<double> array({field.size() / 3, Index{3}});
  std::copy(field.data(), field.data() + field.size(), array.mutable_data());
  return array;
}
py::array numbers_of(const Vector& field) {
  return py::array_t<double>(field.size(), field.data());
}
py::tuple tuple_of(const Vector3& v) {
  return py::make_tuple(v.x(), v.y(), v.z());
}

// A mesh that refers to arrays of Python, which must live as long as it does.
template <class Int>
TetMesh mesh_of(const Doubles& points, const py::array_t<Int, py::array::c_style>& tetrahedra) {
  return view_mesh(
      std::span<const double>(points.data(), static_cast<std::size_t>(points.size())),
      std::span<const Int>(tetrahedra.data(), static_cast<std::size_t>(tetrahedra.size())));
}
// Throws InputError if two tetrahedra have the same vertices: the body would be there twice. Readers of
// files leave them out, but arrays are not changed.
void check_repeats(const TetMesh& mesh) {
  std::vector<std::pair<std::array<Index, 4>, Index>> sorted;
  sorted.reserve(mesh.tetrahedra.size());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    std::array<Index, 4> vertices{};
    const auto own = mesh.tetrahedra[static_cast<std::size_t>(e)];
    for (std::size_t i = 0; i < 4; ++i) vertices[i] = own[i];
    std::sort(vertices.begin(), vertices.end());
    sorted.emplace_back(vertices, e);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].first != sorted[i - 1].first) continue;
    throw InputError("Tetrahedra " + std::to_string(sorted[i - 1].second) + " and " +
                     std::to_string(sorted[i].second) +
                     " have the same vertices: leave one of them out.");
  }
}

TetMesh mesh_of_arrays(const Doubles& points, const py::array& tetrahedra) {
  TetMesh mesh = py::isinstance<py::array_t<std::int32_t>>(tetrahedra)
                     ? mesh_of<std::int32_t>(points, tetrahedra)
                     : mesh_of<std::int64_t>(points, tetrahedra);
  check_repeats(mesh);
  return mesh;
}

// The mesh of a session: the given one with what the scene says of it, or the scene's own.
TetMesh session_mesh(const Scene& scene, const std::optional<TetMesh>& given) {
  if (!given) return read_scene_mesh(scene);
  TetMesh mesh = *given;
  if (scene.mesh.quadratic) mesh = with_edge_vertices(std::move(mesh));
  add_initial_fields(scene.initial, mesh);
  return mesh;
}

py::array tetrahedra_of(const TetMesh& mesh) {
  const Index width = mesh.is_quadratic() ? 10 : 4;
  py::array_t<std::int64_t> array({mesh.tetrahedron_count(), width});
  std::int64_t* next = array.mutable_data();
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    for (const Index v : mesh.tetrahedra[e]) *next++ = v;
    if (!mesh.is_quadratic()) continue;
    for (const Index v : mesh.edge_vertices[e]) *next++ = v;
  }
  return array;
}

void define_errors(py::module_& m) {
  static py::exception<Error> error(m, "Error", PyExc_RuntimeError);
  error.attr("__module__") = "tetraction";
  error.attr("__doc__") =
      "Base class of the errors of tetraction. Its text says what is wrong, where, and what to do.";
  const auto define = [&m](auto& exception, const char* name, const char* text) {
    exception.attr("__doc__") = text;
    exception.attr("__module__") = "tetraction";
    m.attr(name) = exception;
  };
  static py::exception<InputError> input(m, "InputError", error.ptr());
  define(input, "InputError", "A wrong value in a scene, a mesh or an argument.");
  static py::exception<NumericalError> numerical(m, "NumericalError", error.ptr());
  define(numerical, "NumericalError", "A computation that must succeed before a run has failed.");
  static py::exception<FileError> file(m, "FileError", error.ptr());
  define(file, "FileError", "A file is missing, unreadable or malformed, or its mesh is refused.");
  static py::exception<OutputError> output(m, "OutputError", error.ptr());
  define(output, "OutputError", "Results cannot be written.");
  // The translators are asked in the reverse order of their registration.
  // pybind11 asks for a function with this parameter.
  // NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& e) {
      input(e.what());
    } catch (const NumericalError& e) {
      numerical(e.what());
    } catch (const FileError& e) {
      file(e.what());
    } catch (const OutputError& e) {
      output(e.what());
    } catch (const Error& e) {
      error(e.what());
    }
  });
}

void define_scene(py::module_& m) {
  py::class_<Scene>(m, "Scene")
      .def_static("read", &read_scene, "path"_a, "overrides"_a = std::vector<std::string>{})
      .def_static("from_text", &read_scene_text, "text"_a, "path"_a,
                  "overrides"_a = std::vector<std::string>{})
      .def_readonly("echo", &Scene::echo)
      .def("text", &scene_text, "folder"_a)
      .def("set_material",
           [](Scene& scene, Index region, const CustomMaterial& material) {
             const auto i = static_cast<std::size_t>(region - 1);
             if (region == 0) {
               scene.material.custom = material;
             } else if (region < 0 || i >= scene.material_region.size()) {
               throw InputError("There is no region of material with that number.");
             } else {
               scene.material_region[i].material.custom = material;
             }
             scene.echo = scene_echo(scene);
           })
      .def("add_force_term", [](Scene& scene, std::shared_ptr<ForceTerm> term) {
        scene.force_term.push_back(std::move(term));
      });
  py::class_<CustomMaterial>(m, "CustomMaterial")
      .def(py::init(&make_material), "name"_a, "mu"_a, "lambda_"_a, "functions"_a, "with_places"_a);
  const py::class_<ForceTerm, std::shared_ptr<ForceTerm>> force_term(m, "ForceTerm");
  m.def("force_field", [](const std::string& name, const py::object& functions) {
    return std::const_pointer_cast<ForceTerm>(make_force_field(name, functions));
  });
  m.def("scene_sections", [] {
    py::list list;
    for (const SectionDescription& section : section_descriptions()) {
      list.append(py::make_tuple(section.name, section.is_list, section.may_change));
    }
    return list;
  });
  m.def("documentation_of", &documentation_of, "error"_a);
  m.def("section_keys", [](const std::string& section) {
    py::list list;
    for (const KeyDescription& key : key_descriptions(section)) {
      list.append(py::make_tuple(key.name, key.type, key.standard, key.absent, key.meaning));
    }
    return list;
  });
  // Ψ, P and A of the material of a scene at F (n, 3, 3).
  m.def("evaluate_material", [](const Scene& scene, const DoublesOfAnyKind& f) {
    const MaterialModel model = make_material(scene.material);
    const py::ssize_t n = f.shape(0);
    py::array_t<double> energy(n);
    py::array_t<double> stress({n, py::ssize_t{3}, py::ssize_t{3}});
    py::array_t<double> stiffness(
        {n, py::ssize_t{3}, py::ssize_t{3}, py::ssize_t{3}, py::ssize_t{3}});
    std::visit(
        [&](const auto& material) {
          for (py::ssize_t k = 0; k < n; ++k) {
            const Matrix3 gradient =
                Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(f.data() + 9 * k);
            if (!material.admissible(gradient)) {
              throw InputError("The energy density is not defined at entry " + std::to_string(k) +
                               " of F.");
            }
            energy.mutable_data()[k] = material.energy_density(gradient);
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> p(stress.mutable_data() +
                                                                       9 * k);
            p = material.first_piola(gradient);
            const Matrix9 a = material.stiffness(gradient);
            double* next = stiffness.mutable_data() + 81 * k;
            for (int i = 0; i < 3; ++i) {
              for (int j = 0; j < 3; ++j) {
                for (int o = 0; o < 3; ++o) {
                  for (int l = 0; l < 3; ++l) *next++ = a(i + 3 * j, o + 3 * l);
                }
              }
            }
          }
        },
        model);
    return py::make_tuple(energy, stress, stiffness);
  });
}

// The numbers that scenes, edits and files have for the vertices.
py::array_t<std::int64_t> vertex_ids_of(const TetMesh& mesh) {
  py::array_t<std::int64_t> ids(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) ids.mutable_data()[v] = mesh.vertex_id(v);
  return ids;
}

void define_mesh(py::module_& m) {
  py::class_<TetMesh>(m, "Mesh")
      .def_static(
          "read",
          [](const std::string& path, double scale, bool quadratic) {
            TetMesh mesh = read_mesh(path, scale);
            return quadratic ? with_edge_vertices(std::move(mesh)) : mesh;
          },
          "path"_a, "scale"_a = 1.0, "quadratic"_a = false, WithoutLock())
      .def_static(
          "of_scene", [](const Scene& scene) { return read_scene_mesh(scene); }, WithoutLock())
      .def_static(
          "view",
          [](const Doubles& points, const py::array& tetrahedra) {
            return mesh_of_arrays(points, tetrahedra);
          },
          py::keep_alive<0, 1>(), py::keep_alive<0, 2>())
      .def_property_readonly("source", [](const TetMesh& mesh) { return mesh.source; })
      .def_property_readonly("points",
                             [](const TetMesh& mesh) { return vectors_of(mesh.rest_positions()); })
      .def_property_readonly("tetrahedra", &tetrahedra_of)
      .def_property_readonly("volume", [](const TetMesh& mesh) { return mesh.total_volume(); })
      .def_property_readonly("is_quadratic", &TetMesh::is_quadratic)
      .def_property_readonly("vertex_ids", &vertex_ids_of)
      .def_property_readonly("regions",
                             [](const TetMesh& mesh) {
                               py::array_t<std::int64_t> array(mesh.tetrahedron_count());
                               for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
                                 array.mutable_data()[e] = mesh.region(e);
                               }
                               return array;
                             })
      .def_property_readonly("groups",
                             [](const TetMesh& mesh) {
                               py::dict groups;
                               for (const Group& group : mesh.groups) {
                                 groups[py::str(group.name)] = py::array_t<std::int64_t>(
                                     static_cast<py::ssize_t>(group.vertices.size()),
                                     group.vertices.data());
                               }
                               return groups;
                             })
      .def_property_readonly("point_arrays",
                             [](const TetMesh& mesh) {
                               py::dict arrays;
                               for (const auto& [name, values] : mesh.point_arrays) {
                                 arrays[py::str(name)] = rows_of(values);
                               }
                               return arrays;
                             })
      .def_property_readonly("cell_arrays", [](const TetMesh& mesh) {
        py::dict arrays;
        for (const auto& [name, values] : mesh.cell_arrays) {
          arrays[py::str(name)] = rows_of(values);
        }
        return arrays;
      });
}

// Warns the caller of the method of the package that has called this module.
void warn(const char* text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text, 2) != 0) throw py::error_already_set();
}

py::object failure_of(const Session& session) {
  const StepFailure* failure = session.failure();
  if (failure == nullptr) return py::none();
  const TetMesh& mesh = session.system().mesh();
  py::list elements;
  for (const Index e : failure->elements) elements.append(mesh.tetrahedron_id(e));
  return py::dict("step"_a = failure->step, "time"_a = failure->time,
                  "time_step"_a = failure->time_step, "stable_step"_a = failure->stable_step,
                  "cause"_a = to_string(failure->cause), "what"_a = failure->what,
                  "remedy"_a = failure->remedy, "elements"_a = elements,
                  "jacobian"_a = failure->jacobian);
}

py::dict balance_of(const Session& session) {
  const Balance& b = session.balance();
  return py::dict("external_work"_a = b.external_work(),
                  "dissipated_energy"_a = b.dissipated_energy(),
                  "constraint_work"_a = b.constraint_work(), "edit_work"_a = b.edit_work(),
                  "energy_error"_a = b.energy_error(), "energy_scale"_a = b.energy_scale(),
                  "max_relative_energy_drift"_a = b.max_relative_energy_drift(),
                  "linear_momentum"_a = tuple_of(b.momenta().linear),
                  "angular_momentum"_a = tuple_of(b.momenta().angular),
                  "linear_momentum_drift"_a = b.linear_momentum_drift(),
                  "angular_momentum_drift"_a = b.angular_momentum_drift(),
                  "allowed_angular_momentum_drift"_a = b.allowed_angular_momentum_drift());
}

py::object load_path_of(const Session& session) {
  const LoadPath* path = session.load_path();
  if (path == nullptr) return py::none();
  py::list points;
  for (const LimitPoint& point : path->limit_points) {
    points.append(
        py::dict("below"_a = point.below, "above"_a = point.above, "passed"_a = point.passed));
  }
  py::object loss = py::none();
  if (path->loss) {
    loss =
        py::dict("below"_a = path->loss->below, "above"_a = path->loss->above,
                 "flutter"_a = path->loss->is_flutter, "growth_rate"_a = path->loss->growth_rate,
                 "damping_ratio"_a = path->loss->damping_ratio, "is_over"_a = path->loss->is_over);
  }
  return py::dict("factor"_a = path->factor, "steps"_a = path->steps, "cuts"_a = path->cuts,
                  "residual"_a = path->residual, "residual_limit"_a = path->residual_limit,
                  "force"_a = path->force, "limit_points"_a = points, "loss_of_stability"_a = loss);
}

void define_session(py::module_& m) {
  const py::class_<Checkpoint> checkpoint_class(m, "Checkpoint");
  using S = PythonSession;
  const auto self_of = [](const py::object& self) -> S& { return self.cast<S&>(); };
  py::class_<S>(m, "Session")
      .def(py::init([](const Scene& scene, const std::optional<TetMesh>& mesh, bool is_static,
                       double largest_increment, bool with_history, py::object arrays) {
             return std::make_unique<S>(scene, session_mesh(scene, mesh), is_static,
                                        largest_increment, with_history, std::move(arrays));
           }),
           "scene"_a, "mesh"_a, "is_static"_a, "largest_increment"_a, "with_history"_a, "arrays"_a)
      .def("step", &S::step)
      .def_property_readonly("vertex_ids",
                             [](const S& s) { return vertex_ids_of(s.session().system().mesh()); })
      .def(
          "run",
          [self_of](const py::object& self, const py::list& observers, const std::string& out,
                    const py::object& shown) {
            S& session = self_of(self);
            std::unique_ptr<RunRecorder> recorder;
            std::vector<Observer*> own;
            if (!out.empty()) {
              check_folder_of_run(session.session().scene(), out);
              recorder = std::make_unique<RunRecorder>(out, session.session().scene().output.every);
              if (session.session().load_path() == nullptr) {
                recorder->keep_checkpoints(session.session().scene().output.checkpoint_every);
              }
              own.push_back(recorder.get());
            }
            session.run(own, observers, shown);
            if (recorder && recorder->checkpoint_every() > 0 &&
                recorder->leaves_out_checkpoints()) {
              warn(
                  "The run has no checkpoint files, because the session was edited. Make the edits "
                  "events of the scene if a program shall resume it (output.checkpoint_every).");
            }
            return recorder ? recorder->summary() : std::string();
          })
      // Makes the edits of event number i of a scene.
      .def(
          "apply",
          [](S& s, const Scene& scene, std::size_t i) {
            const Turns::Turn turn(s.turns(), Turns::Use::kEdit);
            const EventSettings& event = scene.event.at(i);
            for (const Edit& edit : event.edits) s.session().apply(edit, event.echo);
            s.refresh();
          },
          WithoutLock())
      .def("set_material",
           [](S& s, Index region, const CustomMaterial& material) {
             const Released released;
             if (region < 0 || region >= static_cast<Index>(s.session().materials().size())) {
               throw InputError("There is no region of material with that number.");
             }
             const Turns::Turn turn(s.turns(), Turns::Use::kEdit);
             check_placed_material(material, s.session().system(), region);
             MaterialSettings settings = s.session().materials()[static_cast<std::size_t>(region)];
             settings.custom = material;
             s.session().apply(SetMaterial{region, settings});
             s.refresh();
           })
      .def(
          "checkpoint",
          [](S& s) {
            const Turns::Turn turn(s.turns(), Turns::Use::kEdit);
            return s.session().checkpoint();
          },
          WithoutLock())
      .def(
          "restore",
          [](S& s, const Checkpoint& checkpoint) {
            const Turns::Turn turn(s.turns(), Turns::Use::kStep);
            s.session().restore(checkpoint);
            s.remove_later_rows();
            s.refresh();
          },
          WithoutLock())
      .def("keep_good_states", [](S& s) { s.session().keep_good_states(); })
      .def(
          "go_back",
          [](S& s) {
            const Turns::Turn turn(s.turns(), Turns::Use::kStep);
            s.session().go_back();
            s.remove_later_rows();
            s.refresh();
          },
          WithoutLock())
      .def_property_readonly("positions",
                             [self_of](const py::object& o) { return self_of(o).positions(o); })
      .def_property_readonly("velocities",
                             [self_of](const py::object& o) { return self_of(o).velocities(o); })
      .def_property_readonly("momenta",
                             [self_of](const py::object& o) { return self_of(o).momenta(o); })
      .def_property_readonly("history", &S::history)
      .def_property_readonly("probes", &S::probes)
      .def_property_readonly("time", [](const S& s) { return s.session().time(); })
      .def_property_readonly("step_number", [](const S& s) { return s.session().step_number(); })
      .def_property_readonly("step_count", [](const S& s) { return s.session().step_count(); })
      .def_property_readonly("time_step", [](const S& s) { return s.session().time_step(); })
      .def_property_readonly("stable_step",
                             [](const S& s) { return s.session().initial_limit().critical_step; })
      .def(
          "current_stable_step",
          [](S& s) {
            const Turns::Turn turn(s.turns(), Turns::Use::kEdit);
            return s.session().current_limit().critical_step;
          },
          WithoutLock())
      .def_property_readonly("status", [](const S& s) { return to_string(s.session().status()); })
      .def_property_readonly("message", [](const S& s) { return s.session().message(); })
      .def_property_readonly("failure", [](const S& s) { return failure_of(s.session()); })
      .def_property_readonly("warnings", [](const S& s) { return s.session().warnings(); })
      .def_property_readonly("energies",
                             [](const S& s) {
                               const Energies& energies = s.session().balance().energies();
                               py::dict result;
                               for (const Energies::Entry& entry : energies.entries()) {
                                 result[py::str(entry.name)] = entry.value;
                               }
                               result["total"] = energies.total();
                               return result;
                             })
      .def_property_readonly("balance", [](const S& s) { return balance_of(s.session()); })
      .def_property_readonly("load_path", [](const S& s) { return load_path_of(s.session()); })
      .def_property_readonly("reactions",
                             [](const S& s) { return vectors_of(s.session().reaction_force()); })
      .def_property_readonly("external_forces",
                             [](const S& s) { return vectors_of(s.session().external_force()); })
      .def_property_readonly("masses",
                             [](const S& s) { return numbers_of(s.session().system().mass()); })
      .def_property_readonly(
          "rest_positions",
          [](const S& s) { return vectors_of(s.session().system().mesh().rest_positions()); })
      .def_property_readonly("tetrahedra",
                             [](const S& s) { return tetrahedra_of(s.session().system().mesh()); })
      .def(
          "fields",
          [](S& s, const std::vector<std::string>& names) {
            const Turns::Turn turn(s.turns(), Turns::Use::kEdit);
            std::vector<const Quantity*> list;
            for (const std::string& name : names) list.push_back(&named_quantity(name));
            const std::vector<Matrix> values = values_of(s.session(), list);
            const Acquired lock;
            py::dict result;
            for (std::size_t i = 0; i < names.size(); ++i) {
              result[py::str(names[i])] = values[i].rows() == 1
                                              ? numbers_of(values[i].row(0).transpose())
                                              : rows_of(values[i]);
            }
            return result;
          },
          "names"_a, WithoutLock());
}

// Computes in a thread of its own without the interpreter's lock, and ends with the exception of a signal's
// handler soon after the signal: Python gives signals to the thread that has called.
void interruptibly(const std::function<void()>& compute) {
  constexpr std::chrono::milliseconds kPause{50};
  std::mutex mutex;
  std::condition_variable ended;
  bool has_ended = false;
  std::atomic<bool> stops{false};
  std::exception_ptr failure;
  const Released released;
  std::thread worker([&] {
    try {
      const Interruptible interruptible(stops);
      compute();
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    has_ended = true;
    ended.notify_all();
  });
  std::exception_ptr signal;
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, kPause, [&] { return has_ended; })) {
    if (signal) continue;
    lock.unlock();
    try {
      const Acquired python;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    } catch (...) {  // also at the end of the interpreter
      signal = std::current_exception();
      stops = true;
    }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (signal) std::rethrow_exception(signal);
  if (failure) std::rethrow_exception(failure);
}

void define_analyses(py::module_& m) {
  m.def(
      "modes",
      [](const Scene& scene, const std::optional<TetMesh>& given, Index count, bool loaded) {
        std::optional<NormalModes> modes;
        std::string warning;
        Vector q;
        interruptibly([&] {
          const std::unique_ptr<MechanicalSystem> system =
              make_system(scene, session_mesh(scene, given));
          check_placed_materials(*system);
          const PositionsOfModes at = positions_of_modes(scene, *system, loaded, count);
          if (!at.found) {
            throw NumericalError("There is no equilibrium about which the body could vibrate: " +
                                 at.message);
          }
          q = at.position;
          modes = normal_modes(*system, q, at.options);
          warning = round_off_warning(*modes);
        });
        const auto n = static_cast<py::ssize_t>(modes->modes.size());
        py::array_t<double> frequencies(n);
        py::array_t<double> ratios(n);
        py::array_t<double> round_off(n);
        py::array_t<double> masses({n, py::ssize_t{3}});
        py::array_t<double> shapes({n, static_cast<py::ssize_t>(q.size() / 3), py::ssize_t{3}});
        py::list kinds;
        for (py::ssize_t i = 0; i < n; ++i) {
          const NormalMode& mode = modes->modes[static_cast<std::size_t>(i)];
          frequencies.mutable_data()[i] = mode.frequency();
          ratios.mutable_data()[i] = mode.damping_ratio;
          round_off.mutable_data()[i] = mode.round_off;
          std::copy(mode.effective_mass.data(), mode.effective_mass.data() + 3,
                    masses.mutable_data() + 3 * i);
          std::copy(mode.shape.data(), mode.shape.data() + mode.shape.size(),
                    shapes.mutable_data() + q.size() * i);
          kinds.append(to_string(mode.kind));
        }
        return py::dict("frequencies"_a = frequencies, "kinds"_a = kinds, "shapes"_a = shapes,
                        "effective_masses"_a = masses, "damping_ratios"_a = ratios,
                        "round_off"_a = round_off, "positions"_a = vectors_of(q),
                        "moved_mass"_a = tuple_of(modes->moved_mass), "warning"_a = warning);
      },
      "scene"_a, "mesh"_a, "count"_a, "loaded"_a);

  // The text of study.json, the text of study.csv and the table for a terminal.
  m.def(
      "study",
      [](const Scene& scene, const std::optional<TetMesh>& given,
         const std::vector<std::string>& integrators, const std::vector<double>& steps,
         std::optional<double> reference_step, const std::string& reference_integrator,
         const std::string& reference, const std::string& error_probe, const std::string& out,
         const std::string& name, const py::object& progress) {
        StudySettings settings;
        for (const std::string& integrator : integrators) {
          settings.integrators.push_back(integrator_from_string(integrator));
        }
        settings.steps = steps;
        settings.reference_step = reference_step;
        settings.reference_integrator = integrator_from_string(reference_integrator);
        settings.reference_kind = reference_kind_from_string(reference);
        settings.error_probe = error_probe;
        const auto tell = [&progress](std::size_t i, std::size_t count, const PlannedRun& run) {
          const Acquired lock;
          if (PyErr_CheckSignals() != 0) throw py::error_already_set();
          if (!progress.is_none()) progress(i, count, to_string(run.integrator), run.step);
        };
        const auto observers = [&](const std::string& directory) {
          std::vector<std::unique_ptr<Observer>> list;
          if (!out.empty()) list.push_back(std::make_unique<RunRecorder>(out + "/" + directory, 0));
          return list;
        };
        const Released released;
        const TetMesh mesh = session_mesh(scene, given);
        if (!out.empty()) {
          check_folder_of_study(scene, out);
          check_folder_of_study(begin_plan(scene, mesh, settings), out);
        }
        check_placed_materials(*make_system(scene, mesh));
        const StudyResult result = run_study(scene, mesh, settings, observers, tell);
        if (!out.empty()) write_study(result, name, out, {"", utc_now()});
        std::string json = study_json(result, name);
        std::string csv = study_csv(result);
        std::string table = study_table(result);
        const Acquired lock;
        return py::make_tuple(json, csv, table);
      },
      "scene"_a, "mesh"_a, "integrators"_a, "steps"_a, "reference_step"_a, "reference_integrator"_a,
      "reference"_a, "error_probe"_a, "out"_a, "name"_a, "progress"_a);
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "The library of tetraction. Use the package tetraction instead of this module.";
  define_errors(m);
  define_mesh(m);
  define_scene(m);
  define_session(m);
  define_analyses(m);
  m.def("set_thread_count", &set_thread_count);
  m.def("thread_count", &thread_count);
  m.attr("version") = version();
  watch_interpreter_end();
}

}  // namespace tetraction::python
