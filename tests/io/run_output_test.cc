// The files of a run: probes.csv, the rows of history.csv, the fields and formats of frames.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/bodies.h"
#include "support/folder_test.h"
#include "support/scene_parts.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/io/frame_reader.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;
using namespace testing_support;

// A CSV file: the cells of each column.
using Columns = std::map<std::string, std::vector<std::string>>;

class RunOutput : public FolderTest {
 protected:
  void SetUp() override {
    scene_ = spinning_block(Integrator::kVerlet, 1e-3, 0.0235);
    scene_.fix = {fix(SelectPlane{0, 0.0, {}})};
    scene_.initial.angular_velocity.setZero();
  }

  void run(int frame_every = 5) {
    TetMesh mesh = generate_mesh(*scene_.mesh.generate);
    if (scene_.mesh.quadratic) mesh = with_edge_vertices(std::move(mesh));
    session_ = std::make_unique<Session>(scene_, std::move(mesh));
    recorder_ = std::make_unique<RunRecorder>(folder_.string(), frame_every);
    session_->run({recorder_.get()});
    ASSERT_EQ(session_->status(), RunStatus::kFinished) << session_->message();
  }

  std::string text(const std::string& name) const { return contents(path(name)); }

  Columns csv(const std::string& name) const {
    std::stringstream lines(text(name));
    Columns columns;
    std::vector<std::string> names;
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> cells(1);
      for (const char c : line) {
        if (c == ',') {
          cells.emplace_back();
        } else {
          cells.back() += c;
        }
      }
      if (names.empty()) {
        names = cells;
        continue;
      }
      EXPECT_EQ(cells.size(), names.size()) << line;
      for (std::size_t i = 0; i < cells.size(); ++i) columns[names[i]].push_back(cells[i]);
    }
    return columns;
  }

  ProbeSettings tip(ProbeQuantity quantity, const std::string& name, int every = 1) const {
    return probe_at(name, quantity, {1.9, 0.6, 0.7}, every);
  }
  Scene scene_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<RunRecorder> recorder_;
};

// Evaluates all probes in each step, to compare with the file.
class Evaluate : public Observer {
 public:
  void on_start(const Session& session) override { on_step(session); }
  bool on_step(const Session& session) override {
    rows.emplace_back(session.probes().value_count());
    session.probes().evaluate(session, rows.back().data());
    times.push_back(session.time());
    return true;
  }
  std::vector<std::vector<double>> rows;
  std::vector<double> times;
};

TEST_F(RunOutput, ProbesHaveARowForEachStepWithAllDigits) {
  scene_.probe = {tip(ProbeQuantity::kDisplacement, "tip"), tip(ProbeQuantity::kVonMises, "vm"),
                  tip(ProbeQuantity::kCauchyStress, "s")};
  session_ = std::make_unique<Session>(scene_, generate_mesh(*scene_.mesh.generate));
  RunRecorder recorder(folder_.string(), 0);
  Evaluate evaluate;
  session_->run({&recorder, &evaluate});
  EXPECT_EQ(text("probes.csv").substr(0, 60),
            "step,time,tip_x,tip_y,tip_z,vm,s_xx,s_yy,s_zz,s_xy,s_yz,s_xz");
  const Columns columns = csv("probes.csv");
  ASSERT_EQ(evaluate.rows.size(), 25U);
  const char* const names[] = {"tip_x", "tip_y", "tip_z", "vm",   "s_xx",
                               "s_yy",  "s_zz",  "s_xy",  "s_yz", "s_xz"};
  for (std::size_t row = 0; row < evaluate.rows.size(); ++row) {
    EXPECT_EQ(columns.at("step")[row], std::to_string(row));
    EXPECT_EQ(std::strtod(columns.at("time")[row].c_str(), nullptr), evaluate.times[row]);
    for (std::size_t c = 0; c < 10; ++c) {
      EXPECT_EQ(std::strtod(columns.at(names[c])[row].c_str(), nullptr), evaluate.rows[row][c]);
    }
  }
  EXPECT_EQ(columns.at("tip_x").size(), 25U);
}

TEST_F(RunOutput, ProbesThatAreNotDueLeaveTheirCellsEmpty) {
  scene_.probe = {tip(ProbeQuantity::kDisplacement, "a", 4), tip(ProbeQuantity::kJacobian, "b", 6)};
  run();
  const Columns columns = csv("probes.csv");
  const std::vector<std::string> steps{"0", "4", "6", "8", "12", "16", "18", "20", "24"};
  EXPECT_EQ(columns.at("step"), steps);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int step = std::stoi(steps[i]);
    EXPECT_EQ(columns.at("a_y")[i].empty(), step % 4 != 0) << step;
    EXPECT_EQ(columns.at("b")[i].empty(), step % 6 != 0) << step;
  }
  // A last step at which nothing is due has all values.
  scene_.time.end = 0.0225;
  run();
  const Columns shorter = csv("probes.csv");
  EXPECT_EQ(shorter.at("step").back(), "23");
  EXPECT_FALSE(shorter.at("a_x").back().empty());
  EXPECT_FALSE(shorter.at("b").back().empty());
}

TEST_F(RunOutput, WithoutProbesThereIsNoFileOfThem) {
  scene_.probe = {tip(ProbeQuantity::kJacobian, "j")};
  run();
  EXPECT_TRUE(fs::exists(folder_ / "probes.csv"));
  scene_.probe.clear();
  run();
  EXPECT_FALSE(fs::exists(folder_ / "probes.csv"));
  EXPECT_FALSE(nlohmann::json::parse(text("summary.json")).contains("probes"));
}

TEST_F(RunOutput, TheSummaryHasExtremesAndFrequencies) {
  scene_.material.youngs_modulus = 1e7;
  scene_.time.end = 1.5;
  scene_.probe = {tip(ProbeQuantity::kDisplacement, "tip"),
                  tip(ProbeQuantity::kJacobian, "j", 5000)};
  run();
  const Columns columns = csv("probes.csv");
  std::vector<double> values, times;
  for (const std::string& cell : columns.at("tip_z")) {
    values.push_back(std::strtod(cell.c_str(), nullptr));
  }
  for (const std::string& cell : columns.at("time")) {
    times.push_back(std::strtod(cell.c_str(), nullptr));
  }
  const auto json = nlohmann::json::parse(text("summary.json"));
  EXPECT_EQ(text("summary.json"), recorder_->summary());
  const auto& tip_z = json["probes"]["tip_z"];
  const auto most = std::max_element(values.begin(), values.end());
  const auto least = std::min_element(values.begin(), values.end());
  EXPECT_EQ(tip_z["unit"], "m");
  EXPECT_EQ(tip_z["max"], *most);
  EXPECT_EQ(tip_z["max_time"], times[static_cast<std::size_t>(most - values.begin())]);
  EXPECT_EQ(tip_z["min"], *least);
  EXPECT_EQ(tip_z["min_time"], times[static_cast<std::size_t>(least - values.begin())]);
  EXPECT_EQ(tip_z["final"], values.back());
  ASSERT_TRUE(tip_z.contains("frequency"));
  EXPECT_EQ(tip_z["frequency"], dominant_frequency(times, values));
  // Two values are no vibration.
  EXPECT_EQ(json["probes"].size(), 4U);
  EXPECT_FALSE(json["probes"]["j"].contains("frequency"));
  EXPECT_EQ(json["probes"]["j"]["min_time"].is_number(), true);
}

TEST_F(RunOutput, TheHistoryCanHaveFewerRows) {
  run();
  const Columns all = csv("history.csv");
  ASSERT_EQ(all.at("step").size(), 25U);
  scene_.output.history_every = 7;
  run();
  const Columns some = csv("history.csv");
  EXPECT_EQ(some.at("step"), (std::vector<std::string>{"0", "7", "14", "21", "24"}));
  for (const auto& [name, cells] : some) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto step = static_cast<std::size_t>(std::stoi(some.at("step")[i]));
      EXPECT_EQ(cells[i], all.at(name)[step]) << name;  // the balance is the same
    }
  }
}

// Stops a run without a sign beforehand.
class StopAt : public Observer {
 public:
  explicit StopAt(Index step) : step_(step) {}
  bool on_step(const Session& session) override { return session.step_number() < step_; }

 private:
  Index step_;
};

TEST_F(RunOutput, ARunThatIsCutShortHasItsLastState) {
  scene_.output.history_every = 10;
  scene_.probe = {tip(ProbeQuantity::kJacobian, "j", 10)};
  session_ = std::make_unique<Session>(scene_, generate_mesh(*scene_.mesh.generate));
  RunRecorder recorder(folder_.string(), 10);
  StopAt stop(13);
  session_->run({&recorder, &stop});
  ASSERT_EQ(session_->status(), RunStatus::kCancelled);
  EXPECT_EQ(csv("history.csv").at("step"), (std::vector<std::string>{"0", "10", "13"}));
  EXPECT_EQ(csv("probes.csv").at("step"), (std::vector<std::string>{"0", "10", "13"}));
  EXPECT_FALSE(csv("probes.csv").at("j").back().empty());
}

TEST_F(RunOutput, FieldsAreThoseThatTheSceneNames) {
  std::vector<std::string> points, cells;
  for (const Quantity* field : frame_quantities()) {
    (field->domain == ValueDomain::kTetrahedra ? cells : points).emplace_back(field->name);
  }
  const auto has = [&](const char* file) {
    const StoredFrame frame = read_frame((folder_ / file).string(), points, cells);
    std::vector<std::string> found;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (frame.point_arrays[i].size() > 0) found.push_back(points[i]);
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (frame.cell_arrays[i].size() > 0) found.push_back(cells[i]);
    }
    return found;
  };
  run();
  const std::vector<std::string> defaults{
      "displacement", "velocity",       "momentum",      "external_force", "reaction_force",
      "fixed",        "deformation",    "cauchy_stress", "green_strain",   "von_mises",
      "jacobian",     "energy_density", "region"};
  EXPECT_EQ(has("frames/frame_000005.vtu"), defaults);
  EXPECT_EQ(has("final.vtu"), defaults);
  // With nodal volumes the values of the vertices are default fields, too.
  scene_.mesh.volume = VolumeRule::kNodal;
  run();
  std::vector<std::string> nodal = defaults;
  nodal.insert(nodal.begin() + 7, {"pressure_nodal", "jacobian_nodal"});
  EXPECT_EQ(has("frames/frame_000005.vtu"), nodal);
  EXPECT_EQ(has("final.vtu"), nodal);
  scene_.mesh.volume = VolumeRule::kElement;
  // Quadratic tetrahedra have stresses of their own at their vertices.
  scene_.mesh.quadratic = true;
  run();
  std::vector<std::string> quadratic = defaults;
  quadratic.insert(quadratic.begin() + 7, {"cauchy_stress_nodal", "von_mises_nodal"});
  EXPECT_EQ(has("final.vtu"), quadratic);
  {
    const StoredFrame frame =
        read_frame((folder_ / "final.vtu").string(), {"cauchy_stress_nodal", "von_mises_nodal"});
    const NodalFields fields = nodal_fields(session_->system(), session_->state().position);
    EXPECT_EQ(frame.point_arrays[0], fields.cauchy_stress);
    EXPECT_EQ(frame.point_arrays[1], fields.von_mises);
  }
  scene_.mesh.quadratic = false;
  scene_.output.fields = {"pressure", "displacement", "von_mises_nodal"};
  run();
  const std::vector<std::string> named{"displacement", "von_mises_nodal", "pressure"};
  EXPECT_EQ(has("frames/frame_000005.vtu"), named);
  EXPECT_EQ(has("final.vtu"), named);
  scene_.output.fields = {"default", "first_piola"};
  run();
  std::vector<std::string> more = defaults;
  more.emplace_back("first_piola");
  EXPECT_EQ(has("frames/frame_000024.vtu"), more);
}

TEST_F(RunOutput, NodalPressuresAreMeansAlsoWithNodalVolumes) {
  scene_.mesh.volume = VolumeRule::kNodal;
  run();
  const StoredFrame frame = read_frame((folder_ / "final.vtu").string(), {"pressure_nodal"}, {});
  const MechanicalSystem& system = session_->system();
  const ElementFields fields = element_fields(system, session_->state().position);
  EXPECT_EQ(frame.point_arrays[0], nodal_average(system, pressures(fields.cauchy_stress)));
}

TEST_F(RunOutput, FurtherFieldsAreThoseOfTheState) {
  std::vector<std::string> points{"cauchy_stress_nodal",     "green_strain_nodal",
                                  "von_mises_nodal",         "pressure_nodal",
                                  "cauchy_stress_recovered", "von_mises_recovered"};
  std::vector<std::string> cells{"first_piola", "principal_stresses", "pressure"};
  scene_.output.fields = points;
  scene_.output.fields.insert(scene_.output.fields.end(), cells.begin(), cells.end());
  run();
  const StoredFrame frame = read_frame((folder_ / "final.vtu").string(), points, cells);
  const MechanicalSystem& system = session_->system();
  const Vector& q = session_->state().position;
  const ElementFields fields = element_fields(system, q);
  EXPECT_EQ(frame.point_arrays[0], nodal_average(system, fields.cauchy_stress));
  EXPECT_EQ(frame.point_arrays[1], nodal_average(system, fields.green_strain));
  EXPECT_EQ(frame.point_arrays[2], nodal_average(system, fields.von_mises));
  EXPECT_EQ(frame.point_arrays[3], nodal_average(system, pressures(fields.cauchy_stress)));
  const Matrix recovered = recovered_field(system, fields.cauchy_stress);
  EXPECT_EQ(frame.point_arrays[4], recovered);
  const auto s = recovered.col(3);
  const double square = (s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) +
                        (s[2] - s[0]) * (s[2] - s[0]) +
                        6.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]);
  EXPECT_NEAR(frame.point_arrays[5](0, 3), std::sqrt(0.5 * square), 1e-9 * std::sqrt(square));
  EXPECT_EQ(frame.cell_arrays[0], first_piola_stress(system, q));
  EXPECT_EQ(frame.cell_arrays[1], principal_stresses(fields.cauchy_stress));
  EXPECT_EQ(frame.cell_arrays[2], pressures(fields.cauchy_stress));
}

TEST_F(RunOutput, FormatsChangeNumbersAndCompression) {
  const auto written = [&](const char* file) {
    return read_frame((folder_ / file).string(), {"displacement"}, {"cauchy_stress"});
  };
  run();
  const StoredFrame exact = written("frames/frame_000024.vtu");
  EXPECT_EQ(exact.point_arrays[0].reshaped(),
            session_->state().position - session_->system().mesh().rest_positions());
  EXPECT_NE(text("frames/frame_000024.vtu").find("vtkLZ4DataCompressor"), std::string::npos);
  for (const FrameCompression compression :
       {FrameCompression::kZlib, FrameCompression::kNone, FrameCompression::kLz4}) {
    scene_.output.compression = compression;
    for (const FramePrecision precision : {FramePrecision::kFloat32, FramePrecision::kFloat64}) {
      scene_.output.precision = precision;
      run();
      const std::string frame = text("frames/frame_000024.vtu");
      EXPECT_EQ(frame.find("vtkLZ4DataCompressor") != std::string::npos,
                compression == FrameCompression::kLz4);
      EXPECT_EQ(frame.find("vtkZLibDataCompressor") != std::string::npos,
                compression == FrameCompression::kZlib);
      const bool single = precision == FramePrecision::kFloat32;
      EXPECT_EQ(frame.find("type=\"Float32\" Name=\"displacement\"") != std::string::npos, single);
      const StoredFrame stored = written("frames/frame_000024.vtu");
      const StoredFrame final = written("final.vtu");
      EXPECT_EQ(final.point_arrays[0], exact.point_arrays[0]);
      EXPECT_EQ(final.cell_arrays[0], exact.cell_arrays[0]);
      if (single) {
        EXPECT_EQ(stored.cell_arrays[0], exact.cell_arrays[0].cast<float>().cast<double>());
        EXPECT_NE(stored.cell_arrays[0], exact.cell_arrays[0]);
      } else {
        EXPECT_EQ(stored.cell_arrays[0], exact.cell_arrays[0]);
      }
    }
  }
}

TEST_F(RunOutput, TheSummaryAccountsForTheOutput) {
  run(1);
  const auto wall = nlohmann::json::parse(text("summary.json"))["wall_seconds"];
  double sum = 0.0;
  for (const char* phase : {"mesh", "setup", "stability", "stepping", "output"}) {
    sum += wall[phase].get<double>();
  }
  EXPECT_DOUBLE_EQ(wall["total"].get<double>(), sum);
  EXPECT_EQ(wall["mesh"], 0.0);
  // The summary is written within the last call of the observer, whose time is part of it.
  EXPECT_GT(wall["output"].get<double>(), 0.0);
  EXPECT_LE(wall["output"].get<double>(), session_->times().output);
  session_->add_mesh_time(2.5);
  EXPECT_EQ(session_->times().mesh, 2.5);
}

// The same edit at the end of the eleventh step and the end of the run after the twentieth.
class EditAndStop : public Observer {
 public:
  explicit EditAndStop(Session& session) : session_(session) {}
  bool on_step(const Session& session) override {
    if (session.step_number() == 11) session_.apply(SetDamping{{0.0, 0.0, 5.0}});
    return session.step_number() < 20;
  }

 private:
  Session& session_;
};

TEST_F(RunOutput, ARunThatWasEditedHasNoCheckpointsAndAllOtherFiles) {
  session_ = std::make_unique<Session>(scene_, generate_mesh(*scene_.mesh.generate));
  recorder_ = std::make_unique<RunRecorder>(folder_.string(), 5);
  recorder_->keep_checkpoints(4);
  EditAndStop stop(*session_);
  EXPECT_EQ(session_->run({recorder_.get(), &stop}), RunStatus::kCancelled);
  EXPECT_TRUE(recorder_->leaves_out_checkpoints());
  // Those of steps 4 and 8 are gone: a run from there would lack the edit.
  EXPECT_FALSE(fs::exists(folder_ / "checkpoints"));
  EXPECT_TRUE(fs::exists(folder_ / "final.vtu"));
  EXPECT_EQ(nlohmann::json::parse(text("summary.json"))["steps"], 20);
  EXPECT_EQ(csv("history.csv")["step"].back(), "20");
}

}  // namespace
}  // namespace tetraction
