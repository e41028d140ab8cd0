// The panel of the selected vertices.
#pragma once

#include <QWidget>
#include <vector>

#include "viewer/gui/widgets/vector_fields.h"
#include "viewer/simulation.h"

class QFormLayout;
class QLabel;
class QPushButton;

namespace tetraction::viewer {

class NumberField;

/// Shows position, momentum and forces of the selected vertex, or the means of several vertices. The
/// user can type other values.
class VertexPanel : public QWidget {
  Q_OBJECT

 public:
  explicit VertexPanel(QWidget* parent = nullptr);

  void set_selection(const std::vector<Index>& vertices, const TetMesh& mesh);
  void show_state(const Snapshot& snapshot);
  /// Whether the fields may change the body. In a replay they only show it.
  void set_editable(bool editable);
  /// Force and momentum of an arrow of one metre, N and kg m/s.
  double force_per_length() const;
  double momentum_per_length() const;
  /// Sets both such that an arrow of a fifth of the body's size has a visible but moderate effect.
  void suggest_arrows(const TetMesh& mesh, const LameParameters& lame, double density);
  /// Shows the numbers in the present units.
  void show_units();

 signals:
  void fix_wanted();
  void unfix_wanted();
  void name_wanted();
  /// The mean position shall become `target`, m. If `fix`, the vertices are fixed there.
  void move_wanted(const tetraction::viewer::EnteredVector& target, bool fix);
  void momentum_wanted(const tetraction::viewer::EnteredVector& value);
  void force_wanted(const tetraction::viewer::EnteredVector& value);
  void refused(const QString& message);

 private:
  QLabel* add_title(const QString& title, const char* unit);
  VectorFields* add_vector(QFormLayout* form, const QString& label, const QString& what,
                           const char* unit);
  void enable_fields();

  std::vector<Index> selection_;
  bool may_edit_ = true;
  QLabel *which_, *held_, *reaction_, *speed_;
  QPushButton *fix_, *unfix_, *name_, *place_;
  VectorFields *position_, *momentum_, *force_;
  NumberField *force_scale_, *momentum_scale_;
  std::vector<QWidget*> editable_;
  struct Title {
    QLabel* label;
    QString text;
    const char* unit;
  };
  std::vector<Title> titles_;  // that have a unit
};

}  // namespace tetraction::viewer
