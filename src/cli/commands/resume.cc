#include "resume.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/console.h"
#include "io/checkpoints/part_checkpoint.h"
#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

// The newest valid checkpoint. Those that are not valid are reported.
std::optional<StoredCheckpoint> newest_checkpoint(const std::string& directory, bool only_regular) {
  for (const CheckpointPath& file : checkpoint_paths(directory)) {
    if (only_regular && !file.is_regular) continue;
    try {
      StoredCheckpoint stored = read_checkpoint_file(file.path);
      if (stored.checkpoint.state.step == file.step && stored.is_regular == file.is_regular) {
        return stored;
      }
      print_warning(
          fmt::format("{}: its step is not the one of its name; it is not used.", file.path));
    } catch (const FileError& error) {
      print_warning(fmt::format("{} The one before it is used, if there is one.", error.what()));
    }
  }
  return std::nullopt;
}

// Tells of a checkpoint that only scenes without output.checkpoint_every use, if there is no other.
std::string stop_before_first(const std::string& directory) {
  const std::vector<CheckpointPath> files = checkpoint_paths(directory);
  const auto is_regular = [](const CheckpointPath& file) { return file.is_regular; };
  if (files.empty() || std::any_of(files.begin(), files.end(), is_regular)) return {};
  return fmt::format(
      " with the same bits: it was stopped after step {}, before the first checkpoint of "
      "output.checkpoint_every",
      files.front().step);
}

// The differences between the inputs of a checkpoint and those of the session.
std::vector<std::string> changes(const StoredCheckpoint& stored, const RunInputs& inputs,
                                 const BodyIdentity& body) {
  std::vector<std::string> parts = changed_keys(stored.inputs.scene, inputs.scene);
  const BodyIdentity& before = stored.checkpoint.body;
  if (before.mesh != body.mesh) {
    parts.emplace_back("the mesh");
  } else {
    if (before.regions != body.regions) parts.emplace_back("the regions of material");
    if (before.densities != body.densities) parts.emplace_back("the densities");
    if (stored.inputs.numbers != inputs.numbers)
      parts.emplace_back("numbers or groups of the mesh");
    if (stored.inputs.fields != inputs.fields) parts.emplace_back("the initial fields");
  }
  if (before.force_terms != body.force_terms) parts.emplace_back("the force terms");
  if (stored.inputs.amplitudes != inputs.amplitudes) {
    parts.emplace_back("the tables of amplitudes");
  }
  if (stored.inputs.surfaces != inputs.surfaces) parts.emplace_back("the surfaces of obstacles");
  return parts;
}

std::string listing_of(const std::vector<std::string>& parts) {
  constexpr std::size_t kMost = 5;
  std::string text;
  for (std::size_t i = 0; i < parts.size() && i < kMost; ++i) {
    text += (i == 0 ? "" : ", ") + parts[i];
  }
  if (parts.size() > kMost) text += fmt::format(" and {} more", parts.size() - kMost);
  return text;
}

[[noreturn]] void refuse_changes(const std::string& directory,
                                 const std::vector<std::string>& parts) {
  throw InputError(fmt::format(
      "{}: the run cannot go on, because its inputs have changed since: {}. Undo the changes, "
      "start the run anew without --resume, or let it go on with them by --force.",
      directory, listing_of(parts)));
}

// Not even --force changes what the state of the run refers to.
void require_forcible(const std::string& directory, const StoredCheckpoint& stored,
                      const std::vector<std::string>& parts, const Session& session) {
  std::vector<std::string> fixed;
  for (const std::string& part : parts) {
    const std::string section = part.substr(0, part.find('.'));
    if (section == "fix" || section == "constraint" || section == "material_region" ||
        section == "probe" || section == "the force terms") {
      fixed.push_back(part);
    }
  }
  const ForeignJson before = parse_foreign_json(stored.inputs.scene);
  const ForeignJson now = parse_foreign_json(session.scene().echo);
  const ForeignJson& events = member_of(before, "event");
  const ForeignJson& present = member_of(now, "event");
  const std::size_t made = stored.checkpoint.progress.next_event;
  for (std::size_t i = 0; i < made; ++i) {
    const ForeignJson& event = entry_of(events, i);
    if (event.is_null() || event != entry_of(present, i)) {
      fixed.push_back(fmt::format("event.{}, which was made", i));
    }
  }
  if (stored.checkpoint.state.position.size() != 3 * global_vertex_count(session.system())) {
    fixed.emplace_back("the number of vertices");
  }
  if (fixed.empty()) return;
  throw InputError(
      fmt::format("{}: the run cannot go on, because its inputs have changed since: {}. --force "
                  "does not help here. Undo the changes, or start the run anew without --resume.",
                  directory, listing_of(fixed)));
}

// The steps of the present settings begin at the restored state.
void plan_steps_anew(Session& session) {
  session.apply(SetTime{session.time_settings()});
  Checkpoint planned = session.checkpoint();
  planned.progress.edits.pop_back();
  session.restore(planned);
}

// The columns of history.csv. Empty if there is no such file.
std::string history_columns(const std::string& directory) {
  const std::string path = directory + "/history.csv";
  std::error_code error;
  std::string columns;
  // Nothing is read from a pipe, which would make the program wait.
  if (std::filesystem::is_regular_file(path, error)) {
    std::ifstream file(path, std::ios::binary);
    std::getline(file, columns);
  }
  return columns;
}

// A command that was cut off has left no summary, but a history.
void refuse_equilibrium(const std::string& directory, const ForeignJson& summary) {
  const bool is_equilibrium = summary.is_object()
                                  ? summary.contains("equilibrium")
                                  : history_columns(directory).find(",max_displacement") !=
                                        std::string::npos;  // no run has this column
  if (!is_equilibrium) return;
  throw InputError(
      fmt::format("{}: this directory holds the results of tetraction static, from which a run "
                  "cannot go on. Choose another directory with --out, or start the run without "
                  "--resume, which replaces them.",
                  directory));
}

bool has_same_mesh(const ForeignJson& summary, const MechanicalSystem& system) {
  const ForeignJson& before = member_of(summary, "mesh");
  return member_of(before, "vertices") == global_vertex_count(system) &&
         member_of(before, "tetrahedra") == global_tetrahedron_count(system) &&
         member_of(before, "volume") == system.mesh().total_volume();
}

}  // namespace

std::string read_summary(const std::string& directory) {
  return read_output(directory + "/summary.json");
}

ResumePoint find_resume_point(const Session& session, const BodyIdentity& body,
                              const std::string& directory, bool force) {
  ResumePoint point;
  const ForeignJson summary = parse_foreign_json(read_summary(directory));
  refuse_equilibrium(directory, summary);
  const Scene& scene = session.scene();
  const bool only_regular = scene.output.checkpoint_every > 0;
  std::optional<StoredCheckpoint> stored = newest_checkpoint(directory, only_regular);
  std::vector<std::string>& parts = point.changes;
  if (stored) parts = changes(*stored, inputs_of(session), body);

  const Index steps = index_or(member_of(summary, "steps"), -1);
  const double time = number_or(member_of(summary, "time"), -1.0);
  // A file without steps and time is not the summary of a run.
  if (member_of(summary, "status") == "ok" && steps >= 0 && time >= 0.0) {
    const ForeignJson& before = member_of(summary, "scene");
    std::vector<std::string> since = changed_keys(
        before.is_object() ? before.dump(-1, ' ', false, ForeignJson::error_handler_t::replace)
                           : "{}",
        scene.echo);
    if (!has_same_mesh(summary, session.system())) since.emplace_back("the mesh");
    if (parts.empty()) parts = std::move(since);
    if (parts.empty()) {
      print_note(
          fmt::format("{}: this run is complete already, with {} steps to t = {:.6g} s. To make it "
                      "once more, start it without --resume.",
                      directory, steps, time));
      point.resumption = Resumption::kComplete;
      return point;
    }
  }
  if (!parts.empty() && !force) refuse_changes(directory, parts);
  if (!stored) {
    print_note(fmt::format(
        "{}: there is no checkpoint from which a run could go on{}. The run starts from the "
        "beginning.",
        directory,
        only_regular ? stop_before_first(directory) : " (output.checkpoint_every makes them)"));
    return point;
  }
  if (!parts.empty()) require_forcible(directory, *stored, parts, session);
  point.resumption = Resumption::kContinues;
  point.has_new_steps =
      std::ranges::any_of(parts, [](const auto& part) { return part.starts_with("time."); });
  point.stored = *std::move(stored);
  return point;
}

namespace {

// Restores the session.
void restore_run(Session& session, const BodyIdentity& body, ResumePoint& point) {
  Checkpoint& checkpoint = point.stored.checkpoint;
  complete_settings(checkpoint, session.scene());
  checkpoint.body = body;
  session.restore(checkpoint);
  if (point.has_new_steps) plan_steps_anew(session);
  session.add_times(point.stored.times);
}

// Tells the user where the run goes on, and what may differ from one run.
void report_resumption(const Session& session, const ResumePoint& point,
                       const std::string& directory, bool quiet) {
  const StoredCheckpoint& stored = point.stored;
  if (!point.changes.empty()) {
    print_warning(fmt::format(
        "the run goes on with changed inputs: {}. Its results belong to no single scene.",
        listing_of(point.changes)));
  }
  const int processes = process_count(session);
  if (stored.processes != processes) {
    print_note(
        fmt::format("the checkpoint was written by {} process{}, and the run goes on in {}: the "
                    "last digits may differ from those of one run.",
                    stored.processes, stored.processes == 1 ? "" : "es", processes));
  }
  if (stored.version != version()) {
    print_warning(
        fmt::format("the checkpoint was written by version {} of the program, and this is {}: the "
                    "last digits may differ from those of one run.",
                    stored.version, version()));
  }
  if (!quiet) {
    print_note(fmt::format(
        "{}: the run goes on after step {} (t = {:.6g} s).{}", directory, session.step_number(),
        session.time(),
        stored.is_regular ? ""
                          : " The checkpoint was made when the run was stopped: implicit steps "
                            "agree with those of one run within the solver's tolerance."));
  }
}

}  // namespace

Resumption resume_run(Session& session, RunRecorder& recorder, const std::string& directory,
                      bool quiet, const PointFinder& find) {
  const MeshPart* part = session.system().part();
  const BodyIdentity body = session.checkpoint().body;
  ResumePoint point = find(body);
  point.resumption = static_cast<Resumption>(
      static_cast<int>(largest_of_parts(part, static_cast<double>(point.resumption))));
  if (point.resumption != Resumption::kContinues) return point.resumption;
  point.has_new_steps = anywhere(part, point.has_new_steps);
  if (part != nullptr) point.stored = scattered(*part, std::move(point.stored));
  restore_run(session, body, point);
  recorder.resume(session, point.stored);
  report_resumption(session, point, directory, quiet);
  return point.resumption;
}

}  // namespace tetraction
