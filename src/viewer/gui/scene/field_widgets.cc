// The widgets of a FieldForm.
#include <QCheckBox>
#include <QComboBox>
#include <QFileDialog>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QStyle>
#include <QToolButton>
#include <cmath>
#include <memory>

#include "field_form.h"
#include "form_texts.h"
#include "viewer/gui/widgets/number_field.h"
#include "viewer/gui/widgets/vector_fields.h"

namespace tetraction::viewer {
namespace {

double number_in(const Json& value) {
  return value.is_number() ? value.get<double>() : 0.0;
}

}  // namespace

QWidget* FieldForm::make_number(const Field& field, Row& row) {
  const bool is_whole = field.kind == FieldKind::kWholeNumber;
  const Path path = field.path;
  const auto json = [is_whole](double value) {
    const bool fits = is_whole && value == std::floor(value) && std::abs(value) < 1e15;
    return fits ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  const auto show = [](NumberField* number, const Field& shown) {
    const Json& value = shown.shown();
    if (value.is_number() && std::isfinite(value.get<double>())) {
      number->set_value(value.get<double>());
    } else {
      number->set_text_value(json_text(value));
    }
  };
  const auto prepare = [&](NumberField* number) {
    number->set_draggable();
    if (is_whole) number->set_whole();
    number->setFocusPolicy(Qt::TabFocus);
    number->setToolTip(tip_of(field));
    const std::string word = field.word;
    const bool takes_array = field.takes_array;
    const bool may_be_absent = !field.is_needed;
    number->set_other_texts([this, path, word, takes_array, may_be_absent](const QString& typed) {
      if (typed.isEmpty() && may_be_absent) {
        change(path, Json());
      } else if (!word.empty() && typed == from_utf8(word)) {
        change(path, word);
      } else if (takes_array && !typed.isEmpty()) {
        change(path, Json{{"array", typed.toStdString()}});
      } else {
        return false;
      }
      return true;
    });
    connect(number, &NumberField::refused, this,
            [this, path](const QString& reason) { show_refusal(path, reason); });
    connect(number, &NumberField::textEdited, this, [this, path] { show_refusal(path, {}); });
    connect(number, &NumberField::dragged, this,
            [this, path, json](double value, const InputStage& stage) {
              change(path, json(value), stage);
            });
  };
  if (field.usual > 0.0) {
    auto* slider = new NumberSlider(from_utf8(field.title), from_utf8(field.unit), field.range, 0.0,
                                    field.usual);
    prepare(slider->field());
    connect(slider, &NumberSlider::entered, this,
            [this, path, json](double value, const InputStage& stage) {
              change(path, json(value), stage);
            });
    row.show = [slider](const Field& shown) { slider->set_value(number_in(shown.shown())); };
    return slider;
  }
  auto* number = new NumberField(from_utf8(field.title), from_utf8(field.unit), field.range);
  prepare(number);
  connect(number, &NumberField::entered, this,
          [this, path, json](double value) { change(path, json(value)); });
  row.show = [number, show](const Field& shown) { show(number, shown); };
  return number;
}

QWidget* FieldForm::make_vector(const Field& field, Row& row) {
  auto* vector = new VectorFields(from_utf8(field.title), from_utf8(field.unit), field.range);
  const Path path = field.path;
  for (int i = 0; i < 3; ++i) {
    vector->field(i)->setFocusPolicy(Qt::StrongFocus);
    connect(vector->field(i), &QLineEdit::textEdited, this,
            [this, path] { show_refusal(path, {}); });
  }
  auto typed = std::make_shared<Vector3>(Vector3::Zero());
  connect(vector, &VectorFields::entered, this, [this, path, typed](const EnteredVector& entered) {
    *typed = entered.value;
    change(path, Json{entered.value.x(), entered.value.y(), entered.value.z()});
  });
  connect(vector, &VectorFields::refused, this,
          [this, path](const QString& reason) { show_refusal(path, reason); });
  row.show = [vector, typed](const Field& shown) {
    Vector3 value = Vector3::Zero();
    const Json& json = shown.shown();
    if (json.is_null()) return vector->set_none();
    for (std::size_t i = 0; i < 3 && json.is_array() && i < json.size(); ++i) {
      value[static_cast<Index>(i)] = number_in(json[i]);
    }
    // A direction is normalised where it is used. The fields keep the numbers that were typed, so that
    // the user can go on to change single components of the same vector.
    const bool as_typed = !typed->isZero(0.0) && typed->normalized().isApprox(value);
    vector->set_value(as_typed ? *typed : value);
  };
  if (!field.takes_field) return vector;
  auto* both = new QWidget;
  auto* line = new QHBoxLayout(both);
  line->setContentsMargins(0, 0, 0, 0);
  line->addWidget(vector, 1);
  auto* formula = new QToolButton;
  formula->setText(QStringLiteral("ƒ"));
  formula->setToolTip(tr("A vector for each vertex, by formulas or from a file"));
  formula->setObjectName(from_utf8("formula_" + field.name()));
  line->addWidget(formula);
  connect(formula, &QToolButton::clicked, this, [this, path] {
    change(path, Json{{"formula", {"0", "0", "0"}}});
  });
  return both;
}

QWidget* FieldForm::make_choice(const Field& field, Row& row) {
  auto* box = new QComboBox;
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setMinimumContentsLength(8);
  box->setFocusPolicy(Qt::TabFocus);
  const bool may_be_absent = field.shown().is_null() && !field.is_needed;
  if (may_be_absent && (field.names.empty() || !field.names.front().empty())) {
    box->addItem(QStringLiteral("–"), QString());
  }
  for (const std::string& name : field.names) {
    box->addItem(name.empty() ? QStringLiteral("–") : from_utf8(name), from_utf8(name));
  }
  const Path path = field.path;
  connect(box, QOverload<int>::of(&QComboBox::activated), this, [this, path, box] {
    const std::string name = box->currentData().toString().toStdString();
    change(path, name.empty() ? Json() : Json(name));
  });
  row.show = [box](const Field& shown) {
    const Json& value = shown.shown();
    box->setCurrentIndex(box->findData(value.is_string() ? from_utf8(value.get<std::string>())
                                                         : QString(QLatin1String(""))));
  };
  return box;
}

QWidget* FieldForm::make_flag(const Field& field, Row& row) {
  auto* check = new QCheckBox;
  check->setFocusPolicy(Qt::TabFocus);
  const Path path = field.path;
  connect(check, &QCheckBox::clicked, this, [this, path](bool on) { change(path, on); });
  row.show = [check](const Field& shown) {
    check->setChecked(shown.shown().is_boolean() && shown.shown().get<bool>());
  };
  return check;
}

QWidget* FieldForm::make_text(const Field& field, Row& row) {
  auto* line = new QLineEdit;
  line->setMinimumWidth(60);
  const Field own = field;
  connect(line, &QLineEdit::textEdited, this, [this, own] { show_refusal(own.path, {}); });
  connect(line, &QLineEdit::editingFinished, this, [this, line, own] {
    if (!line->isModified()) return;
    line->setModified(false);
    change(own.path, display_unit(own.unit).to_si(json_from(line->text(), own)));
    // A text that was refused stays.
    const auto refused = rows_.find(own.path);
    if (refused != rows_.end() && refused->second.is_refused()) line->setModified(true);
  });
  row.show = [line](const Field& shown) {
    const QString now = json_text(display_unit(shown.unit).from_si(shown.shown()));
    if (!line->isModified() && line->text() != now) line->setText(now);
  };
  if (field.kind != FieldKind::kFile) return line;
  line->setObjectName(from_utf8(field.name()));
  auto* both = new QWidget;
  auto* pair = new QHBoxLayout(both);
  pair->setContentsMargins(0, 0, 0, 0);
  pair->addWidget(line, 1);
  auto* choose = new QToolButton;
  choose->setIcon(style()->standardIcon(QStyle::SP_DirOpenIcon));
  choose->setToolTip(tr("Choose a file"));
  choose->setFocusPolicy(Qt::TabFocus);
  pair->addWidget(choose);
  connect(choose, &QToolButton::clicked, this, [this, own] {
    const QString file = QFileDialog::getOpenFileName(this, from_utf8(own.title));
    if (!file.isEmpty()) change(own.path, file.toStdString());
  });
  return both;
}

// The kinds of selections, the named ones and the groups of the mesh file, and the selected vertices.
QWidget* FieldForm::make_selection(const Field& field, Row& row) {
  auto* both = new QWidget;
  auto* line = new QHBoxLayout(both);
  line->setContentsMargins(0, 0, 0, 0);
  auto* box = new QComboBox;
  box->setObjectName(QStringLiteral("selection_kind"));
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setFocusPolicy(Qt::TabFocus);
  for (const std::string& name : choices_.names) {
    box->addItem(from_utf8(name), from_utf8(Json(name).dump()));
  }
  for (const std::string& group : choices_.groups) {
    box->addItem(tr("group %1").arg(from_utf8(group)), from_utf8(Json{{"group", group}}.dump()));
  }
  for (const SceneKey& key : find_section("select")->keys) {
    box->addItem(QString::fromUtf8(key.info.name).replace(QLatin1Char('_'), QLatin1Char(' ')),
                 QString::fromUtf8(key.info.name));
    box->setItemData(box->count() - 1, QString::fromUtf8(key.info.help), Qt::ToolTipRole);
  }
  line->addWidget(box, 1);
  auto* selected = new QPushButton(tr("Use selected"));
  selected->setObjectName(QStringLiteral("use_selected"));
  selected->setToolTip(tr("Takes the vertices that are selected in the picture"));
  selected->setEnabled(!choices_.selected.is_null());
  selected->setFocusPolicy(Qt::TabFocus);
  line->addWidget(selected);
  const Path path = field.path;
  connect(box, QOverload<int>::of(&QComboBox::activated), this, [this, path, box] {
    const std::string chosen = box->currentData().toString().toStdString();
    const bool is_json = chosen.front() == '"' || chosen.front() == '{';
    const Json usual = choices_.selected.is_null() ? Json{{"all", true}} : choices_.selected;
    change(path, is_json ? Json::parse(chosen) : selection_of_kind(chosen, usual));
  });
  connect(selected, &QPushButton::clicked, this, [this, path] { change(path, choices_.selected); });
  row.show = [box](const Field& shown) {
    const Json& value = shown.value;
    int index = box->findData(from_utf8(value.dump()));
    if (index < 0 && value.is_object() && !value.empty()) {
      index = box->findData(from_utf8(value.begin().key()));
    }
    box->setCurrentIndex(index);
  };
  return both;
}

}  // namespace tetraction::viewer
