// What is opened, and what the window shows of it first.
#include <QFileInfo>
#include <QLabel>
#include <QStatusBar>
#include <algorithm>
#include <utility>

#include "body_shape.h"
#include "body_view.h"
#include "control_panel.h"
#include "drawing_panel.h"
#include "live_chart.h"
#include "main_window.h"
#include "replay_bar.h"
#include "vertex_panel.h"

namespace tetraction::viewer {
namespace {

Opened set_up(Document document) {
  Opened opened;
  opened.simulation =
      std::make_unique<Simulation>(std::move(document.scene), std::move(document.mesh));
  opened.shape = make_body_shape(opened.simulation->mesh());
  return opened;
}

// All that takes its time with a large mesh; in a thread of its own.
Opened read_file(const std::string& file) {
  const DocumentKind kind = kind_of(file);
  if (kind != DocumentKind::kRun) {
    return set_up(kind == DocumentKind::kScene ? open_scene(file) : open_mesh(file));
  }
  Opened opened;
  opened.replay = std::make_unique<Replay>(file);
  opened.replay->frame(0, ColorField::kNone);  // what cannot be drawn is told of before it is shown
  opened.shape = make_body_shape(opened.replay->mesh());
  return opened;
}

}  // namespace

void MainWindow::open(const QString& path) {
  if (opening()) {
    messages_->show_message(MessageStrip::Kind::kWarning,
                            tr("%1 is still being read.").arg(opening_path_));
    return;
  }
  opening_path_ = path;
  opening_ = std::async(std::launch::async, read_file, path.toLocal8Bit().toStdString());
  statusBar()->showMessage(tr("Reading %1…").arg(path));
}

void MainWindow::finish_opening() {
  const QString path = opening_path_;
  statusBar()->clearMessage();
  try {
    Opened opened = opening_.get();
    if (opened.replay) {
      show_replay(std::move(opened.replay), std::move(opened.shape));
    } else {
      show_simulation(std::move(opened.simulation), std::move(opened.shape));
    }
    path_ = path;
    remember_file(QFileInfo(path).absoluteFilePath());
    update_title();
  } catch (const std::exception& error) {
    tell_error(QString::fromUtf8(error.what()));
  }
  update_actions();
}

void MainWindow::show_replay(std::unique_ptr<Replay> replay,
                             std::shared_ptr<const BodyShape> shape) {
  edits_.reset();
  simulation_.reset();
  replay_ = std::move(replay);
  begin_body(replay_->mesh(), std::move(shape));
  replay_bar_->set_times(replay_->times());
  replay_bar_->show();
  chart_->append(replay_->history());
  show_frame(0);
}

void MainWindow::show_document(Document document) {
  Opened opened = set_up(std::move(document));
  show_simulation(std::move(opened.simulation), std::move(opened.shape));
}

void MainWindow::show_simulation(std::unique_ptr<Simulation> simulation,
                                 std::shared_ptr<const BodyShape> shape) {
  edits_.reset();
  replay_.reset();
  simulation_ = std::move(simulation);
  edits_ = std::make_unique<VertexEdits>(*simulation_);
  path_.clear();
  replay_bar_->play(false);
  replay_bar_->hide();
  const Scene& scene = simulation_->scene();
  vertex_->suggest_arrows(simulation_->mesh(), make_material(scene.material),
                          scene.material.density);
  simulation_->set_color_field(drawing_->drawing().field);
  simulation_->set_steps_per_snapshot(control_->steps_a_picture());
  simulation_->set_speed_limit(control_->speed_limit());
  begin_body(simulation_->mesh(), std::move(shape));
  shown_body_ = simulation_->snapshot()->body;
  update_title();
  update_actions();
  poll();
  show_slow_things();
}

void MainWindow::begin_body(const TetMesh& mesh, std::shared_ptr<const BodyShape> shape) {
  messages_->hide();
  stop_recording();  // may have something to tell
  chart_->clear();
  shown_generation_ = 0;
  shown_history_ = 0;
  history_rows_ = 0;
  failure_told_ = false;
  shown_attraction_ = false;
  view_->set_attraction(false);
  view_->set_body(std::move(shape));
  status_body_->setText(tr("%1 vertices, %2 tetrahedra")
                            .arg(static_cast<qlonglong>(mesh.vertex_count()))
                            .arg(static_cast<qlonglong>(mesh.tetrahedron_count())));
  select({});
}

}  // namespace tetraction::viewer
