#include "field_form.h"

#include <QApplication>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>
#include <utility>

#include "form_texts.h"

namespace tetraction::viewer {
namespace {

// The fields without their values.
void add_shape(const std::vector<Field>& fields, std::string& shape) {
  for (const Field& field : fields) {
    for (const std::string& key : field.path) shape += key + ".";
    shape += std::to_string(static_cast<int>(field.kind)) + display_unit(field.unit).text;
    for (const std::string& name : field.names) shape += "|" + name;
    shape += field.kind == FieldKind::kTable && field.value.is_null() ? "-(" : "(";
    add_shape(field.fields, shape);
    shape += ")";
  }
}

QString title_with_unit(const Field& field) {
  const QString unit = from_utf8(display_unit(field.unit).text);
  return unit.isEmpty() ? from_utf8(field.title)
                        : QStringLiteral("%1 [%2]").arg(from_utf8(field.title), unit);
}

}  // namespace

bool FieldForm::Row::is_refused() const {
  return reason != nullptr && !reason->isHidden();
}

FieldForm::FieldForm(Change change, QWidget* parent) : QWidget(parent), change_(std::move(change)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
}

void FieldForm::set_choices(const Choices& choices) {
  choices_ = choices;
}

void FieldForm::show_fields(const std::vector<Field>& fields) {
  std::string shape;
  add_shape(fields, shape);
  for (const auto* names : {&choices_.names, &choices_.groups}) {
    for (const std::string& name : *names) shape += "," + name;
  }
  shape += choices_.selected.is_null() ? "" : "+";
  if (shape != std::exchange(shape_, shape)) {
    // Not focusWidget(), which is the last field that had the keyboard.
    const QWidget* focus = QApplication::focusWidget();
    const bool is_here = focus != nullptr && isAncestorOf(focus);
    const QString focused = is_here ? focus->objectName() : QString();
    rows_.clear();
    delete std::exchange(page_, new QWidget(this));
    layout()->addWidget(page_);
    auto* column = new QVBoxLayout(page_);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(kFormSpace);
    for (const Field& field : fields) add_field(field, column);
    for (NumberField* number : page_->findChildren<NumberField*>()) {
      connect(number, &NumberField::given_up, this, &FieldForm::forget_refusals);
      connect(number, &NumberField::finished, this, [this] { finished_(); });
    }
    if (auto* same = focused.isEmpty() ? nullptr : page_->findChild<QWidget*>(focused)) {
      same->setFocus();
    }
  }
  show_values(fields);
}

void FieldForm::show_values(const std::vector<Field>& fields) {
  for (const Field& field : fields) {
    const auto row = rows_.find(field.path);
    if (row != rows_.end() && row->second.show) {
      row->second.last = field;
      if (!row->second.is_refused()) row->second.show(field);
    }
    show_values(field.fields);
  }
}

void FieldForm::forget_refusals() {
  for (auto& [path, row] : rows_) {
    if (!row.is_refused()) continue;
    show_refusal(path, {});
    if (row.show) row.show(row.last);
  }
}

void FieldForm::add_field(const Field& field, QVBoxLayout* column) {
  Row& row = rows_[field.path];
  const bool is_table = field.kind == FieldKind::kTable || field.kind == FieldKind::kTables;
  if (is_table) {
    add_table(field, column);
  } else {
    row.widget = make_widget(field, row);
    const bool is_wide = field.kind == FieldKind::kVector || field.kind == FieldKind::kSelection ||
                         field.kind == FieldKind::kJson || field.kind == FieldKind::kFile;
    const bool shows_unit = field.kind == FieldKind::kVector || field.kind == FieldKind::kJson;
    auto* label = new QLabel(shows_unit ? title_with_unit(field) : from_utf8(field.title));
    label->setToolTip(tip_of(field));
    if (is_wide) {
      auto* block = new QVBoxLayout;
      block->setSpacing(kFormSpace / 4);
      block->addWidget(label);
      block->addWidget(row.widget);
      column->addLayout(block);
    } else {
      auto* line = new QHBoxLayout;
      line->setSpacing(kFormSpace);
      label->setWordWrap(true);
      line->addWidget(label, 2);
      line->addWidget(row.widget, 3);
      column->addLayout(line);
    }
  }
  row.reason = new QLabel;
  row.reason->setWordWrap(true);
  row.reason->setObjectName(from_utf8("reason_" + (field.path.empty() ? "select" : field.name())));
  row.reason->setStyleSheet(QStringLiteral("color: #b00000;"));
  row.reason->hide();
  column->addWidget(row.reason);
  if (field.kind == FieldKind::kSelection) {
    for (const Field& inner : field.fields) {
      if (inner.kind != FieldKind::kFlag) add_field(inner, column);
    }
  }
}

// A table of its own has a line under its title, and a list of tables its tables.
void FieldForm::add_table(const Field& field, QVBoxLayout* column) {
  auto* line = new QHBoxLayout;
  auto* title = new QLabel(QStringLiteral("<b>%1</b>").arg(from_utf8(field.title).toHtmlEscaped()));
  title->setToolTip(tip_of(field));
  line->addWidget(title, 1);
  const bool is_list = field.kind == FieldKind::kTables;
  const auto add_button = [&](const QString& label, const char* prefix, const Path& path,
                              const Json& value) {
    auto* button = new QPushButton(label);
    button->setObjectName(from_utf8(prefix + field.name()));
    button->setFocusPolicy(Qt::TabFocus);
    line->addWidget(button);
    connect(button, &QPushButton::clicked, this, [this, path, value] { change(path, value); });
  };
  if (is_list) {
    Path next = field.path;
    next.push_back(std::to_string(field.fields.size()));
    add_button(tr("Add"), "add_", next, Json::object());
  } else if (field.value.is_null()) {
    add_button(tr("Add"), "add_", field.path, Json::object());
  } else {
    add_button(tr("Remove"), "remove_", field.path, Json());
  }
  column->addLayout(line);
  if (field.fields.empty()) return;
  auto* inner = new QVBoxLayout;
  inner->setContentsMargins(kFormSpace, 0, 0, 0);
  inner->setSpacing(kFormSpace);
  column->addLayout(inner);
  for (const Field& own : field.fields) add_field(own, inner);
}

void FieldForm::change(const Path& path, const Json& value, const InputStage& stage) {
  show_refusal(path, {});
  const QString reason = change_(path, value, stage);
  if (!reason.isEmpty()) show_refusal(path, reason);
}

void FieldForm::show_refusal(const Path& path, const QString& reason) {
  auto row = rows_.find(path);
  // The last table or field around it has a place for the reason.
  for (Path outer = path; row == rows_.end() && !outer.empty();) {
    outer.pop_back();
    row = rows_.find(outer);
  }
  if (row == rows_.end() || row->second.reason == nullptr) return;
  row->second.reason->setText(reason);
  row->second.reason->setVisible(!reason.isEmpty());
  if (reason.isEmpty()) return;
  if (auto* number = qobject_cast<NumberField*>(row->second.widget)) number->show_refused();
}

QWidget* FieldForm::make_widget(const Field& field, Row& row) {
  QWidget* widget = nullptr;
  switch (field.kind) {
    case FieldKind::kNumber:
    case FieldKind::kWholeNumber:
      widget = make_number(field, row);
      break;
    case FieldKind::kVector:
      widget = make_vector(field, row);
      break;
    case FieldKind::kChoice:
      widget = make_choice(field, row);
      break;
    case FieldKind::kFlag:
      widget = make_flag(field, row);
      break;
    case FieldKind::kSelection:
      widget = make_selection(field, row);
      break;
    default:
      widget = make_text(field, row);
      break;
  }
  widget->setObjectName(from_utf8(field.path.empty() ? "select" : field.name()));
  if (widget->toolTip().isEmpty()) widget->setToolTip(tip_of(field));
  return widget;
}

}  // namespace tetraction::viewer
