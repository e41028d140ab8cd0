// The layout of the window, and the connections between its parts.
#include <QAbstractButton>
#include <QAbstractSlider>
#include <QAction>
#include <QComboBox>
#include <QDockWidget>
#include <QLabel>
#include <QMenu>
#include <QSpinBox>
#include <QStackedWidget>
#include <QStatusBar>
#include <algorithm>

#include "main_window.h"
#include "viewer/display_units.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/panels/drawing_panel.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/widgets/number_field.h"
#include "viewer/gui/widgets/panel_area.h"

namespace tetraction::viewer {

void MainWindow::make_docks() {
  setTabPosition(Qt::LeftDockWidgetArea, QTabWidget::North);
  setTabPosition(Qt::RightDockWidgetArea, QTabWidget::North);
  setCorner(Qt::BottomLeftCorner, Qt::LeftDockWidgetArea);
  setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  // Settings of a simulation, or a text while a run is replayed, which has none that could be changed.
  const auto live = [this](QWidget* panel, const QString& of_replay) {
    auto* pages = new QStackedWidget(this);
    auto* text = new QLabel(of_replay, pages);
    text->setObjectName(QStringLiteral("replay_text"));
    text->setWordWrap(true);
    text->setMargin(8);
    text->setAlignment(Qt::AlignTop);
    pages->addWidget(panel);
    pages->addWidget(text);
    // The text may be narrower than the panel.
    const auto fit = [pages](int shown) {
      for (int i = 0; i < pages->count(); ++i) {
        const auto policy = i == shown ? QSizePolicy::Preferred : QSizePolicy::Ignored;
        pages->widget(i)->setSizePolicy(policy, policy);
      }
    };
    connect(pages, &QStackedWidget::currentChanged, pages, fit);
    fit(0);
    live_pages_.push_back(pages);
    return pages;
  };
  const auto add = [&](Qt::DockWidgetArea area, QWidget* panel, const QString& title,
                       const char* name, bool scrolls = true) {
    auto* dock = new QDockWidget(title, this);
    dock->setObjectName(QLatin1String(name));
    addDockWidget(area, dock);
    // A panel that floats, or comes back from there, lies above the others.
    connect(dock, &QDockWidget::topLevelChanged, dock, [dock] { dock->raise(); });
    connect(dock->toggleViewAction(), &QAction::triggered, dock, [dock](bool shown) {
      if (shown) dock->raise();
    });
    if (!scrolls) {
      dock->setWidget(panel);
      return dock;
    }
    auto* scroll = new PanelArea(dock);
    scroll->setWidget(panel);
    dock->setWidget(scroll);
    return dock;
  };
  add(Qt::LeftDockWidgetArea,
      live(scene_->tree(), tr("A finished run is shown. Its settings are in the file summary.json "
                              "of its folder.")),
      tr("Scene"), "dock_scene", false);
  QDockWidget* inspector = add(
      Qt::RightDockWidgetArea,
      live(scene_->inspector(), tr("Space plays the frames, S shows the next one, and R goes back "
                                   "to the first. Drawing has the colours and shapes.")),
      tr("Inspector"), "dock_inspector");
  tabifyDockWidget(inspector,
                   add(Qt::RightDockWidgetArea, vertex_, tr("Vertices"), "dock_vertices"));
  tabifyDockWidget(inspector,
                   add(Qt::RightDockWidgetArea, drawing_, tr("Drawing"), "dock_drawing"));
  inspector->raise();
  connect(scene_, &ScenePanels::chosen, inspector, &QDockWidget::raise);
  // A click does not move the focus, so that Space still runs and pauses the simulation. The Tab key
  // reaches all widgets, and Space then activates the widget with the focus (eventFilter()).
  for (QDockWidget* dock : findChildren<QDockWidget*>()) {
    for (QWidget* widget : dock->findChildren<QWidget*>()) {
      if (qobject_cast<QAbstractButton*>(widget) != nullptr ||
          qobject_cast<QAbstractSlider*>(widget) != nullptr ||
          qobject_cast<QComboBox*>(widget) != nullptr) {
        widget->setFocusPolicy(Qt::TabFocus);
      }
    }
  }

  // After a number was entered, the focus returns to the picture: Space runs, S makes a step.
  const auto to_the_view = [this] { view_->canvas()->setFocus(Qt::OtherFocusReason); };
  for (NumberField* field : findChildren<NumberField*>()) {
    connect(field, &NumberField::finished, this, to_the_view);
  }
  connect(scene_, &ScenePanels::finished, this, to_the_view);
  for (QSpinBox* box : findChildren<QSpinBox*>()) {
    connect(box, &QSpinBox::editingFinished, this, [box, to_the_view] {
      if (box->hasFocus()) to_the_view();
    });
  }

  auto* charts = new QDockWidget(tr("Charts"), this);
  charts->setObjectName(QStringLiteral("dock_charts"));
  charts->setWidget(chart_);
  addDockWidget(Qt::BottomDockWidgetArea, charts);
}

void MainWindow::connect_panels() {
  connect(scene_, &ScenePanels::about_to_change, this, [this] {
    end_refusal();
    leave_failure();
  });
  connect(vertex_, &VertexPanel::fix_wanted, this, [this] {
    if (fix_->isEnabled()) fix_->trigger();  // trigger() works for a disabled action, too
  });
  connect(vertex_, &VertexPanel::unfix_wanted, this, [this] {
    if (unfix_->isEnabled()) unfix_->trigger();
  });
  connect(vertex_, &VertexPanel::name_wanted, name_, &QAction::trigger);
  connect(vertex_, &VertexPanel::move_wanted, this, [this](const EnteredVector& target, bool fix) {
    if (!edits_) return;
    if (fix) {
      edits_->fix_at(selection_, target);
    } else {
      edits_->move_to(selection_, target);
    }
  });
  connect(vertex_, &VertexPanel::momentum_wanted, this, [this](const EnteredVector& value) {
    if (edits_) edits_->set_momentum(selection_, value);
  });
  connect(vertex_, &VertexPanel::force_wanted, this, [this](const EnteredVector& value) {
    if (edits_) edits_->set_force(selection_, value);
  });

  connect(drawing_, &DrawingPanel::changed, this, &MainWindow::set_drawing);
  connect(drawing_, &DrawingPanel::refit_wanted, this, [this] {
    DrawingSettings following = drawing_->drawing();
    if (following.automatic_range) {
      view_->refit_colors();
      drawing_->show_range(view_->color_low(), view_->color_high());
    } else {  // fits a fixed range to the data once
      following.automatic_range = true;
      view_->set_drawing(following);
      drawing_->show_range(view_->color_low(), view_->color_high());
      view_->set_drawing(drawing_->drawing());
    }
  });
  const auto warn = [this](const QString& message) { show_refusal(message); };
  connect(scene_, &ScenePanels::refused, this, warn);
  connect(vertex_, &VertexPanel::refused, this, warn);
  connect(drawing_, &DrawingPanel::refused, this, warn);
  connect(chart_, &LiveChart::message_ready, this,
          [this](const QString& message) { statusBar()->showMessage(message, 8000); });
}

void MainWindow::connect_view() {
  connect(view_, &BodyView::picked, this, [this](Index vertex, bool add) {
    std::vector<Index> next = add ? selection_ : std::vector<Index>{};
    const auto there = std::find(next.begin(), next.end(), vertex);
    if (there != next.end()) {
      next.erase(there);
    } else if (vertex >= 0) {
      next.push_back(vertex);
    }
    select(std::move(next));
  });
  connect(view_, &BodyView::menu_wanted, this, [this](Index vertex, const QPoint& place) {
    if (vertex >= 0 &&
        std::find(selection_.begin(), selection_.end(), vertex) == selection_.end()) {
      select({vertex});
    }
    picture_menu_->popup(place);
  });
  connect(view_, &BodyView::band_selected, this, [this](std::vector<Index> vertices, bool add) {
    if (add) vertices.insert(vertices.end(), selection_.begin(), selection_.end());
    select(std::move(vertices));
  });
  connect(view_, &BodyView::light_turned, drawing_, &DrawingPanel::turn_light);
  connect(view_, &BodyView::area_scaled, this, [this](double factor) {
    const double radius = edits_ ? edits_->scale_area(factor) : 0.0;
    if (radius > 0.0) {
      const QString length = QString::fromStdString(with_unit(radius, "m", 3));
      statusBar()->showMessage(tr("The drag pulls within %1").arg(length), 4000);
    }
  });
  connect(view_, &BodyView::grabbed, this, [this](Index vertex, bool exact) {
    if (!edits_) return;
    // If the vertex is selected, all selected vertices are dragged.
    if (std::find(selection_.begin(), selection_.end(), vertex) == selection_.end()) {
      select({vertex});
    }
    edits_->grab(selection_, vertex, exact);
    if (!exact && !simulation_->peek()->running) {
      statusBar()->showMessage(tr("The spring pulls as soon as the simulation runs. With Alt the "
                                  "vertex itself is moved."),
                               8000);
    }
  });
  connect(view_, &BodyView::obstacle_grabbed, this,
          [this](std::size_t number, const Vector3& point) {
            if (edits_) edits_->grab_obstacle(number, point);
          });
  connect(view_, &BodyView::dragged, this, [this](const Vector3& place) {
    if (edits_) edits_->drag_to(place);
  });
  connect(view_, &BodyView::released, this, [this] {
    if (edits_) edits_->release();
  });
  connect(view_, &BodyView::arrow_pulled, this,
          [this](Tool tool, Index vertex, const Vector3& arrow) {
            if (!edits_) return;
            if (std::find(selection_.begin(), selection_.end(), vertex) == selection_.end()) {
              select({vertex});
            }
            if (tool == Tool::kForce) {
              edits_->set_force(selection_, Vector3(arrow * vertex_->force_per_length()));
            } else {
              edits_->set_momentum(selection_, Vector3(arrow * vertex_->momentum_per_length()));
            }
          });
  connect(view_, &BodyView::arrow_moved, this, [this](Tool tool, const Vector3& arrow) {
    const bool force = tool == Tool::kForce;
    const double scale = force ? vertex_->force_per_length() : vertex_->momentum_per_length();
    const std::string size = with_unit(arrow.norm() * scale, force ? "N" : "kg m/s");
    statusBar()->showMessage(
        (force ? tr("Force %1") : tr("Momentum %1")).arg(QString::fromStdString(size)), 2000);
  });
}

}  // namespace tetraction::viewer
