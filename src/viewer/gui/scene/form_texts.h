// What the widgets of the scene share.
#pragma once

#include <QString>
#include <string>

#include "document/outline.h"

namespace tetraction::viewer {

/// The distance of widgets, pixels.
inline constexpr int kFormSpace = 8;

inline QString from_utf8(const std::string& text) {
  return QString::fromUtf8(text.c_str());
}

/// A value as a line of text: a list without its brackets, a text without its quotes.
QString json_text(const Json& value);
/// The value that a line of text is for a field.
Json json_from(const QString& typed, const Field& field);
/// Meaning, unit and range.
QString tip_of(const Field& field);

}  // namespace tetraction::viewer
