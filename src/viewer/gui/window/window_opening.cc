// Opens files and shows them in the window.
#include <QAction>
#include <QFileInfo>
#include <QInputDialog>
#include <QLabel>
#include <QMessageBox>
#include <QStatusBar>
#include <cmath>
#include <future>
#include <utility>

#include "main_window.h"
#include "opened_file.h"
#include "viewer/display_units.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "viewer/gui/results/comparison.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"

namespace tetraction::viewer {
namespace {

// The size of a mesh, such as "1.2 × 0.3 × 0.3 m". It shows the user whether the unit is right.
QString size_text(const TetMesh& mesh) {
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3& x : mesh.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const DisplayUnit unit = display_unit("m");
  const auto n = [&](int axis) {
    return QString::number(unit.from_si(high[axis] - low[axis]), 'g', 4);
  };
  return QStringLiteral("%1 × %2 × %3 %4").arg(n(0), n(1), n(2), QString::fromStdString(unit.text));
}

}  // namespace

void MainWindow::open(const QString& path, std::optional<double> scale) {
  if (opening()) {
    messages_->show_message(MessageStrip::Kind::kWarning,
                            tr("%1 is still being read.").arg(opening_path_));
  } else if (may_lose_edits()) {
    begin_opening(
        path, std::async(std::launch::async, open_file, path.toLocal8Bit().toStdString(), scale));
  }
}

void MainWindow::begin_opening(const QString& path, std::future<Opened> reading) {
  opening_path_ = path;
  opening_ = std::move(reading);
  statusBar()->showMessage(tr("Reading %1…").arg(path));
}

void MainWindow::open_from_start(const QString& path, std::future<Opened> reading) {
  needs_file_ = true;
  begin_opening(path, std::move(reading));
}

void MainWindow::finish_opening() {
  const QString path = opening_path_;
  const bool needed = std::exchange(needs_file_, false);
  const std::shared_ptr<UnsavedScene> restoring = std::exchange(restoring_, nullptr);
  statusBar()->clearMessage();
  try {
    Opened opened = opening_.get();
    const std::optional<double> mesh_scale = opened.mesh_scale;
    const std::optional<Scene> restored = std::move(opened.restored);
    const bool has_body = opened.replay || opened.simulation;
    if (opened.replay) {
      if (opens_result_) keep_simulation();
      show_replay(std::move(opened.replay), std::move(opened.shape));
    } else if (opened.simulation) {
      show_simulation(std::move(opened));
    }
    if (has_body) {
      path_ = restored ? restoring->document : path;
      mesh_scale_ = mesh_scale;
    }
    if (restored) {
      show_restored(*restored, restoring);
    } else {
      show_results(opened, path, has_body);
      if (mesh_scale) show_mesh_message();
      remember_file(QFileInfo(path).absoluteFilePath());
    }
    update_title();
    if (needed) offer_unsaved_edits();
  } catch (const std::exception& error) {
    show_error(QString::fromUtf8(error.what()));
    if (needed) emit could_not_open(std::current_exception());
  }
  opens_result_ = false;
  update_actions();
}

// All edits are one entry of Undo. Those at the start hold at once. None of them is saved.
void MainWindow::show_restored(const Scene& scene, const std::shared_ptr<UnsavedScene>& unsaved) {
  simulation_->set_up(scene, tr("edits from before the crash").toStdString());
  simulation_->make_due_events();
  after_new_body_ = [this, unsaved] {
    keep_unsaved_edits();
    unsaved->discard();
  };
}

// Tells the user the size and the default material of a mesh that was opened without a scene.
void MainWindow::show_mesh_message() {
  QString text = tr("%1 is %2 large").arg(QFileInfo(path_).fileName(), size_text(*mesh()));
  if (*mesh_scale_ != 1.0) text += tr(", scaled by %1").arg(*mesh_scale_);
  text +=
      tr(". It is of rubber (1 MPa), free and without gravity: to hold it, select vertices and "
         "press F; the tree of the scene has the rest. If its unit is not the metre, scale it.");
  messages_->show_message(MessageStrip::Kind::kNote, text, QStringLiteral("mesh"),
                          {{tr("Scale…"), [this] { ask_scale(); }}});
}

void MainWindow::ask_scale() {
  const QStringList usual{tr("0.001 (millimetres)"), tr("0.01 (centimetres)"),
                          tr("0.0254 (inches)"), tr("1 (metres)")};
  bool accepted = false;
  const QString answer =
      QInputDialog::getItem(this, tr("Scale of the mesh"),
                            tr("Number that turns the coordinates of %1 into metres; the mesh is "
                               "read again, at rest:")
                                .arg(QFileInfo(path_).fileName()),
                            usual, 0, true, &accepted);
  if (!accepted) return;
  bool is_number = false;
  QString number = answer.section(QLatin1Char('('), 0, 0).trimmed();
  const double scale = number.replace(QLatin1Char(','), QLatin1Char('.')).toDouble(&is_number);
  if (!is_number || !std::isfinite(scale) || !(scale > 0.0)) {
    messages_->show_message(MessageStrip::Kind::kWarning,
                            tr("Scale: “%1” is not possible; allowed: above 0.").arg(answer),
                            QStringLiteral("input"), {{tr("Scale…"), [this] { ask_scale(); }}});
    return;
  }
  open(path_, scale);
}

bool MainWindow::has_unsaved_edits() const {
  return simulation_ && simulation_->edited_since(saved_edits_);
}

// Asks the user what to do with edits that are not saved. Returns false if the user does not want to
// lose them and has not saved them.
bool MainWindow::may_lose_edits() {
  if (kept_ && kept_->opened.simulation->edited_since(kept_->saved_edits)) back_to_simulation();
  if (!has_unsaved_edits()) return true;
  const QString last = QString::fromStdString(simulation_->undo_text());
  QMessageBox box(
      QMessageBox::Question, tr("Save the edits?"),
      tr("Edits made by hand%1 are not saved. “Save” writes the scene with all edits as "
         "events.")
          .arg(last.isEmpty() ? QString() : tr(", the last of them “%1”,").arg(last)),
      QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, this);
  box.setDefaultButton(QMessageBox::Save);
  const int answer = box.exec();
  return answer == QMessageBox::Discard || (answer == QMessageBox::Save && ask_save_scene());
}

void MainWindow::reload() {
  if (opening()) return;
  if (!path_.isEmpty()) {
    open(path_, mesh_scale_);
  } else if (simulation_ && may_lose_edits()) {
    edits_->release();  // ends a drag, because its vertices do not exist after the reload
    simulation_->reset();
    unsaved_.forget();
  }
}

void MainWindow::show_replay(std::unique_ptr<Replay> replay,
                             std::shared_ptr<const BodyShape> shape) {
  if (!opens_result_) end_results();
  edits_.reset();
  scene_->set_simulation(nullptr);
  simulation_.reset();
  forget_edits();
  mesh_scale_.reset();
  replay_ = std::move(replay);
  begin_body(replay_->mesh(), std::move(shape));
  transport_->begin_replay(replay_->times(), replay_->kind());
  const bool is_mode = replay_->kind() == RunKind::kMode;  // without a chart
  chart_->set_probes(replay_->probes(), is_mode ? RunKind::kMotion : replay_->kind());
  chart_->append(replay_->history());
  show_frame(0);
}

// The edits of the document before are saved, or the user does not want them.
void MainWindow::forget_edits() {
  saved_edits_ = kept_edits_ = 0;
  unsaved_.forget();
}

void MainWindow::show_document(Document document) {
  show_simulation(set_up(std::move(document)));
}

void MainWindow::show_simulation(Opened opened) {
  end_results();
  edits_.reset();
  scene_->set_simulation(nullptr);
  replay_.reset();
  kept_.reset();
  simulation_ = std::move(opened.simulation);
  edits_ = std::make_unique<VertexEdits>(*simulation_);
  forget_edits();
  path_.clear();
  mesh_scale_.reset();
  transport_->begin_simulation();
  const Scene& scene = simulation_->scene();
  const Settings settings = simulation_->settings();
  vertex_->suggest_arrows(simulation_->mesh(), settings.moduli.front().least,
                          settings.mean_density);
  simulation_->set_color_field(drawing_->drawing().field);
  simulation_->set_steps_per_snapshot(transport_->steps_per_picture());
  simulation_->set_speed_limit(transport_->speed());
  simulation_->set_pauses(true, true);
  begin_body(simulation_->mesh(), std::move(opened.shape));
  chart_->set_probes(chart_probes(scene.probe));
  shown_body_ = simulation_->peek()->body;
  scene_->set_simulation(simulation_.get(), std::move(opened.off));
  if (!record_from_start_.isEmpty()) {
    record_run(std::exchange(record_from_start_, {}), static_cast<int>(scene.output.every));
  }
  update_title();
  update_actions();
  poll();
  update_slow_parts();
}

// The mesh of the scene was changed.
void MainWindow::show_other_mesh() {
  begin_body(simulation_->mesh(), make_body_shape(simulation_->mesh()));
}

void MainWindow::begin_body(const TetMesh& mesh, std::shared_ptr<const BodyShape> shape) {
  shown_mesh_ = &mesh;
  messages_->clear();
  shown_pause_ = Pause::kNone;
  edit_warnings_.clear();
  after_new_body_ = {};
  stop_recording();  // may show a message
  comparison_->begin({}, nullptr, nullptr);
  chart_->clear();
  chart_->set_body_size((shape->high - shape->low).norm());
  shown_generation_ = 0;
  shown_history_ = 0;
  history_rows_ = 0;
  failed_ = false;
  go_back_->setEnabled(false);
  shown_attraction_ = false;
  view_->set_attraction(false);
  view_->set_body(std::move(shape));
  show_size();
  select({});
}

void MainWindow::show_size() {
  if (shown_mesh_ == nullptr) return;
  status_body_->setText(tr("%1 vertices, %2 tetrahedra, %3")
                            .arg(static_cast<qlonglong>(shown_mesh_->vertex_count()))
                            .arg(static_cast<qlonglong>(shown_mesh_->tetrahedron_count()))
                            .arg(size_text(*shown_mesh_)));
}

}  // namespace tetraction::viewer
