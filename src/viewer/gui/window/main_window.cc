#include "main_window.h"

#include <QAbstractButton>
#include <QAbstractSlider>
#include <QAction>
#include <QApplication>
#include <QCloseEvent>
#include <QComboBox>
#include <QDragEnterEvent>
#include <QFileInfo>
#include <QKeyEvent>
#include <QLabel>
#include <QMimeData>
#include <QSpinBox>
#include <QStatusBar>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <chrono>
#include <utility>

#include "tetraction/core/error.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "viewer/gui/results/comparison.h"
#include "viewer/gui/results/computation.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"
#include "viewer/picked_geometry.h"

namespace tetraction::viewer {
namespace {

constexpr int kPoll_ms = 4;
constexpr int kKeepEdits_ms = 60'000;
constexpr qint64 kPicture_ms = 15;      // at most about 60 pictures per second
constexpr double kWaitForStep_s = 1.0;  // for which closing waits until the step is given up
constexpr qint64 kSlowUpdate_ms = 150;  // interval of the updates of charts, fields and menus

}  // namespace

MainWindow::MainWindow()
    : view_(new BodyView(this)),
      comparison_(new Comparison(view_)),
      messages_(new MessageStrip(view_->canvas())),
      transport_(new TransportBar(this)),
      scene_(new ScenePanels(this)),
      vertex_(new VertexPanel(this)),
      drawing_(new DrawingPanel(this)),
      chart_(new LiveChart(this)),
      status_body_(new QLabel(this)),
      status_measure_(new QLabel(this)),
      status_recording_(new QLabel(this)),
      status_rate_(new QLabel(this)) {
  setAcceptDrops(true);
  qApp->installEventFilter(this);
  auto* center = new QWidget(this);
  auto* column = new QVBoxLayout(center);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(0);
  column->addWidget(comparison_, 1);
  column->addWidget(transport_);
  setCentralWidget(center);
  statusBar()->addWidget(status_body_, 1);
  status_measure_->setObjectName(QStringLiteral("measure"));
  statusBar()->addPermanentWidget(status_measure_);
  status_recording_->setObjectName(QStringLiteral("recording_sign"));
  status_recording_->setForegroundRole(QPalette::BrightText);
  status_recording_->hide();
  statusBar()->addPermanentWidget(status_recording_);
  statusBar()->addPermanentWidget(status_rate_);
  status_rate_->setToolTip(tr("Pictures drawn in a second"));

  make_docks();
  make_results();
  make_actions();
  connect_panels();
  connect_transport();
  connect_view();
  restore_window();
  show_units();
  update_title();

  since_slow_.start();
  since_picture_.start();
  auto* timer = new QTimer(this);
  timer->setTimerType(Qt::PreciseTimer);
  connect(timer, &QTimer::timeout, this, &MainWindow::poll);
  timer->start(kPoll_ms);
  auto* keeping = new QTimer(this);
  connect(keeping, &QTimer::timeout, this, &MainWindow::keep_unsaved_edits);
  keeping->start(kKeepEdits_ms);
}

MainWindow::~MainWindow() {
  hide();  // a field that loses the focus emits its edit, which needs the simulation
}

const TetMesh* MainWindow::mesh() const {
  if (simulation_) return &simulation_->mesh();
  return replay_ ? &replay_->mesh() : nullptr;
}

void MainWindow::select(std::vector<Index> vertices) {
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  selection_ = std::move(vertices);
  if (const TetMesh* body = mesh()) vertex_->set_selection(selection_, *body);
  view_->set_selection(selection_);
  if (const auto state = view_->state()) vertex_->show_state(*state);
  update_actions();
}

void MainWindow::set_drawing(const DrawingSettings& drawing) {
  const bool other_field = drawing.field != view_->drawing().field;
  view_->set_drawing(drawing);
  if (simulation_) simulation_->set_color_field(drawing.field);
  if (replay_ && other_field) show_frame(transport_->frame());
  follow_first_run();
  if (drawing.automatic_range) drawing_->show_range(view_->color_low(), view_->color_high());
}

void MainWindow::show_frame(std::size_t frame) {
  if (!replay_) return;
  try {
    show_snapshot(replay_->frame(frame, view_->drawing().field));
    transport_->show_frame(frame);
    chart_->set_cursor(replay_->times()[frame]);
    chart_->refresh();
  } catch (const Error& error) {
    transport_->play(false);
    show_error(QString::fromUtf8(error.what()));
  }
}

void MainWindow::poll() {
  if (opening() && opening_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    finish_opening();
  }
  // A snapshot is taken only if it will be drawn, because the solver then makes the next one.
  if (simulation_ && since_picture_.elapsed() >= kPicture_ms) {
    const auto snapshot = simulation_->snapshot();
    const bool new_body = snapshot->body != shown_body_;
    if (new_body) {  // the simulation was reset
      const auto act = std::exchange(after_new_body_, {});
      shown_body_ = snapshot->body;
      chart_->clear();
      history_rows_ = 0;
      messages_->clear();
      shown_pause_ = Pause::kNone;
      if (&simulation_->mesh() != shown_mesh_) show_other_mesh();
      chart_->set_probes(chart_probes(simulation_->scene().probe));
      if (act) act();
    }
    if (snapshot->generation != shown_generation_) {
      shown_generation_ = snapshot->generation;
      since_picture_.restart();
      show_snapshot(snapshot);
      if (new_body) view_->fit_if_outside();
    }
  }
  if (since_slow_.elapsed() >= kSlowUpdate_ms) update_slow_parts();
}

void MainWindow::show_snapshot(const std::shared_ptr<const Snapshot>& snapshot) {
  view_->show_state(snapshot);
  follow_first_run();
  view_->render();
  if (!isMinimized()) ++states_shown_;
  show_failure(*snapshot);
  show_pause(*snapshot);
  if (!picture_folder_.isEmpty()) record_picture();
}

// Returns to the start. Tells the user what this loses, with a button that saves the recorded edits.
void MainWindow::restart() {
  if (replay_) transport_->go_to(replay_->times().front());
  if (!simulation_) return;
  std::shared_ptr<const Scene> recorded;
  if (has_unsaved_edits() && simulation_->peek()->step > 0) {
    recorded = std::make_shared<Scene>(simulation_->recorded_scene());
  }
  const QString run = std::exchange(run_folder_, {});
  end_refusal();
  simulation_->restart();
  show_recording();
  if (recorded || !run.isEmpty()) {
    after_new_body_ = [this, run, recorded] { show_loss_by_restart(run, recorded); };
  }
}

void MainWindow::show_loss_by_restart(const QString& run,
                                      const std::shared_ptr<const Scene>& recorded) {
  QStringList sentences;
  if (recorded) {
    sentences +=
        tr("Settings, fixes and forces now hold from the start. The times of the edits are no "
           "longer recorded, and movements and momenta of vertices are undone.");
  }
  if (!run.isEmpty()) sentences += tr("The recording of the run in %1 has ended.").arg(run);
  std::vector<MessageAction> actions;
  if (recorded) {
    actions.push_back(
        {tr("Save the edits as they were…"), [this, recorded] { ask_save_scene(*recorded); }});
    actions.push_back({tr("Undo the restart"), [this] { undo_->trigger(); }});
  }
  messages_->show_message(MessageStrip::Kind::kNote, sentences.join(QLatin1Char(' ')),
                          QStringLiteral("restart"), std::move(actions));
}

// Updates charts, fields and menus, which need fewer updates than the picture.
void MainWindow::update_slow_parts() {
  const auto elapsed = static_cast<double>(since_slow_.restart());
  const std::uint64_t pictures = view_->picture_count();
  if (pictures > pictures_before_ && elapsed > 0.0) {
    // Only pictures of new states count, and only while somebody can see them.
    status_rate_->setText(
        tr("%1 pictures a second")
            .arg(static_cast<double>(states_shown_) * 1000.0 / elapsed, 0, 'f', 0));
  }
  pictures_before_ = pictures;
  states_shown_ = 0;
  if (const auto state = view_->state()) {
    vertex_->show_state(*state);
    show_measure();
    if (drawing_->drawing().automatic_range) {
      drawing_->show_range(view_->color_low(), view_->color_high());
    }
  }
  check_pictures();
  update_transport();
  if (!simulation_) return;
  if (!run_folder_.isEmpty() && !simulation_->observed()) report_end_of_run_recording();

  if (simulation_->history_generation() != shown_history_) {
    shown_history_ = simulation_->history_generation();
    history_rows_ = 0;
    chart_->clear_rows();
  }
  const std::vector<HistoryRow> rows = simulation_->history(history_rows_);
  history_rows_ += rows.size();
  chart_->append(rows);
  chart_->set_marks(simulation_->marks());
  chart_->refresh();

  const Settings settings = simulation_->settings();
  if (const auto state = view_->state()) scene_->update(*state, selection_);
  const bool attraction = settings.environment.kind == EnvironmentKind::kAttraction;
  if (attraction != shown_attraction_) {
    shown_attraction_ = attraction;
    view_->set_attraction(attraction);
    view_->render();  // a paused simulation causes no other picture
  }
  if (simulation_->body() == shown_body_) show_notices();  // a new run clears the messages
  update_actions();
}

// The distance or the angles of two or three selected vertices.
void MainWindow::show_measure() {
  std::vector<std::string> names;
  if (selection_.size() <= 3) {
    for (const Index v : selection_) names.push_back(std::to_string(mesh()->vertex_id(v)));
  }
  status_measure_->setText(
      QString::fromStdString(measure(view_->state()->position, selection_, names)));
}

void MainWindow::update_title() {
  const QString name = path_.isEmpty() ? tr("First scene") : QFileInfo(path_).fileName();
  setWindowTitle(mesh() == nullptr ? tr("Tetraction") : tr("%1 – Tetraction").arg(name));
}

// Gives the widget with the focus the keys that it uses, before they become shortcuts of menus. Escape
// moves the focus from a spin box to the picture.
bool MainWindow::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::KeyPress && qobject_cast<QSpinBox*>(watched) != nullptr &&
      static_cast<QKeyEvent*>(event)->key() == Qt::Key_Escape) {
    view_->canvas()->setFocus(Qt::OtherFocusReason);
    return true;
  }
  if (event->type() != QEvent::ShortcutOverride) return QMainWindow::eventFilter(watched, event);
  const auto* key = static_cast<QKeyEvent*>(event);
  if ((key->modifiers() & (Qt::ControlModifier | Qt::AltModifier)) != 0) return false;
  const bool button = qobject_cast<QAbstractButton*>(watched) != nullptr;
  const bool list = qobject_cast<QComboBox*>(watched) != nullptr;
  const bool slider = qobject_cast<QAbstractSlider*>(watched) != nullptr;
  const bool ends = key->key() == Qt::Key_Home || key->key() == Qt::Key_End;
  if ((key->key() == Qt::Key_Space && (button || list)) || (ends && (list || slider))) {
    event->accept();
    return true;
  }
  return false;
}

void MainWindow::closeEvent(QCloseEvent* event) {
  // A field with the focus enters its number now, so that the number counts as an edit.
  if (QWidget* field = focusWidget()) field->clearFocus();
  if (asks_ && !may_lose_edits()) {
    event->ignore();
    return;
  }
  end_results();
  save_window();
  unsaved_.forget();
  // The window goes away before anything is waited for.
  hide();
  QGuiApplication::sync();
  stop_recording();  // completes the files of the recording
  computation_->end();
  opening_ = {};  // waits for the thread that reads a file
  if (kept_) simulation_ = std::move(kept_->opened.simulation);
  kept_.reset();
  closed_within_step_ = simulation_ && !simulation_->end(kWaitForStep_s);
  if (!closed_within_step_) {
    edits_.reset();
    scene_->set_simulation(nullptr);
    simulation_.reset();
  }
  QMainWindow::closeEvent(event);
}

void MainWindow::close_without_question() {
  asks_ = false;
  close();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QList<QUrl> urls = event->mimeData()->urls();
  if (!urls.isEmpty() && urls.front().isLocalFile()) {
    event->acceptProposedAction();
    open(urls.front().toLocalFile());
  }
}

}  // namespace tetraction::viewer
