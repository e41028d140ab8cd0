#include "study.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "interpreter.h"
#include "interruptible.h"
#include "io/stored_study/study_reader.h"
#include "io/study/study_answer.h"
#include "io/study/study_maker.h"
#include "io/study/study_page.h"
#include "io/study/study_row_json.h"
#include "io/text/output_file.h"
#include "python_objects.h"
#include "session.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/stop_request.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace tetraction::python {
namespace {

// Ends a run after a signal.
class StopAfterSignal : public Observer, public StopRequest {
 public:
  explicit StopAfterSignal(const CallingThread& caller) : caller_(caller) {}
  bool on_step(const Session&) override { return !stop_requested(); }
  bool stop_requested() const override { return caller_.stops(); }

 private:
  const CallingThread& caller_;
};

// What a program in Python asks for beside the study itself. All are None, or functions:
struct Functions {
  py::object progress;      // of number, count, rule and step before a run
  py::object made;          // of the JSON of a row after a run
  py::object custom_error;  // of two motions
};

// What is left when a study has ended.
struct StudyEnd {
  StudyPlan plan;
  std::vector<PlannedTime> times;  // of a plan that is not to be made
  std::map<std::string, std::string> texts;
  std::vector<double> custom_errors;
};

// What the class Study shows.
std::map<std::string, std::string> texts_of(const StudyResult& result, std::string json,
                                            const StudyProvenance& provenance) {
  return {{"json", std::move(json)},
          {"csv", study_csv(result, provenance)},
          {"answer", answer_text(result)},
          {"html", answer_html(result, study_answer(result), "")}};
}

py::array_t<double> table_of(const double* numbers, std::size_t rows, std::size_t columns) {
  return py::array_t<double>({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns)},
                             numbers);
}

py::dict motion_of(const PlannedRun& run, const MotionTrack& track) {
  const std::size_t times = track.positions.size();
  const auto vertices = static_cast<std::size_t>(track.rest.size() / 3);
  py::array_t<double> time(static_cast<py::ssize_t>(times));
  py::array_t<double> positions(
      {static_cast<py::ssize_t>(times), static_cast<py::ssize_t>(vertices), py::ssize_t{3}});
  for (std::size_t k = 0; k < times; ++k) {
    time.mutable_data()[k] =
        track.end * static_cast<double>(k + 1) / static_cast<double>(track.count);
    std::copy(track.positions[k].begin(), track.positions[k].end(),
              positions.mutable_data() + 3 * vertices * k);
  }
  py::dict probes;
  for (const ProbeRecord& probe : track.probes) {
    probes[py::str(probe.name)] = py::make_tuple(
        py::array_t<double>(static_cast<py::ssize_t>(probe.times.size()), probe.times.data()),
        table_of(probe.values.data(), probe.times.size(), probe.width));
  }
  return py::dict("integrator"_a = to_string(run.integrator), "step"_a = run.step, "times"_a = time,
                  "positions"_a = positions, "rest"_a = table_of(track.rest.data(), vertices, 3),
                  "probes"_a = probes);
}

// The function's value for each row; NaN where a run or its reference did not reach the end.
std::vector<double> custom_errors(StudyMaker& maker, const StudyResult& result,
                                  const py::object& function, CallingThread& caller) {
  const StudyPlan& plan = maker.plan();
  std::map<std::string, const PlannedRun*> runs;
  for (const PlannedRun& run : plan.runs) runs[run.directory] = &run;
  std::set<std::string> finished;
  for (const StudyRow& row : result.rows) {
    if (row.status == RunStatus::kFinished) finished.insert(row.directory);
  }
  std::vector<double> errors;
  for (const StudyRow& row : result.rows) {
    errors.push_back(std::numeric_limits<double>::quiet_NaN());
    const PlannedRun& run = *runs.at(row.directory);
    const PlannedRun& exact = plan.finest_run(plan.references[plan.reference_of[run.variant]]);
    if (!finished.contains(run.directory) || !finished.contains(exact.directory)) continue;
    const auto own = maker.track(run);
    const auto reference = maker.track(exact);
    if (!own || !reference) continue;
    caller.call([&] {
      errors.back() = function(motion_of(run, *own), motion_of(exact, *reference)).cast<double>();
    });
  }
  return errors;
}

StudyHooks hooks_of(const Functions& functions, CallingThread& caller) {
  StudyHooks hooks;
  if (!functions.progress.is_none()) {
    hooks.progress = [&](std::size_t i, std::size_t count, const PlannedRun& run) {
      caller.call([&] { functions.progress(i, count, to_string(run.integrator), run.step); });
    };
  }
  if (!functions.made.is_none()) {
    hooks.made = [&](const StudyRow& row) {
      caller.call([&] { functions.made(study_row_json(row).dump()); });
    };
  }
  hooks.observe = [&](std::vector<std::unique_ptr<Observer>>& list) {
    list.push_back(std::make_unique<StopAfterSignal>(caller));
  };
  hooks.is_stopped = [&] { return caller.stops().load(); };
  return hooks;
}

// Makes a study, in the thread of its computation.
StudyEnd make_study(const StudyInputs& inputs, bool has_frames, const Functions& functions,
                    CallingThread& caller) {
  check_placed_materials(*make_system(inputs.scene, *inputs.mesh));
  for (const StudyVariant& variant : inputs.settings.variants) {
    check_placed_materials(*make_system(variant.scene, *variant.mesh));
  }
  StudyMaker maker(inputs, hooks_of(functions, caller));
  StudyEnd end;
  if (!maker.choose()) return end;
  end.plan = maker.plan();
  if (inputs.options.plan) {
    end.times = maker.planned_times();
    if (const auto check = maker.planned_mesh_check()) end.times.push_back(*check);
    return end;
  }
  std::vector<std::string> frames;
  if (has_frames) {
    for (const PlannedRun& run : end.plan.runs) frames.push_back(run.directory);
  }
  const StudyResult result = maker.make(frames);
  const StudyProvenance provenance = maker.provenance("");
  end.texts = texts_of(result, study_json(result, inputs.name, provenance), provenance);
  if (!inputs.directory.empty()) {
    // The plots would be those of other runs.
    for (const std::string& plot : maker.old_plots()) remove_output(plot);
    write_study(result, inputs.name, inputs.directory, provenance);
    write_study_page(result, inputs.name, inputs.directory, provenance,
                     "The study was made by a program in Python, which draws the plots when it is "
                     "asked to (Study.write_plots).");
  }
  if (!functions.custom_error.is_none()) {
    end.custom_errors = custom_errors(maker, result, functions.custom_error, caller);
  }
  return end;
}

// Reads a scene by a function of Python. The errors of the package are those of the library again.
ReadScene reader_of(const py::function& read) {
  return [read](const std::vector<std::string>& overrides) {
    try {
      return read(overrides).cast<Scene>();
    } catch (const py::error_already_set& error) {
      if (!error.matches(py::module_::import("tetraction._core").attr("InputError"))) throw;
      throw InputError(py::str(error.value()).cast<std::string>());
    }
  };
}

StudyOptions options_of(const py::dict& given) {
  const auto text = [&](const char* key) { return given[key].cast<std::string>(); };
  const auto texts = [&](const char* key) { return given[key].cast<std::vector<std::string>>(); };
  StudyOptions options;
  options.integrators = texts("integrators");
  options.rules = texts("rules");
  options.steps = texts("steps");
  options.vary = texts("vary");
  options.also_solvers = texts("also_solver");
  options.budget = text("budget");
  options.target = text("target");
  options.error = text("error");
  options.reference = text("reference");
  options.reference_integrator = text("reference_integrator");
  options.reference_step = given["reference_step"].cast<std::optional<double>>();
  options.part = text("part");
  options.repeats = given["repeats"].cast<int>();
  options.jobs = given["jobs"].cast<int>();
  options.mesh_check = given["mesh_check"].cast<bool>();
  options.fresh = given["fresh"].cast<bool>();
  options.plan = given["plan"].cast<bool>();
  return options;
}

py::list lines_of(const StudyEnd& end) {
  py::list list;
  for (const auto& [run, is_kept, steps, seconds] : end.times) {
    list.append(py::dict("integrator"_a = to_string(run.integrator),
                         "settings"_a = to_string(run.settings),
                         "variant"_a = end.plan.variants[run.variant].name, "solver"_a = run.solver,
                         "role"_a = to_string(run.role), "step"_a = run.step, "steps"_a = steps,
                         "seconds"_a = seconds, "kept"_a = is_kept, "directory"_a = run.directory));
  }
  return list;
}

}  // namespace

void define_study(py::module_& m) {
  // `read` makes the scene with a list of overrides. Returns the rows of the plan, or texts_of() the result and the
  // values of the function custom_error.
  m.def(
      "study",
      [](const py::function& read, const std::optional<TetMesh>& given, const py::dict& arguments) {
        StudyInputs inputs = read_study_inputs(options_of(arguments), reader_of(read), {});
        inputs.directory = arguments["out"].cast<std::string>();
        inputs.name = arguments["name"].cast<std::string>();
        inputs.keeps_runs = arguments["keeps_runs"].cast<bool>();
        const bool has_frames = arguments["frames"].cast<bool>();
        const Functions functions{arguments["progress"], arguments["made"],
                                  arguments["custom_error"]};
        StudyEnd end;
        compute_interruptibly([&](CallingThread& caller) {
          read_study_mesh(inputs, [&](const Scene& of) { return session_mesh(of, given); });
          end = make_study(inputs, has_frames, functions, caller);
        });
        return inputs.options.plan ? py::object(lines_of(end))
                                   : py::make_tuple(end.texts, end.custom_errors);
      },
      "read"_a, "mesh"_a, "arguments"_a);
  m.def(
      "read_study",
      [](const std::string& directory) {
        try {
          StoredStudy stored = read_stored_study(directory);
          return texts_of(stored.result, std::move(stored.text), stored.provenance);
        } catch (const FileError& error) {
          throw InputError(error.what());
        }
      },
      "directory"_a);
}

}  // namespace tetraction::python
