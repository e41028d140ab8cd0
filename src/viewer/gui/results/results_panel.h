// The table of the runs of a study, or of natural modes.
#pragma once

#include <QWidget>

#include "io/study/study_grid.h"

class QLabel;
class QPushButton;
class QSpinBox;
class QTableWidget;

namespace tetraction::viewer {

class ResultsPanel : public QWidget {
  Q_OBJECT

 public:
  explicit ResultsPanel(QWidget* parent = nullptr);

  /// The runs of a study: each row has the folder of its run.
  void show_runs(const StudyGrid& grid, const QString& directory);
  void show_modes(const StudyGrid& grid, const QString& directory);
  void clear();
  /// Selects the row of a run or a mode, by its number in the table that was given.
  void choose(int row);

 signals:
  void run_wanted(const QString& directory);
  void comparison_wanted(const QString& first, const QString& second);
  void mode_wanted(int mode);
  /// A part of the diagonal of the body.
  void amplitude_changed(double amplitude);

 private:
  void show_table(const StudyGrid& grid, const QString& title);
  void update_buttons();
  /// The numbers of the selected rows in the table that was given, in the order of the rows that are shown.
  std::vector<int> selected() const;
  QString folder_of(int row) const;

  QString directory_;  // of a study; empty for modes
  std::vector<QString> folders_;
  QLabel *title_, *amplitude_text_;
  QSpinBox* amplitude_;
  QPushButton *open_, *compare_;
  QTableWidget* table_;
};

}  // namespace tetraction::viewer
