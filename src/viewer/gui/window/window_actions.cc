// Menus, shortcuts and tools, and the settings that are stored for the next start of the program.
#include <QAction>
#include <QActionGroup>
#include <QApplication>
#include <QDockWidget>
#include <QFileDialog>
#include <QFileInfo>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QScreen>
#include <QSettings>
#include <QStackedWidget>
#include <QStatusBar>
#include <QStyle>
#include <QTimer>
#include <QToolBar>
#include <algorithm>

#include "main_window.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"
#include "viewer/gui/widgets/icons.h"
#include "viewer/gui/widgets/theme.h"

namespace tetraction::viewer {
namespace {

constexpr int kRecentFiles = 8;
constexpr int kTreeWidth = 200;       // of a new window, pixels
constexpr int kInspectorWidth = 296;  // of a new window, pixels
constexpr int kChartHeight = 240;     // of a new window, pixels
constexpr int kWaitForFrame_ms = 300;

}  // namespace

void MainWindow::make_actions() {
  make_file_menu();
  make_edit_menu();
  make_simulation_menu();
  make_compute_menu();
  make_view_menu();
  make_help_menu();
  make_tools();
  for (QAction* action : findChildren<QAction*>()) {
    const QString key = action->shortcut().toString(QKeySequence::NativeText);
    if (key.isEmpty() || action->toolTip().contains(key)) continue;
    action->setToolTip(tr("%1 (%2)").arg(action->toolTip(), key));
  }
  update_recent_files();
  update_actions();
}

void MainWindow::make_file_menu() {
  QMenu* file = menuBar()->addMenu(tr("&File"));
  const auto ask = [this](const QString& title, const QString& filter) {
    const QString path = QFileDialog::getOpenFileName(this, title, QFileInfo(path_).path(), filter);
    if (!path.isEmpty()) open(path);
  };
  file->addAction(
      tr("&Open scene…"), this, [ask] { ask(tr("Open a scene"), tr("Scenes (*.toml)")); },
      QKeySequence::Open);
  file->addAction(
      tr("Open &mesh…"), this,
      [ask] {
        ask(tr("Open a mesh, with a default material"),
            tr("Meshes (*.vtu *.vtk *.msh *.node *.ele *.veg)"));
      },
      QKeySequence(tr("Ctrl+M")));
  file->addAction(
      tr("Open &run…"), this,
      [this] {
        const QString path = QFileDialog::getExistingDirectory(
            this, tr("Open the output directory of a run"), QFileInfo(path_).path());
        if (!path.isEmpty()) open(path);
      },
      QKeySequence(tr("Ctrl+Shift+O")));
  compare_ = file->addAction(
      tr("Compare &with run…"), this,
      [this] {
        const QString path = QFileDialog::getExistingDirectory(
            this, tr("Open the output directory of a run beside this one"),
            QFileInfo(path_).path());
        if (!path.isEmpty()) open_result(QString::fromStdString(replay_->directory()), path);
      },
      QKeySequence(tr("Ctrl+Alt+C")));
  recent_ = file->addMenu(tr("Re&cent"));
  scale_ = file->addAction(tr("Scale of the mes&h…"), this, &MainWindow::ask_scale,
                           QKeySequence(tr("Ctrl+Shift+M")));
  scale_->setStatusTip(tr("Reads a mesh without a scene again, in another unit"));
  file->addSeparator();
  save_scene_ = file->addAction(
      tr("&Save recorded scene as…"), this, [this] { ask_save_scene(); }, QKeySequence::Save);
  save_scene_->setStatusTip(
      tr("The scene with all edits so far as events, which tetraction run replays"));
  live_only_.push_back(save_scene_);
  file->addAction(tr("Save s&creenshot…"), this, &MainWindow::ask_save_screenshot,
                  QKeySequence(tr("Ctrl+P")));
  record_pictures_ = file->addAction(tr("Record &pictures (PNG)…"));
  record_pictures_->setCheckable(true);
  record_pictures_->setShortcut(QKeySequence(tr("Ctrl+Shift+P")));
  connect(record_pictures_, &QAction::toggled, this, &MainWindow::ask_record_pictures);
  record_film_ = file->addAction(tr("Record fi&lm (WebM, MP4)…"), this,
                                 &MainWindow::ask_record_film, QKeySequence(tr("Ctrl+Shift+L")));
  record_film_->setStatusTip(tr("Needs the program ffmpeg. The entry for pictures ends it"));
  record_run_ = file->addAction(tr("Record &run (VTU, PVD, CSV)…"));
  record_run_->setCheckable(true);
  record_run_->setShortcut(QKeySequence(tr("Ctrl+Shift+R")));
  live_only_.push_back(record_run_);
  connect(record_run_, &QAction::toggled, this, &MainWindow::ask_record_run);
  file->addSeparator();
  file->addAction(tr("&Quit"), this, &QWidget::close, QKeySequence::Quit);
}

void MainWindow::make_edit_menu() {
  QMenu* edit = menuBar()->addMenu(tr("&Edit"));
  undo_ = edit->addAction(
      tr("Undo"), this,
      [this] {
        end_refusal();
        leave_failure();
        simulation_->undo();
      },
      QKeySequence::Undo);
  redo_ = edit->addAction(
      tr("Redo"), this,
      [this] {
        end_refusal();
        leave_failure();
        simulation_->redo();
      },
      QKeySequence::Redo);
  edit->addSeparator();
  edit->addAction(
      tr("Select &all"), this,
      [this] {
        if (mesh() == nullptr) return;
        std::vector<Index> all(static_cast<std::size_t>(mesh()->vertex_count()));
        for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<Index>(v);
        select(std::move(all));
      },
      QKeySequence::SelectAll);
  edit->addAction(
      tr("Select &none"), this, [this] { select({}); }, QKeySequence(tr("Ctrl+Shift+A")));
  QMenu* groups = edit->addMenu(tr("Select &group"));
  groups->setObjectName(QStringLiteral("groups"));
  connect(groups, &QMenu::aboutToShow, this, [this, groups] { fill_groups(groups); });
  edit->addSeparator();
  fix_ = edit->addAction(
      tr("&Fix selection"), this,
      [this] {
        leave_failure();
        edits_->fix(selection_);
      },
      QKeySequence(tr("F")));
  unfix_ = edit->addAction(
      tr("&Unfix selection"), this,
      [this] {
        leave_failure();
        edits_->unfix(selection_);
      },
      QKeySequence(tr("U")));
  name_ = edit->addAction(tr("&Name selection…"), this, &MainWindow::name_selection,
                          QKeySequence(tr("N")));
  name_->setToolTip(tr("Makes a named selection, for loads and constraints (N)"));
  probe_ = edit->addAction(tr("&Probe selection"), this, &MainWindow::probe_selection,
                           QKeySequence(tr("Shift+P")));
  probe_->setToolTip(tr("Adds a probe with a chart; the run begins again (Shift+P)"));
}

void MainWindow::make_simulation_menu() {
  QMenu* menu = menuBar()->addMenu(tr("&Simulation"));
  run_ = menu->addAction(
      tr("&Run or pause"), this,
      [this] {
        if (replay_) transport_->play(!transport_->playing());
        if (!simulation_) return;
        if (simulation_->peek()->running) {
          simulation_->pause();
        } else {
          simulation_->run();
        }
      },
      QKeySequence(Qt::Key_Space));
  step_ = menu->addAction(
      tr("&Step"), this,
      [this] {
        if (simulation_) simulation_->step();
        if (replay_) transport_->go(1);
      },
      QKeySequence(tr("S")));
  step_->setToolTip(tr("One time step, or one frame (S)"));
  go_back_ = menu->addAction(
      tr("&Back to the last good state"), this,
      [this] {
        if (simulation_) simulation_->go_back();
      },
      QKeySequence(tr("B")));
  go_back_->setEnabled(false);
  // The same key: one of the two is enabled.
  back_ = menu->addAction(
      tr("Bac&k to the state before"), this, [this] { transport_->go(-1); }, QKeySequence(tr("B")));
  back_->setToolTip(tr("Back by one kept state, or one frame (B)"));
  continue_ = menu->addAction(
      tr("&Continue from here"), this,
      [this] {
        if (simulation_) simulation_->continue_here();
      },
      QKeySequence(tr("Shift+Space")));
  continue_->setToolTip(
      tr("Continues from the state that is shown, with the settings of now. Undo "
         "brings the later states back (Shift+Space)"));
  continue_->setIconText(tr("Continue"));
  continue_->setVisible(false);
  menu->addSeparator();
  restart_ = menu->addAction(tr("R&estart"), this, &MainWindow::restart, QKeySequence(tr("R")));
  restart_->setToolTip(
      tr("Back to the scene's start; settings, fixes and forces stay as they are (R)"));
  reload_ = menu->addAction(tr("Re&load…"), this, &MainWindow::reload, QKeySequence(tr("Ctrl+R")));
  reload_->setStatusTip(tr("Reads the file again; edits made by hand are forgotten"));
}

void MainWindow::make_view_menu() {
  view_menu_ = menuBar()->addMenu(tr("&View"));
  const auto look = [this](const QString& name, const QString& key, const Vector3& from) {
    view_menu_->addAction(
        name, this, [this, from] { view_->look_from(from); }, QKeySequence(key));
  };
  QAction* fit = view_menu_->addAction(
      tr("Whole &body"), this, [this] { view_->fit(); }, QKeySequence(tr("Home")));
  fit->setObjectName(QStringLiteral("fit"));
  fit->setToolTip(tr("The whole body, from where the camera looks (Home)"));
  QAction* follow = view_menu_->addAction(tr("&Follow body"));
  follow->setObjectName(QStringLiteral("follow"));
  follow->setCheckable(true);
  follow->setShortcut(QKeySequence(tr("Shift+F")));
  follow->setToolTip(tr("The camera moves with the middle of the body (Shift+F)"));
  connect(follow, &QAction::toggled, view_, &BodyView::set_follow);
  look(tr("&Oblique"), tr("O"), kOblique);
  for (int axis = 0; axis < 3; ++axis) {
    const QChar name('x' + axis);
    look(tr("Along &%1").arg(name), name.toUpper(), Vector3::Unit(axis));
    look(tr("Along %1, from the other side").arg(name), tr("Shift+%1").arg(name.toUpper()),
         -Vector3::Unit(axis));
  }
  QAction* parallel = view_menu_->addAction(tr("O&rthographic"));
  parallel->setObjectName(QStringLiteral("orthographic"));
  parallel->setCheckable(true);
  parallel->setShortcut(QKeySequence(tr("P")));
  parallel->setToolTip(tr("Without perspective (P)"));
  connect(parallel, &QAction::toggled, view_, &BodyView::set_parallel);
  QAction* ghost = view_menu_->addAction(tr("&Keep as ghost"), view_, &BodyView::keep_ghost,
                                         QKeySequence(tr("G")));
  ghost->setObjectName(QStringLiteral("keep_ghost"));
  ghost->setToolTip(tr("Keeps the shape of this moment; Drawing → Ghost shows it (G)"));
  view_menu_->addSeparator();
  int panel = 0;
  for (QDockWidget* dock : findChildren<QDockWidget*>()) {
    view_menu_->addAction(dock->toggleViewAction());
    dock->toggleViewAction()->setShortcut(QKeySequence(QStringLiteral("Alt+%1").arg(++panel)));
  }
  view_menu_->addAction(tr("Reset &layout"), this, &MainWindow::reset_layout,
                        QKeySequence(tr("Ctrl+Home")));
  make_theme_menu();
  make_units_menu();
}

void MainWindow::make_help_menu() {
  QMenu* help = menuBar()->addMenu(tr("&Help"));
  help->addAction(tr("&Keys and mouse"), this, &MainWindow::show_keys, QKeySequence(Qt::Key_F1));
  add_documents(help);
  help->addSeparator();
  help->addAction(tr("&About Tetraction"), this, &MainWindow::show_about,
                  QKeySequence(tr("Ctrl+Shift+F1")));
}

void MainWindow::make_tools() {
  auto* bar = addToolBar(tr("Tools"));
  bar->setObjectName(QStringLiteral("tools"));
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
  bar->setIconSize(QSize(2 * kGrid, 2 * kGrid));
  auto* group = new QActionGroup(this);
  const auto add = [&](Icon picture, const QString& name, const QString& key, const QString& tip,
                       Tool tool) {
    QAction* action = bar->addAction(icon(picture), name);
    action->setObjectName(QStringLiteral("tool_%1").arg(key));
    action->setCheckable(true);
    action->setShortcut(QKeySequence(key));
    action->setToolTip(tr("%1 (%2)").arg(tip, key));
    group->addAction(action);
    connect(action, &QAction::triggered, this, [this, tool] { view_->set_tool(tool); });
    return action;
  };
  QAction* look =
      add(Icon::kNavigate, tr("Navigate"), QStringLiteral("1"),
          tr("Drag turns the body, middle button moves it, wheel zooms; click picks"), Tool::kLook);
  add(Icon::kSelect, tr("Select"), QStringLiteral("2"),
      tr("Drag a band around the visible vertices, with Alt also those behind; Ctrl or Shift adds "
         "to "
         "the selection; Ctrl+Shift and a click select a face"),
      Tool::kSelect);
  live_only_.push_back(add(
      Icon::kDrag, tr("Drag"), QStringLiteral("3"),
      tr("Drag vertices with a spring; the wheel sets the area, Alt moves the vertices exactly"),
      Tool::kMove));
  live_only_.push_back(add(Icon::kForce, tr("Force"), QStringLiteral("4"),
                           tr("Pull a force arrow from a vertex; it acts until changed"),
                           Tool::kForce));
  live_only_.push_back(add(Icon::kMomentum, tr("Momentum"), QStringLiteral("5"),
                           tr("Pull a momentum arrow from a vertex: a kick"), Tool::kMomentum));
  picture_menu_ = new QMenu(this);
  picture_menu_->setObjectName(QStringLiteral("picture_menu"));
  picture_menu_->addActions({fix_, unfix_, name_, probe_});
  picture_menu_->addSeparator();
  picture_menu_->addAction(findChild<QAction*>(QStringLiteral("fit")));
  look->setChecked(true);
  view_->set_tool(Tool::kLook);
}

void MainWindow::update_actions() {
  const bool live = simulation_ != nullptr;
  for (QAction* action : live_only_) {
    action->setEnabled(live);
    action->setVisible(!replay_);  // a replay has no use for them
  }
  const QString undo = live ? QString::fromStdString(simulation_->undo_text()) : QString();
  const QString redo = live ? QString::fromStdString(simulation_->redo_text()) : QString();
  undo_->setEnabled(!undo.isEmpty());
  undo_->setText(undo.isEmpty() ? tr("&Undo") : tr("&Undo “%1”").arg(undo));
  redo_->setEnabled(!redo.isEmpty());
  redo_->setText(redo.isEmpty() ? tr("&Redo") : tr("&Redo “%1”").arg(redo));
  scale_->setEnabled(mesh_scale_.has_value());
  for (QAction* action : {fix_, unfix_, name_, probe_}) {
    action->setEnabled(live && !selection_.empty());
  }
  for (QAction* action : {run_, step_, restart_, reload_}) action->setEnabled(live || replay_);
  back_->setEnabled((live || replay_) && !failed_);
  continue_->setEnabled(live && continue_->isVisible());
  for (QStackedWidget* pages : live_pages_) pages->setCurrentIndex(replay_ ? 1 : 0);
  scene_->tree()->setEnabled(live);
  scene_->inspector()->setEnabled(live);
  vertex_->set_editable(live);
  update_results_actions();
}

void MainWindow::update_recent_files() {
  recent_->clear();
  const QStringList files = QSettings().value(QStringLiteral("recent")).toStringList();
  for (const QString& file : files) {
    QString text = file;
    text.replace(QLatin1Char('&'), QLatin1String("&&"));  // a single & would underline a letter
    recent_->addAction(text, this, [this, file] { open(file); });
  }
  recent_->setEnabled(!files.isEmpty());
}

void MainWindow::remember_file(const QString& path) {
  QSettings settings;
  QStringList files = settings.value(QStringLiteral("recent")).toStringList();
  files.removeAll(path);
  files.prepend(path);
  while (files.size() > kRecentFiles) files.removeLast();
  settings.setValue(QStringLiteral("recent"), files);
  update_recent_files();
}

void MainWindow::show_keys() {
  QMessageBox::information(
      this, tr("Keys and mouse"),
      tr("<table cellpadding=3>"
         "<tr><td><b>Space</b></td><td>run or pause</td></tr>"
         "<tr><td><b>S</b></td><td>one step</td></tr>"
         "<tr><td><b>R</b></td><td>restart: back to the scene's start, with the settings of "
         "now</td></tr>"
         "<tr><td><b>Ctrl+R</b></td><td>reload the scene; edits are forgotten</td></tr>"
         "<tr><td><b>B</b></td><td>back by one kept state; after a failure: to the last good "
         "state</td></tr>"
         "<tr><td><b>Shift+Space</b></td><td>continue from the state that is shown</td></tr>"
         "<tr><td><b>F, U</b></td><td>fix, unfix the selection</td></tr>"
         "<tr><td><b>Ctrl+Z, Ctrl+Shift+Z</b></td><td>undo, redo</td></tr>"
         "<tr><td><b>Ctrl+A, Ctrl+Shift+A</b></td><td>select all, none</td></tr>"
         "<tr><td><b>1 … 5</b></td><td>tools: navigate, select, drag, force, momentum</td></tr>"
         "<tr><td><b>Home, O, X, Y, Z</b></td><td>whole body from here, oblique, along an "
         "axis; with Shift from its other side</td></tr>"
         "<tr><td><b>P, G</b></td><td>without perspective; keep this shape as a ghost</td></tr>"
         "<tr><td><b>Shift+F</b></td><td>the camera follows the body</td></tr>"
         "<tr><td><b>Wheel during a drag</b></td><td>size of the area that is pulled</td></tr>"
         "<tr><td><b>Alt and drag</b></td><td>the vertex itself, with the tool for drags</td></tr>"
         "<tr><td><b>Click</b></td><td>pick a vertex; with Ctrl or Shift: add it</td></tr>"
         "<tr><td><b>Ctrl+Shift and click</b></td><td>select a face up to its edges</td></tr>"
         "<tr><td><b>Shift and drag</b></td><td>rubber band, with every tool; with Alt through the "
         "body</td></tr>"
         "<tr><td><b>Right button</b></td><td>menu of the vertex; with a drag: zoom</td></tr>"
         "<tr><td><b>N, Shift+P</b></td><td>name the selection, probe it</td></tr>"
         "<tr><td><b>Middle button, wheel</b></td><td>move, zoom</td></tr>"
         "<tr><td><b>Ctrl and right button</b></td><td>move the light</td></tr>"
         "</table>"));
}

QSize MainWindow::first_size() {
  return QSize(1280, 800).boundedTo(QGuiApplication::primaryScreen()->availableSize());
}

void MainWindow::restore_window() {
  QSettings settings;
  apply_theme(stored_theme());
  const QSize room = QGuiApplication::primaryScreen()->availableSize();
  resize(first_size());
  resizeDocks({findChild<QDockWidget*>(QStringLiteral("dock_scene")),
               findChild<QDockWidget*>(QStringLiteral("dock_inspector"))},
              {kTreeWidth, kInspectorWidth}, Qt::Horizontal);
  resizeDocks({findChild<QDockWidget*>(QStringLiteral("dock_charts"))}, {kChartHeight},
              Qt::Vertical);
  first_layout_ = saveState();
  restoreGeometry(settings.value(QStringLiteral("geometry")).toByteArray());
  restoreState(settings.value(QStringLiteral("docks")).toByteArray());
  if (width() > room.width() || height() > room.height()) resize(size().boundedTo(room));
  // A panel that floated would come up beneath the window, which is shown after it.
  QTimer::singleShot(0, this, [this] {
    for (QDockWidget* dock : findChildren<QDockWidget*>()) {
      if (dock->isFloating() && dock->isVisible()) dock->raise();
    }
  });
  // Nor may the frame of the window, which is not known before, push the status bar off the screen.
  QTimer::singleShot(kWaitForFrame_ms, this, [this, room] {
    const QSize frame = frameGeometry().size() - size();
    if (!isMaximized() && !isFullScreen()) resize(size().boundedTo(room - frame));
  });
  drawing_->load(settings);
}

void MainWindow::save_window() const {
  QSettings settings;
  settings.setValue(QStringLiteral("geometry"), saveGeometry());
  settings.setValue(QStringLiteral("docks"), saveState());
  drawing_->save(settings);
}

}  // namespace tetraction::viewer
