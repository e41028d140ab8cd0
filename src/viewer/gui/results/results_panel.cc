#include "results_panel.h"

#include <QDir>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QSpinBox>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tetraction::viewer {
namespace {

constexpr int kValue = Qt::UserRole;    // the number of a cell, or its text
constexpr int kRow = Qt::UserRole + 1;  // of the table that was given
constexpr int kRowHeight = 22;          // pixels
constexpr int kAmplitude = 10;          // % of the diagonal

// A cell that is sorted by its number, if it has one. Cells without one come last.
class Cell : public QTableWidgetItem {
 public:
  Cell(const StudyGrid::Cell& cell, bool is_text, int row)
      : QTableWidgetItem(QString::fromStdString(cell.text)) {
    setFlags(Qt::ItemIsEnabled | Qt::ItemIsSelectable);
    if (!is_text) setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
    const double number =
        std::isnan(cell.value) ? std::numeric_limits<double>::infinity() : cell.value;
    setData(kValue, is_text ? QVariant(text()) : QVariant(number));
    setData(kRow, row);
    setToolTip(text());
  }
  bool operator<(const QTableWidgetItem& other) const override {
    const QVariant mine = data(kValue);
    if (mine.type() == QVariant::String) return text() < other.text();
    return mine.toDouble() < other.data(kValue).toDouble();
  }
};

}  // namespace

ResultsPanel::ResultsPanel(QWidget* parent)
    : QWidget(parent),
      title_(new QLabel(this)),
      amplitude_text_(new QLabel(tr("Amplitude"), this)),
      amplitude_(new QSpinBox(this)),
      open_(new QPushButton(tr("Open"), this)),
      compare_(new QPushButton(tr("Compare"), this)),
      table_(new QTableWidget(this)) {
  title_->setTextFormat(Qt::PlainText);
  title_->setMinimumWidth(1);
  amplitude_->setObjectName(QStringLiteral("mode_amplitude"));
  amplitude_->setRange(1, 100);
  amplitude_->setValue(kAmplitude);
  amplitude_->setSuffix(tr(" %"));
  amplitude_->setToolTip(
      tr("The largest displacement of the mode, as a part of the diagonal of the body"));
  open_->setObjectName(QStringLiteral("open_run"));
  open_->setToolTip(tr("Shows the run that is selected; a double click does the same"));
  compare_->setObjectName(QStringLiteral("compare_runs"));
  compare_->setToolTip(tr("Shows the two runs that are selected side by side"));
  table_->setObjectName(QStringLiteral("results_table"));
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setDefaultSectionSize(kRowHeight);
  auto* top = new QHBoxLayout;
  top->addWidget(title_, 1);
  for (QWidget* widget : {static_cast<QWidget*>(amplitude_text_), static_cast<QWidget*>(amplitude_),
                          static_cast<QWidget*>(open_), static_cast<QWidget*>(compare_)}) {
    top->addWidget(widget);
  }
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 2, 4, 4);
  column->setSpacing(2);
  column->addLayout(top);
  column->addWidget(table_, 1);

  connect(table_, &QTableWidget::itemSelectionChanged, this, [this] {
    update_buttons();
    const std::vector<int> rows = selected();
    if (directory_.isEmpty() && rows.size() == 1) emit mode_wanted(rows.front());
  });
  connect(table_, &QTableWidget::itemDoubleClicked, open_, &QPushButton::click);
  connect(open_, &QPushButton::clicked, this,
          [this] { emit run_wanted(folder_of(selected().front())); });
  connect(compare_, &QPushButton::clicked, this, [this] {
    const std::vector<int> rows = selected();
    emit comparison_wanted(folder_of(rows.front()), folder_of(rows.back()));
  });
  connect(amplitude_, QOverload<int>::of(&QSpinBox::valueChanged), this,
          [this](int percent) { emit amplitude_changed(0.01 * percent); });
  update_buttons();
}

void ResultsPanel::show_table(const StudyGrid& grid, const QString& title) {
  const QSignalBlocker quiet(table_);
  title_->setText(title);
  table_->setSortingEnabled(false);
  table_->clear();
  const auto& columns = grid.columns();
  table_->setColumnCount(static_cast<int>(columns.size()));
  table_->setRowCount(static_cast<int>(grid.rows().size()));
  QStringList heads;
  for (const StudyGrid::Column& column : columns) heads += QString::fromStdString(column.head);
  table_->setHorizontalHeaderLabels(heads);
  folders_.clear();
  for (const StudyGrid::Row& row : grid.rows()) {
    const int number = static_cast<int>(folders_.size());
    folders_.push_back(QString::fromStdString(row.run));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      table_->setItem(number, static_cast<int>(c),
                      new Cell(row.cells[c], columns[c].is_text, number));
    }
  }
  table_->horizontalHeader()->setSortIndicator(-1, Qt::AscendingOrder);
  table_->setSortingEnabled(true);
  table_->resizeColumnsToContents();
  amplitude_->setVisible(directory_.isEmpty());
  amplitude_text_->setVisible(directory_.isEmpty());
  open_->setVisible(!directory_.isEmpty());
  compare_->setVisible(!directory_.isEmpty());
  update_buttons();
}

void ResultsPanel::show_runs(const StudyGrid& grid, const QString& directory) {
  directory_ = directory;
  show_table(grid,
             tr("The runs of the study in %1. Select two of them to compare them.").arg(directory));
}

void ResultsPanel::show_modes(const StudyGrid& grid, const QString& directory) {
  directory_.clear();
  show_table(grid, tr("The natural modes in %1").arg(directory));
}

void ResultsPanel::clear() {
  directory_.clear();
  show_table({}, {});
}

void ResultsPanel::choose(int row) {
  for (int i = 0; i < table_->rowCount(); ++i) {
    if (table_->item(i, 0)->data(kRow).toInt() == row) table_->selectRow(i);
  }
}

std::vector<int> ResultsPanel::selected() const {
  std::vector<int> rows;
  for (const QModelIndex& index : table_->selectionModel()->selectedRows())
    rows.push_back(index.row());
  std::sort(rows.begin(), rows.end());
  for (int& row : rows) row = table_->item(row, 0)->data(kRow).toInt();
  return rows;
}

QString ResultsPanel::folder_of(int row) const {
  return QDir(directory_).filePath(folders_[static_cast<std::size_t>(row)]);
}

void ResultsPanel::update_buttons() {
  const std::size_t count = selected().size();
  open_->setEnabled(count == 1);
  compare_->setEnabled(count == 2);
}

}  // namespace tetraction::viewer
