#include "form_texts.h"

#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {

QString json_text(const Json& value) {
  if (value.is_null()) return {};
  if (value.is_string()) return from_utf8(value.get<std::string>());
  const std::string all = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  QString shown = from_utf8(value.is_array() ? all.substr(1, all.size() - 2) : all);
  return shown.replace(QLatin1String(","), QLatin1String(", "));
}

Json json_from(const QString& typed, const Field& field) {
  const std::string utf8 = typed.trimmed().toStdString();
  if (utf8.empty()) return {};
  if (field.kind != FieldKind::kJson) return utf8;
  const Json whole = Json::parse(utf8, nullptr, false);
  const Json list = Json::parse("[" + utf8 + "]", nullptr, false);
  if (whole.is_structured()) {
    // "[0, 0], [1, 2]" is read whole only if there is one entry.
    const bool holds_lists =
        field.shown().is_array() && !field.shown().empty() && field.shown()[0].is_array();
    return whole.is_array() && holds_lists && !whole.empty() && !whole[0].is_array() ? list : whole;
  }
  if (!list.is_discarded() && (list.size() > 1 || field.shown().is_array())) return list;
  return whole.is_discarded() ? Json(utf8) : whole;
}

QString tip_of(const Field& field) {
  KeyInfo info;
  info.help = field.help.c_str();
  info.unit = field.unit.c_str();
  info.range = field.range;
  const bool is_number = field.kind == FieldKind::kNumber ||
                         field.kind == FieldKind::kWholeNumber || field.kind == FieldKind::kVector;
  if (is_number) return key_tip(info);
  QString help = from_utf8(field.help);
  return help.remove(QLatin1Char('`')).remove(QLatin1String("**"));
}

}  // namespace tetraction::viewer
