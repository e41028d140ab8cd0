#include "study.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
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
#include "io/results/directory_lock.h"
#include "io/results/result_folders.h"
#include "io/scene/scene_variants.h"
#include "io/study/study_folder.h"
#include "io/study/study_page.h"
#include "io/study/study_row_json.h"
#include "io/text/output_file.h"
#include "python_objects.h"
#include "session.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/error.h"
#include "tetraction/core/provenance.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/stop_request.h"
#include "tetraction/simulation/study.h"

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

// Rows and tracks of the runs of a study without a directory.
class RunsInMemory {
 public:
  StudyMemory memory() {
    StudyMemory memory;
    memory.kept = [this](const PlannedRun& run) -> std::optional<StudyRow> {
      const auto found = runs_.find(run.directory);
      if (found == runs_.end()) return {};
      StudyRow row = found->second.row;
      row.role = run.role;
      row.compares_solver = run.compares_solver;
      return row;
    };
    memory.made = [this](const PlannedRun& run, const StudyRow& row, const MotionTrack& track) {
      runs_[run.directory] = {row, std::make_shared<const MotionTrack>(track)};
    };
    memory.track = [this](const PlannedRun& run) {
      const auto found = runs_.find(run.directory);
      return found == runs_.end() ? nullptr : found->second.track;
    };
    return memory;
  }

 private:
  struct Run {
    StudyRow row;
    std::shared_ptr<const MotionTrack> track;
  };
  std::map<std::string, Run> runs_;
};

// What a program in Python asks for.
struct StudyCall {
  StudySettings settings;
  StudyRequests requests;
  std::string out;   // empty: everything stays in memory
  std::string name;  // of the scene
  int jobs = 1;
  bool is_fresh = false;
  bool keeps_runs = true;  // whether runs of an earlier call may be taken over
  bool has_frames = false;
  bool is_plan = false;
  // None, or functions:
  py::object progress;      // of number, count, rule and step before a run
  py::object made;          // of the JSON of a row after a run
  py::object custom_error;  // of two motions
};

struct PlannedLine {
  PlannedRun run;
  bool is_kept = false;
  double seconds = 0.0;
};

// What is left when a study has ended.
struct StudyEnd {
  StudyPlan plan;
  std::vector<PlannedLine> lines;  // of a plan that is not to be made
  std::string json;
  std::string csv;
  std::vector<double> custom_errors;
};

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

// Throws what is wrong before the first run.
void check_study(const StudyCall& call, const Scene& scene, const TetMesh& mesh) {
  require_local_engine(scene);
  if (!call.out.empty()) {
    check_folder_of_study(scene, call.out);
    if (!call.is_fresh) refuse_other_study(call.out, call.name);
  }
  check_placed_materials(*make_system(scene, mesh));
  for (const StudyVariant& variant : call.settings.variants) {
    require_local_engine(variant.scene);
    const auto system = make_system(variant.scene, *variant.mesh);
    check_placed_materials(*system);
    try {
      check_events(variant.scene, *system);
    } catch (const InputError& error) {
      throw InputError(in_variant(variant, error.what()));
    }
  }
}

// Makes a study, in the thread of its computation.
class StudyMaker {
 public:
  StudyMaker(const StudyCall& call, const Scene& scene, const TetMesh& mesh, CallingThread& caller)
      : call_(call),
        scene_(scene),
        mesh_(mesh),
        caller_(caller),
        frame_(begin_plan(scene, mesh, call.settings)),
        digests_(frame_, mesh),
        goes_on_(has_folder() && call.keeps_runs && !call.is_fresh && holds_study(call.out)) {}

  StudyEnd make() {
    const ChosenStudy chosen = choose();
    StudyEnd end;
    if (chosen.choice.is_stopped) return end;
    end.plan = plan_study(scene_, mesh_, chosen.settings);
    if (has_folder()) check_folder_of_study(end.plan, call_.out);
    const StudyMemory memory = enter(end.plan, call_.has_frames);
    if (call_.is_plan) {
      for (const PlannedRun& run : end.plan.runs) {
        const bool is_kept = memory.kept(run).has_value();
        const double seconds = is_kept ? 0.0 : estimated_seconds(end.plan, run, mesh_);
        end.lines.push_back({run, is_kept, seconds});
      }
      return end;
    }
    begin();
    StudyResult result = run_study(end.plan, mesh_, observers(), progress(), memory, call_.jobs);
    result.target = call_.requests.target;
    result.findings = chosen.findings;
    result.remarks.insert(result.remarks.begin(), chosen.choice.remarks.begin(),
                          chosen.choice.remarks.end());
    const StudyProvenance provenance{"", utc_now()};
    end.json = study_json(result, call_.name, provenance);
    end.csv = study_csv(result, provenance);
    if (has_folder()) write(result, provenance);
    if (!call_.custom_error.is_none()) end.custom_errors = custom_errors(result, end.plan, memory);
    return end;
  }

 private:
  bool has_folder() const { return !call_.out.empty(); }

  // Where the runs of this plan are kept from now on.
  StudyMemory enter(const StudyPlan& plan, bool has_frames) {
    StudyMemory memory = in_memory_.memory();
    if (has_folder()) {
      std::vector<std::string> frames;
      if (has_frames) {
        for (const PlannedRun& run : plan.runs) frames.push_back(run.directory);
      }
      folder_.emplace(call_.out, plan, mesh_, digests_, frames);
      StudyMemory in_folder = folder_->memory(true);
      if (call_.is_plan) {  // nothing is written
        memory.kept = [this, own = memory.kept, in_folder](const PlannedRun& run) {
          std::optional<StudyRow> row = own(run);
          return !row && goes_on_ ? in_folder.kept(run) : row;
        };
        memory.track = [own = memory.track, in_folder](const PlannedRun& run) {
          const auto track = own(run);
          return track ? track : in_folder.track(run);
        };
      } else {
        memory = in_folder;
        memory.kept = [this, in_folder](const PlannedRun& run) -> std::optional<StudyRow> {
          if (!goes_on_ && !made_.contains(run.directory)) return {};
          return in_folder.kept(run);
        };
      }
    }
    if (call_.is_plan) return memory;
    memory.made = [this, keep = memory.made](const PlannedRun& run, const StudyRow& row,
                                             const MotionTrack& track) {
      keep(run, row, track);
      if (call_.made.is_none()) return;
      caller_.call([&] { call_.made(study_row_json(row).dump()); });
    };
    return memory;
  }

  ChosenStudy choose() {
    StudyPlan trial = frame_;
    const StudyMemory memory = enter(trial, false);
    return choose_study(frame_, mesh_, call_.settings, call_.requests, [&](const PlannedRun& run) {
      trial.runs = {run};
      if (has_folder()) check_folder_of_study(trial, call_.out);
      begin();
      return make_tracked_run(frame_, run, mesh_, observers(), progress(), memory);
    });
  }

  void begin() {
    if (lock_ || !has_folder() || call_.is_plan) return;
    make_output_directory(call_.out);
    lock_.emplace(call_.out);
  }

  ObserverFactory observers() {
    return [this](const std::string& run) {
      std::vector<std::unique_ptr<Observer>> list;
      if (has_folder() && !call_.is_plan) {
        if (made_.empty() && call_.is_fresh) remove_study(call_.out);
        made_.insert(run);
        folder_->begin_run(run, call_.name);
        list.push_back(std::make_unique<RunRecorder>(
            folder_->path(run), folder_->has_frames(run) ? scene_.output.every : 0));
      }
      list.push_back(std::make_unique<StopAfterSignal>(caller_));
      return list;
    };
  }

  StudyProgress progress() {
    if (call_.progress.is_none() || call_.is_plan) return {};
    return [this](std::size_t i, std::size_t count, const PlannedRun& run) {
      caller_.call([&] { call_.progress(i, count, to_string(run.integrator), run.step); });
    };
  }

  void write(const StudyResult& result, const StudyProvenance& provenance) const {
    // The plots would be those of other runs.
    for (const std::string& plot : plots_of_study(call_.out)) remove_output(plot);
    write_study(result, call_.name, call_.out, provenance);
    write_study_page(result, call_.name, call_.out, provenance,
                     "The study was made by a program in Python, which draws the plots when it is "
                     "asked to (Study.write_plots).");
  }

  // The function's value for each row; NaN where a run or its reference did not reach the end.
  std::vector<double> custom_errors(const StudyResult& result, const StudyPlan& plan,
                                    const StudyMemory& memory) {
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
      const auto own = memory.track(run);
      const auto reference = memory.track(exact);
      if (!own || !reference) continue;
      caller_.call([&] {
        errors.back() =
            call_.custom_error(motion_of(run, *own), motion_of(exact, *reference)).cast<double>();
      });
    }
    return errors;
  }

  const StudyCall& call_;
  const Scene& scene_;
  const TetMesh& mesh_;
  CallingThread& caller_;
  StudyPlan frame_;
  RunDigests digests_;
  bool goes_on_;
  RunsInMemory in_memory_;
  std::optional<StudyFolder> folder_;
  std::optional<DirectoryLock> lock_;
  std::set<std::string> made_;  // the runs of this call
};

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

std::vector<Integrator> rules_of(std::vector<std::string> names,
                                 const std::vector<std::string>& steps) {
  if (names.empty()) names = rules_with_steps(steps);
  if (names.empty()) return all_integrators();
  std::vector<Integrator> rules;
  for (const std::string& name : names) {
    const Integrator rule = integrator_from_string(name);
    if (std::find(rules.begin(), rules.end(), rule) != rules.end()) {
      throw InputError("--integrators: " + name + " is there twice.");
    }
    rules.push_back(rule);
  }
  return rules;
}

StudyCall read_call(const py::dict& given) {
  const auto text = [&](const char* key) { return given[key].cast<std::string>(); };
  const auto texts = [&](const char* key) { return given[key].cast<std::vector<std::string>>(); };
  StudyCall call;
  StudyRequests& requests = call.requests;
  const std::vector<Integrator> rules = rules_of(texts("integrators"), texts("steps"));
  requests.rules.assign(rules.begin(), rules.end());
  requests.steps = assign_steps(texts("steps"), requests.rules);
  requests.error = read_error_measure(text("error"));
  requests.budget = read_duration(text("budget"), "--budget");
  if (!text("target").empty()) requests.target = read_share(text("target"), "--target");
  if (!text("reference_integrator").empty()) {
    requests.reference_integrator = integrator_from_string(text("reference_integrator"));
  }
  StudySettings& settings = call.settings;
  settings.reference_step = given["reference_step"].cast<std::optional<double>>();
  settings.reference_kind = from_string<ReferenceKind>(text("reference"));
  for (const auto& [solver, step] :
       given["also_solver"].cast<std::vector<std::pair<std::string, double>>>()) {
    settings.solver_comparisons.push_back({solver, step});
  }
  if (requests.error.kind != ErrorKind::kPositions) {
    settings.error_probe = requests.error.name;
    settings.error_kind = requests.error.kind;
  }
  call.out = text("out");
  call.name = text("name");
  call.jobs = given["jobs"].cast<int>();
  call.is_fresh = given["fresh"].cast<bool>();
  call.keeps_runs = given["keeps_runs"].cast<bool>();
  call.has_frames = given["frames"].cast<bool>();
  call.is_plan = given["plan"].cast<bool>();
  call.progress = given["progress"];
  call.made = given["made"];
  call.custom_error = given["custom_error"];
  return call;
}

py::list lines_of(const StudyEnd& end) {
  py::list list;
  for (const auto& [run, is_kept, seconds] : end.lines) {
    const double steps = std::ceil(end.plan.end / run.step * (1.0 - 1e-9));
    list.append(py::dict("integrator"_a = to_string(run.integrator),
                         "variant"_a = end.plan.variants[run.variant].name, "solver"_a = run.solver,
                         "role"_a = to_string(run.role), "step"_a = run.step,
                         "steps"_a = static_cast<Index>(steps), "seconds"_a = seconds,
                         "kept"_a = is_kept, "directory"_a = run.directory));
  }
  return list;
}

}  // namespace

void define_study(py::module_& m) {
  // `read` makes the scene with a list of overrides. Returns the rows of the plan, or the texts of study.json and
  // study.csv with the values of the function custom_error.
  m.def(
      "study",
      [](const py::function& read, const std::optional<TetMesh>& given, const py::dict& arguments) {
        StudyCall call = read_call(arguments);
        call.settings.variants =
            read_variants(reader_of(read), {}, arguments["vary"].cast<std::vector<std::string>>());
        std::vector<StudyVariant>& variants = call.settings.variants;
        const Scene scene = variants.empty() ? reader_of(read)({}) : variants.front().scene;
        StudyEnd end;
        compute_interruptibly([&](CallingThread& caller) {
          const ReadMesh read_mesh = [&](const Scene& of) { return session_mesh(of, given); };
          const auto mesh = variants.empty() ? std::make_shared<const TetMesh>(read_mesh(scene))
                                             : read_variant_meshes(variants, read_mesh);
          check_study(call, scene, *mesh);
          end = StudyMaker(call, scene, *mesh, caller).make();
        });
        return call.is_plan ? py::object(lines_of(end))
                            : py::make_tuple(end.json, end.csv, end.custom_errors);
      },
      "read"_a, "mesh"_a, "arguments"_a);
}

}  // namespace tetraction::python
