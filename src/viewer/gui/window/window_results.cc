// Equilibria, natural modes and studies: commands that the window starts, and what it shows of their results.
#include <QAction>
#include <QCoreApplication>
#include <QDir>
#include <QDockWidget>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QMenu>
#include <QMenuBar>
#include <QPushButton>
#include <QSpinBox>
#include <QStatusBar>
#include <QTabWidget>
#include <algorithm>
#include <utility>

#include "main_window.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/io/scene_writer.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/results/comparison.h"
#include "viewer/gui/results/computation.h"
#include "viewer/gui/results/computation_dialog.h"
#include "viewer/gui/results/results_panel.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"

namespace tetraction::viewer {
namespace {

const QString kComputation = QStringLiteral("computation");

std::string file_name(const QString& path) {
  return path.toLocal8Bit().toStdString();
}

}  // namespace

void MainWindow::make_compute_menu() {
  QMenu* menu = menuBar()->addMenu(tr("&Compute"));
  const auto add = [&](const QString& text, const QString& tip, ComputationKind kind,
                       const char* shortcut) {
    QAction* action = menu->addAction(
        text, this, [this, kind] { ask_computation(kind); }, QKeySequence(tr(shortcut)));
    action->setStatusTip(tip);
    compute_.push_back(action);
  };
  add(tr("&Equilibrium…"), tr("Of the scene with all edits, under its loads at t = 0"),
      ComputationKind::kEquilibrium, "Ctrl+Alt+E");
  add(tr("Natural &modes…"), tr("Of the scene with all edits; each of them is shown as it swings"),
      ComputationKind::kModes, "Ctrl+Alt+N");
  add(tr("&Study…"), tr("Compares integrators and time steps on the scene with all edits"),
      ComputationKind::kStudy, "Ctrl+Alt+S");
  menu->addSeparator();
  cancel_computation_ = menu->addAction(tr("&Cancel"), computation_, &Computation::cancel,
                                        QKeySequence(tr("Ctrl+Alt+X")));
  cancel_computation_->setObjectName(QStringLiteral("cancel_computation"));
  back_to_simulation_ =
      menu->addAction(tr("&Back to the simulation"), this, &MainWindow::back_to_simulation,
                      QKeySequence(tr("Ctrl+Alt+B")));
  back_to_simulation_->setStatusTip(tr("It was paused when the results were opened"));
}

// The table of results, and the sign of a computation in the status bar.
void MainWindow::make_results() {
  auto* dock = findChild<QDockWidget*>(QStringLiteral("dock_charts"));
  charts_and_results_ = new QTabWidget(dock);
  // The Tab key would stop at a row of tabs that is hidden.
  charts_and_results_->setFocusProxy(nullptr);
  charts_and_results_->setFocusPolicy(Qt::NoFocus);
  charts_and_results_->setDocumentMode(true);
  charts_and_results_->setTabBarAutoHide(true);
  charts_and_results_->setTabPosition(QTabWidget::South);
  charts_and_results_->addTab(chart_, tr("Charts"));
  dock->setWidget(charts_and_results_);
  results_ = new ResultsPanel(this);
  results_->hide();
  for (QPushButton* button : results_->findChildren<QPushButton*>()) {
    button->setFocusPolicy(Qt::TabFocus);
  }
  auto* amplitude = results_->findChild<QSpinBox*>();
  connect(amplitude, &QSpinBox::editingFinished, this, [this, amplitude] {
    if (amplitude->hasFocus()) view_->canvas()->setFocus(Qt::OtherFocusReason);
  });
  connect(results_, &ResultsPanel::run_wanted, this,
          [this](const QString& run) { open_result(run); });
  connect(results_, &ResultsPanel::comparison_wanted, this, &MainWindow::open_result);
  connect(results_, &ResultsPanel::mode_wanted, this, &MainWindow::show_mode);
  connect(results_, &ResultsPanel::amplitude_changed, this, [this](double part) {
    if (!replay_ || replay_->motion() == nullptr) return;
    replay_->motion()->amplitude = part;
    show_frame(transport_->frame());
  });
  connect(drawing_, &DrawingPanel::refit_wanted, this, &MainWindow::follow_first_run,
          Qt::QueuedConnection);

  computation_ = new Computation(this);
  auto* sign = new QWidget(this);
  auto* row = new QHBoxLayout(sign);
  row->setContentsMargins(0, 0, 0, 0);
  auto* text = new QLabel(sign);
  text->setObjectName(QStringLiteral("computation_text"));
  auto* cancel = new QPushButton(tr("Cancel"), sign);
  cancel->setMaximumHeight(text->fontMetrics().height());  // the status bar stays as high as a text
  cancel->setObjectName(QStringLiteral("computation_cancel"));
  cancel->setFocusPolicy(Qt::TabFocus);
  row->addWidget(text);
  row->addWidget(cancel);
  statusBar()->addPermanentWidget(sign);
  sign->hide();
  connect(cancel, &QPushButton::clicked, computation_, &Computation::cancel);
  connect(computation_, &Computation::progressed, sign, [sign, text](const QString& progress) {
    text->setText(progress);
    sign->show();
  });
  connect(computation_, &Computation::ended, sign, &QWidget::hide);
  connect(computation_, &Computation::ended, this, &MainWindow::end_computation);
}

void MainWindow::update_results_actions() {
  const bool computes = computation_->is_running();
  for (QAction* action : compute_) action->setEnabled(!computes && (simulation_ || kept_));
  cancel_computation_->setEnabled(computes);
  back_to_simulation_->setEnabled(kept_.has_value());
  compare_->setEnabled(replay_ && replay_->kind() != RunKind::kMode);
}

// Writes the scene with all edits to the folder of the results, and starts the command with it.
void MainWindow::ask_computation(ComputationKind kind) {
  const Simulation* simulation = kept_ ? kept_->opened.simulation.get() : simulation_.get();
  if (simulation == nullptr || computation_->is_running()) return;
  const QFileInfo own(kept_ ? kept_->path : path_);
  const bool has_place = own.isFile() && QFileInfo(own.absolutePath()).isWritable();
  const QString proposed =
      has_place ? own.absoluteDir().filePath(own.completeBaseName())
                : QDir::temp().filePath(
                      QStringLiteral("tetraction_%1").arg(QCoreApplication::applicationPid()));
  try {
    Scene scene = scene_with_edits(*simulation);
    const auto request = viewer::ask_computation(this, kind, proposed, scene.time.end);
    if (!request) return;
    const QString directory = QFileInfo(request->directory).absoluteFilePath();
    const QString path = QDir(directory).filePath(QStringLiteral("scene_of_window.toml"));
    // What is needed to draw the result.
    if (kind == ComputationKind::kEquilibrium) scene.output.every = 1;
    std::vector<std::string>& fields = scene.output.fields;
    if (!fields.empty() && std::ranges::find(fields, kDefaultFields) == fields.end() &&
        std::ranges::find(fields, "displacement") == fields.end()) {
      fields.emplace_back("displacement");
    }
    if (!QDir().mkpath(directory)) {
      throw OutputError(file_name(directory) + ": cannot be made. Choose another folder.");
    }
    write_scene(scene, file_name(path));
    messages_->end(kComputation);
    computation_->start(
        request->arguments + QStringList{path, "--out=" + directory,
                                         QStringLiteral("--threads=%1").arg(thread_count())},
        directory);
  } catch (const Error& error) {
    show_error(QString::fromUtf8(error.what()));
  }
  update_actions();
}

void MainWindow::end_computation(const QString& failure, bool was_cancelled) {
  const QString directory = computation_->directory();
  const MessageAction open{tr("Open the results"), [this, directory] {
                             end_results();
                             open_result(directory);
                           }};
  if (was_cancelled) {
    statusBar()->showMessage(tr("Cancelled. What is complete is in %1.").arg(directory), 8000);
  } else if (!failure.isEmpty()) {
    std::vector<MessageAction> actions;
    if (QFileInfo::exists(QDir(directory).filePath(QStringLiteral("frames.pvd")))) {
      actions.push_back(open);
    }
    messages_->show_message(MessageStrip::Kind::kError, failure, kComputation, std::move(actions));
  } else if (opening()) {
    messages_->show_message(MessageStrip::Kind::kNote,
                            tr("The results in %1 are complete.").arg(directory), kComputation,
                            {open});
  } else {
    open.act();
  }
  update_actions();
}

// Shows a result, or two of them side by side. The simulation is kept meanwhile.
void MainWindow::open_result(const QString& path, const QString& second) {
  if (opening()) return;
  opens_result_ = true;
  begin_opening(path, second.isEmpty() ? std::async(std::launch::async, open_file, file_name(path),
                                                    std::optional<double>())
                                       : std::async(std::launch::async, open_pair, file_name(path),
                                                    file_name(second)));
}

// Shows what was opened beside a replay.
void MainWindow::show_results(Opened& opened, const QString& path, bool has_replay) {
  if (opened.runs) {
    end_results();
    results_->show_runs(*opened.runs, path);
    if (!has_replay) {
      messages_->show_message(MessageStrip::Kind::kNote,
                              tr("No run of this study has frames that can be shown. Compute → "
                                 "Study writes them, and so "
                                 "does tetraction study --frames all."),
                              QStringLiteral("study"));
    }
  }
  if (opened.modes) {
    modes_ = opened.modes;
    results_->show_modes(grid_of_modes(modes_->modes()), path);
    field_before_modes_ = drawing_->drawing().field;
    drawing_->color_by(find_quantity("displacement"));
  }
  if (opened.runs || opened.modes) {
    findChild<QDockWidget*>(QStringLiteral("dock_charts"))->show();
    charts_and_results_->addTab(results_, tr("Results"));
    charts_and_results_->setCurrentWidget(results_);
  }
  if (opened.modes) results_->choose(0);
  if (path == computation_->directory()) {
    for (const QString& warning : computation_->warnings()) {
      messages_->show_message(MessageStrip::Kind::kWarning,
                              QString::fromStdString(sentence(warning.toStdString())), warning);
    }
  }
  if (opened.other) {
    std::vector<HistoryRow> rows = opened.other->history();
    if (opened.other->probes() != replay_->probes()) {
      for (HistoryRow& row : rows) row.probes.clear();
    }
    chart_->set_other_rows(std::move(rows));
    comparison_->begin(QDir(QString::fromStdString(replay_->directory())).dirName(),
                       std::move(opened.other), std::move(opened.other_shape));
    show_frame(transport_->frame());
  }
}

void MainWindow::show_mode(int mode) {
  try {
    ModeMotion motion = modes_->motion(static_cast<std::size_t>(mode));
    motion.amplitude = replay_->motion()->amplitude;
    *replay_->motion() = std::move(motion);
    show_frame(transport_->frame());
    view_->refit_colors();
    transport_->play(true);
  } catch (const Error& error) {
    transport_->play(false);
    show_error(QString::fromUtf8(error.what()));
  }
}

// Removes the table of results that are no longer shown.
void MainWindow::end_results() {
  modes_.reset();
  results_->clear();
  charts_and_results_->removeTab(charts_and_results_->indexOf(results_));
  if (const auto field = std::exchange(field_before_modes_, {})) drawing_->color_by(*field);
}

// The second of two runs shows what the first one does.
void MainWindow::follow_first_run() {
  try {
    comparison_->follow();
  } catch (const Error& error) {
    show_error(QString::fromUtf8(error.what()));
  }
}

// Pauses the simulation, so that a result can be shown in its place.
void MainWindow::keep_simulation() {
  if (!simulation_) return;
  edits_->release();
  simulation_->pause();
  stop_recording();
  kept_ = Kept{{}, path_, saved_edits_, transport_->speed()};
  kept_->opened.off = scene_->off();
  kept_->opened.mesh_scale = mesh_scale_;
  edits_.reset();
  scene_->set_simulation(nullptr);
  kept_->opened.simulation = std::move(simulation_);
  statusBar()->showMessage(
      tr("The simulation is paused. Compute → Back to the simulation goes on with it."), 8000);
}

void MainWindow::back_to_simulation() {
  if (!kept_) return;
  Kept kept = std::move(*kept_);
  kept.opened.shape = make_body_shape(kept.opened.simulation->mesh());
  const std::optional<double> scale = kept.opened.mesh_scale;
  show_simulation(std::move(kept.opened));
  transport_->set_speed(kept.speed);
  path_ = kept.path;
  mesh_scale_ = scale;
  saved_edits_ = kept.saved_edits;
  kept_edits_ = simulation_->edit_count() + 1;  // so that they are kept again
  update_title();
  update_actions();
}

}  // namespace tetraction::viewer
