// Saves charts as tables and pictures.
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkSVGExporter.h>

#include <QFileDialog>
#include <fstream>

#include "live_chart.h"
#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {

void LiveChart::save() {
  const QString path = QFileDialog::getSaveFileName(
      this, tr("Save the chart or its data"), QStringLiteral("chart.csv"),
      tr("Data of all charts (*.csv);;Picture (*.png);;Drawing (*.svg)"));
  if (!path.isEmpty()) save_as(path);
}

// Saves the chart with a legend of the visible series.
bool LiveChart::save_picture(const QString& path) {
  const auto draw = [this](bool legend) {
    chart_->SetShowLegend(legend);
    view_->GetScene()->SetDirty(true);
    window_->Render();
  };
  refresh();
  draw(true);
  bool good = false;
  if (path.endsWith(QLatin1String(".png"), Qt::CaseInsensitive)) {
    good = widget_->grabFramebuffer().save(path);
  } else {
    vtkNew<vtkSVGExporter> exporter;
    exporter->SetRenderWindow(window_);
    exporter->SetFileName(path.toLocal8Bit().constData());
    exporter->Write();
    good = std::ifstream(path.toLocal8Bit().constData()).good();
  }
  draw(false);
  return good;
}

void LiveChart::save_as(const QString& path) {
  bool good = false;
  if (path.endsWith(QLatin1String(".png"), Qt::CaseInsensitive) ||
      path.endsWith(QLatin1String(".svg"), Qt::CaseInsensitive)) {
    good = save_picture(path);
  } else {
    try {
      write_text_file(path.toLocal8Bit().toStdString(), history_text(rows_, probes_));
      good = true;
    } catch (const OutputError& error) {
      emit message_ready(QString::fromStdString(error.what()));
      return;
    }
  }
  emit message_ready(good ? tr("%1 is written.").arg(path)
                          : tr("%1 cannot be written. Choose another folder.").arg(path));
}

}  // namespace tetraction::viewer
