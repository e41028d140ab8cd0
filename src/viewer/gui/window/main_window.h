// The main window. It turns the user's actions into calls of the simulation and shows the results.
#pragma once

#include <QElapsedTimer>
#include <QMainWindow>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "message_strip.h"
#include "opened_file.h"
#include "unsaved_edits.h"
#include "viewer/gui/body/drawing_settings.h"
#include "viewer/gui/panels/vertex_edits.h"
#include "viewer/simulation.h"

class QLabel;
class QStackedWidget;
class QTabWidget;

namespace tetraction::viewer {

class BodyView;
class Comparison;
class Computation;
class DrawingPanel;
class LiveChart;
class ResultsPanel;
struct PictureQueue;
class ScenePanels;
class TransportBar;
class VertexPanel;
enum class ComputationKind;
enum class Tool;

class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  MainWindow();
  ~MainWindow() override;

  /// Opens a scene, a mesh, or the directory of a run, a study or natural modes, depending on the path. `scale` multiplies the
  /// coordinates of a mesh. The file is read in another thread. If it cannot be opened, a message
  /// appears and the window keeps its contents. If there are edits that are not saved, the user is
  /// asked first.
  void open(const QString& path, std::optional<double> scale = {});
  /// Shows the file of the command line when `reading` is done. If it cannot be read,
  /// could_not_open() is emitted.
  void open_from_start(const QString& path, std::future<Opened> reading);
  /// Whether a file is being read.
  bool opening() const { return opening_.valid(); }
  /// Shows a document. Throws InputError.
  void show_document(Document document);

  /// Closes the window; edits that are not saved are lost.
  void close_without_question();
  /// Whether the window was closed in a step that could not be given up soon. The recording is complete
  /// then. The program should end without the destructor, which waits for the solver.
  bool closed_within_step() const { return closed_within_step_; }

  /// Null while a run is replayed or nothing is open.
  Simulation* simulation() { return simulation_.get(); }
  const Replay* replay() const { return replay_.get(); }
  BodyView* body_view() { return view_; }
  Comparison* comparison() { return comparison_; }
  ResultsPanel* results() { return results_; }
  LiveChart* chart() { return chart_; }
  ScenePanels* scene_panels() { return scene_; }
  TransportBar* transport() { return transport_; }
  MessageStrip* messages() { return messages_; }
  const std::vector<Index>& selection() const { return selection_; }
  void select(std::vector<Index> vertices);
  /// Saves a scene with all edits so far as events. If this fails, there is a message, and the result is
  /// false.
  bool save_scene(const QString& path);
  /// Writes edits that are not saved to a file that outlives a crash. A timer calls it every minute.
  void keep_unsaved_edits();
  /// Offers the edits that windows have left in such files when they crashed.
  void offer_unsaved_edits();
  /// Starts to save every picture as a PNG file. The folder is made if it does not exist. It must not
  /// contain pictures of an earlier recording. If `path` ends with .webm or .mp4, ffmpeg makes a film of the
  /// pictures. An empty size is that of the view.
  void record_pictures(const QString& path, const QSize& size = {});
  /// Starts to write all files that `tetraction run` would write, with a frame every `frame_every`
  /// steps.
  void record_run(const QString& folder, int frame_every);
  /// Records the next simulation in this folder, with a frame after each output.every steps of its scene.
  void record_from_start(const QString& folder) { record_from_start_ = folder; }
  /// Ends either recording.
  void stop_recording();
  /// Shows the latest state of the simulation. The timer calls it.
  void poll();

 signals:
  void could_not_open(const std::exception_ptr& problem);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  // window_parts.cc
  void make_docks();
  void connect_panels();
  void connect_view();

  // window_transport.cc
  void connect_transport();
  void update_transport();
  void show_running(bool running);

  // window_results.cc
  void make_compute_menu();
  void make_results();
  void update_results_actions();
  void ask_computation(ComputationKind kind);
  void end_computation(const QString& failure, bool was_cancelled);
  void open_result(const QString& path, const QString& second = {});
  void show_results(Opened& opened, const QString& path, bool has_replay);
  void show_mode(int mode);
  void end_results();
  void follow_first_run();
  void keep_simulation();
  void back_to_simulation();

  // window_opening.cc
  void finish_opening();
  void show_simulation(Opened opened);
  void show_replay(std::unique_ptr<Replay> replay, std::shared_ptr<const BodyShape> shape);
  void begin_body(const TetMesh& mesh, std::shared_ptr<const BodyShape> shape);
  void show_restored(const Scene& scene, const std::shared_ptr<UnsavedScene>& unsaved);
  void forget_edits();
  void show_mesh_message();
  void show_other_mesh();
  void show_size();
  void ask_scale();
  bool has_unsaved_edits() const;
  void name_selection();
  void probe_selection();
  bool may_lose_edits();
  void offer(const std::shared_ptr<UnsavedScene>& unsaved);
  void restore(const std::shared_ptr<UnsavedScene>& unsaved);
  void begin_opening(const QString& path, std::future<Opened> reading);
  void reload();

  // main_window.cc
  void show_frame(std::size_t frame);
  void show_snapshot(const std::shared_ptr<const Snapshot>& snapshot);
  void update_slow_parts();
  void show_measure();
  void restart();
  void show_loss_by_restart(const QString& run, const std::shared_ptr<const Scene>& recorded);
  void set_drawing(const DrawingSettings& drawing);
  void update_title();
  const TetMesh* mesh() const;

  // window_messages.cc
  void answer(TimeSettings time, const QString& what);
  MessageAction half_step();
  MessageAction other_rule(Integrator rule);
  MessageAction before_last_edit();
  void show_failure(const Snapshot& snapshot);
  void show_pause(const Snapshot& snapshot);
  void leave_failure();
  void show_notices();
  void show_refusal(const QString& message);
  void end_refusal();

  // window_actions.cc
  void make_actions();
  void make_file_menu();
  void make_edit_menu();
  void make_simulation_menu();
  void make_view_menu();
  void make_help_menu();
  void make_tools();
  void update_actions();
  void update_recent_files();
  void remember_file(const QString& path);
  void show_keys();
  static QSize first_size();
  void restore_window();
  void save_window() const;

  // window_looks.cc
  void make_theme_menu();
  void make_units_menu();
  void show_units();
  void reset_layout();
  void show_about();
  void add_documents(QMenu* help);
  void fill_groups(QMenu* menu);

  // window_recording.cc
  bool ask_save_scene();
  bool ask_save_scene(const Scene& scene);
  bool write(const Scene& scene, const QString& path);
  void ask_save_screenshot();
  void ask_record_pictures(bool on);
  void ask_record_film();
  void ask_record_run(bool on);
  void stop_pictures();
  void check_pictures();
  void report_end_of_run_recording();
  void show_recording();
  void record_picture();
  void show_error(const QString& message);

  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<VertexEdits> edits_;
  std::unique_ptr<Replay> replay_;
  QString path_;
  QByteArray first_layout_;           // of the panels of a new window
  std::optional<double> mesh_scale_;  // of the mesh, if it was opened without a scene
  QString opening_path_;
  std::future<Opened> opening_;  // valid while a file is read
  bool opens_result_ = false;    // whether it is one of the table, or of a computation
  bool needs_file_ = false;      // whether the window has nothing else to show
  std::vector<Index> selection_;
  std::size_t saved_edits_ = 0;  // Simulation::edit_count() of the saved scene
  UnsavedEdits unsaved_;
  std::size_t kept_edits_ = 0;               // Simulation::edit_count() of that file
  std::shared_ptr<UnsavedScene> restoring_;  // that is being read
  std::function<void()> after_new_body_;     // what to do when the simulation has been reset

  // The data that were shown last.
  std::uint64_t shown_generation_ = 0;
  std::uint64_t shown_body_ = 0;
  const TetMesh* shown_mesh_ = nullptr;
  std::size_t shown_history_ = 0;
  std::size_t history_rows_ = 0;
  bool failed_ = false;
  Pause shown_pause_ = Pause::kNone;
  std::vector<QString> edit_warnings_;  // causes of messages
  bool closed_within_step_ = false;
  bool shown_attraction_ = false;
  QElapsedTimer since_slow_, since_picture_;
  std::uint64_t pictures_before_ = 0;
  int states_shown_ = 0;    // since the last update of the rate
  QString picture_folder_;  // or the file of a film; empty if pictures are not recorded
  std::size_t pictures_recorded_ = 0;
  double picture_interval_ = 0.0;  // of a recording, simulated s
  double next_picture_ = -1.0;     // number of the interval of the last one
  std::shared_ptr<PictureQueue> picture_queue_;
  QString run_folder_;  // empty if the run is not recorded
  QString record_from_start_;
  bool asks_ = true;  // before edits are lost

  struct Kept {
    Opened opened;
    QString path;
    std::size_t saved_edits = 0;
    double speed = 1.0;
  };
  std::optional<Kept> kept_;  // the simulation while its results are shown
  std::shared_ptr<const StoredModes> modes_;
  std::optional<ColorField> field_before_modes_;

  BodyView* view_;
  Comparison* comparison_;
  QTabWidget* charts_and_results_ = nullptr;
  ResultsPanel* results_ = nullptr;
  Computation* computation_ = nullptr;
  MessageStrip* messages_;
  TransportBar* transport_;
  ScenePanels* scene_;
  VertexPanel* vertex_;
  DrawingPanel* drawing_;
  LiveChart* chart_;
  QLabel *status_body_, *status_measure_, *status_recording_, *status_rate_;
  std::vector<QStackedWidget*> live_pages_;  // panels of a simulation, and a text for a replay

  QMenu *view_menu_, *recent_, *picture_menu_;
  QAction *undo_, *redo_, *fix_, *unfix_, *name_, *probe_, *run_, *step_, *restart_, *reload_,
      *go_back_, *back_, *continue_, *compare_, *back_to_simulation_, *cancel_computation_, *scale_,
      *save_scene_, *record_pictures_, *record_film_, *record_run_;
  std::vector<QAction*> compute_;
  std::vector<QAction*> live_only_;  // actions that need a simulation
};

}  // namespace tetraction::viewer
