// A form for the fields of an entry of the scene.
#pragma once

#include <QFormLayout>
#include <QWidget>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "document/outline.h"
#include "viewer/gui/widgets/number_field.h"

class QLabel;
class QVBoxLayout;

namespace tetraction::viewer {

/// One widget for each field, of the same form for all sections. The name of a widget is that of its key.
class FieldForm : public QWidget {
 public:
  using Path = std::vector<std::string>;
  /// Makes a change and returns why it is not possible, or an empty text.
  using Change = std::function<QString(const Path&, const Json&, const InputStage&)>;

  explicit FieldForm(Change change, QWidget* parent = nullptr);

  /// What can be chosen for a selection.
  struct Choices {
    std::vector<std::string> names;   ///< of named selections
    std::vector<std::string> groups;  ///< of the mesh file
    Json selected;  ///< the selection of the selected vertices; null if there are none
  };
  void set_choices(const Choices& choices);
  /// What to do when the user has finished a number with Return or Escape.
  void set_finished(std::function<void()> finished) { finished_ = std::move(finished); }
  /// Shows the fields. The widgets are made anew only if there are other fields.
  void show_fields(const std::vector<Field>& fields);
  /// Shows a reason below a field, whose text stays.
  void show_refusal(const Path& path, const QString& reason);
  /// Takes all reasons away and shows the present values instead of the refused ones.
  void forget_refusals();

 private:
  struct Row {
    QWidget* widget = nullptr;
    QLabel* reason = nullptr;
    std::function<void(const Field&)> show;
    Field last{};  // of show()
    bool is_refused() const;
  };

  void add_field(const Field& field, QVBoxLayout* column);
  void add_table(const Field& field, QVBoxLayout* column);
  QWidget* make_widget(const Field& field, Row& row);
  QWidget* make_number(const Field& field, Row& row);
  QWidget* make_vector(const Field& field, Row& row);
  QWidget* make_choice(const Field& field, Row& row);
  QWidget* make_flag(const Field& field, Row& row);
  QWidget* make_text(const Field& field, Row& row);
  QWidget* make_selection(const Field& field, Row& row);
  void change(const Path& path, const Json& value, const InputStage& stage = {});
  void show_values(const std::vector<Field>& fields);

  Change change_;
  std::function<void()> finished_ = [] {};
  Choices choices_;
  std::string shape_;  // of the fields that there are widgets for
  QWidget* page_ = nullptr;
  std::map<Path, Row> rows_;
};

}  // namespace tetraction::viewer
