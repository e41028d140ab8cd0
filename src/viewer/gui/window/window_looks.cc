// The theme, the layout at the start, help and the selection of groups.
#include <QActionGroup>
#include <QCoreApplication>
#include <QDesktopServices>
#include <QDir>
#include <QDockWidget>
#include <QInputDialog>
#include <QMenu>
#include <QMessageBox>
#include <QSettings>
#include <QUrl>
#include <algorithm>

#include "main_window.h"
#include "tetraction/core/version.h"
#include "viewer/display_units.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"
#include "viewer/gui/widgets/theme.h"

namespace tetraction::viewer {

void MainWindow::make_theme_menu() {
  QMenu* menu = view_menu_->addMenu(tr("&Colours of the window"));
  auto* group = new QActionGroup(this);
  const QString names[] = {tr("As the &desktop"), tr("&Light"), tr("&Dark")};
  const char* keys[] = {"Ctrl+Shift+0", "Ctrl+Shift+1", "Ctrl+Shift+2"};
  for (int i = 0; i < 3; ++i) {
    QAction* action = group->addAction(menu->addAction(names[i]));
    action->setObjectName(QStringLiteral("theme_%1").arg(i));
    action->setCheckable(true);
    action->setChecked(static_cast<Theme>(i) == stored_theme());
    action->setShortcut(QKeySequence(QLatin1String(keys[i])));
    connect(action, &QAction::triggered, this, [i] {
      QSettings().setValue(QStringLiteral("theme"), i);
      apply_theme(static_cast<Theme>(i));
    });
  }
}

void MainWindow::make_units_menu() {
  QMenu* menu = view_menu_->addMenu(tr("U&nits"));
  auto* group = new QActionGroup(this);
  const QString names[] = {tr("&SI with prefixes"), tr("&m, Pa, s"), tr("mm, M&Pa, ms"),
                           tr("&µm, kPa, µs")};
  const int stored = std::clamp(QSettings().value(QStringLiteral("units"), 0).toInt(), 0, 3);
  set_unit_system(static_cast<UnitSystem>(stored));
  for (int i = 0; i < 4; ++i) {
    QAction* action = group->addAction(menu->addAction(names[i]));
    action->setObjectName(QStringLiteral("units_%1").arg(i));
    action->setCheckable(true);
    action->setShortcut(QKeySequence(QStringLiteral("Ctrl+Alt+%1").arg(i)));
    action->setChecked(i == stored);
    connect(action, &QAction::triggered, this, [this, i] {
      set_unit_system(static_cast<UnitSystem>(i));
      QSettings().setValue(QStringLiteral("units"), i);
      show_units();
    });
  }
}

void MainWindow::show_units() {
  scene_->show_units();
  vertex_->show_units();
  drawing_->show_units();
  chart_->show_units();
  chart_->refresh();
  set_drawing(drawing_->drawing());  // the colour bar
  show_size();
  if (replay_) show_frame(transport_->frame());
}

void MainWindow::name_selection() {
  const QString name = QInputDialog::getText(
      this, tr("Name of the selection"),
      tr("A name for what is selected (vertices: %1), which loads and constraints can then use:")
          .arg(selection_.size()));
  if (!name.isEmpty()) scene_->add(QLatin1String(kSelections), selection_, name);
}

// The chart of the probe is shown as soon as the run has been set up with it.
void MainWindow::probe_selection() {
  const std::size_t count = simulation_->scene().probe.size() + 1;
  scene_->add(QStringLiteral("probe"), selection_);
  after_new_body_ = [this, count] {
    if (simulation_->scene().probe.size() == count) chart_->show_probe(static_cast<int>(count) - 1);
  };
}

// The panels where they are in a new window, and the window as large.
void MainWindow::reset_layout() {
  restoreState(first_layout_);
  resize(first_size());
}

void MainWindow::show_about() {
  QMessageBox::about(
      this, tr("About Tetraction"),
      tr("<h3>Tetraction %1</h3><p>Elastic bodies of tetrahedra with variational integrators.</p>"
         "<p>Apache License 2.0. The window uses Qt %2 and VTK.</p>")
          .arg(QString::fromStdString(version()), QString::fromLatin1(qVersion())));
}

// The documents that are installed with the program, or those of the source beside a build.
void MainWindow::add_documents(QMenu* help) {
  const QDir program(QCoreApplication::applicationDirPath());
  for (const char* place : {"../share/doc/tetraction/docs", "../../../docs"}) {
    const QDir documents(program.filePath(QLatin1String(place)));
    if (!documents.exists(QStringLiteral("viewer.md"))) continue;
    const auto add = [&](const QString& name, const char* file, const QKeySequence& key) {
      const QUrl url = QUrl::fromLocalFile(documents.canonicalPath() + QLatin1String(file));
      help->addAction(
              name, this, [url] { QDesktopServices::openUrl(url); }, key)
          ->setData(url);
    };
    add(tr("The &window"), "/viewer.md", QKeySequence(tr("Shift+F1")));
    add(tr("&Scenes"), "/scene.md", QKeySequence(tr("Ctrl+F1")));
    add(tr("&Outputs"), "/outputs.md", QKeySequence(tr("Shift+F2")));
    add(tr("&Questions"), "/faq.md", QKeySequence(tr("Ctrl+F2")));
    return;
  }
}

void MainWindow::fill_groups(QMenu* menu) {
  menu->clear();
  const TetMesh* body = mesh();
  for (std::size_t i = 0; body != nullptr && i < body->groups.size(); ++i) {
    QString name = QString::fromStdString(body->groups[i].name);
    if (name.isEmpty()) name = QString::number(body->groups[i].tag);
    name.replace(QLatin1Char('&'), QLatin1String("&&"));
    menu->addAction(name, this, [this, i] { select(mesh()->groups[i].vertices); });
  }
  if (menu->isEmpty()) menu->addAction(tr("The mesh has no groups"))->setEnabled(false);
}

}  // namespace tetraction::viewer
