// The panel of the selected vertices.
#pragma once

#include <QWidget>
#include <vector>

#include "viewer/simulation.h"

class QFormLayout;
class QLabel;
class QPushButton;

namespace tetraction::viewer {

class NumberField;

/// Shows position, momentum, forces of the selection (of several vertices the means) and takes typed
/// ones.
class VertexPanel : public QWidget {
  Q_OBJECT

 public:
  explicit VertexPanel(QWidget* parent = nullptr);

  void set_selection(const std::vector<Index>& vertices, const TetMesh& mesh);
  void show_state(const Snapshot& snapshot);
  /// Force and momentum for a pulled arrow of one metre, N and kg m/s.
  double force_per_length() const;
  double momentum_per_length() const;
  /// Sets both so that an arrow of a fifth of the body has a visible effect without being too
  /// strong for the body.
  void suggest_arrows(const TetMesh& mesh, const MaterialModel& material, double density);

 signals:
  void fix_wanted();
  void unfix_wanted();
  /// The mean position shall be `target`, m; held there if `fix`.
  void move_wanted(tetraction::Vector3 target, bool fix);
  void momentum_wanted(tetraction::Vector3 value);
  void force_wanted(tetraction::Vector3 value);
  void refused(const QString& message);

 private:
  struct Triple {
    NumberField* field[3];
    Vector3 value() const;
    void set_value(const Vector3& value);
  };
  Triple add_triple(QFormLayout* form, const QString& label, const QString& what,
                    const QString& unit);

  std::vector<Index> selection_;
  QLabel *which_, *held_, *reaction_, *speed_;
  QPushButton *fix_, *unfix_, *place_;
  Triple position_, momentum_, force_;
  NumberField *force_scale_, *momentum_scale_;
  std::vector<QWidget*> editable_;
};

}  // namespace tetraction::viewer
