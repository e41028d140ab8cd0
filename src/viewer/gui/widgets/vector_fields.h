// Three fields for the components of a vector.
#pragma once

#include <QWidget>
#include <array>

#include "tetraction/core/number_range.h"
#include "tetraction/core/types.h"

namespace tetraction::viewer {

class NumberField;

/// A vector that the user has entered. Only the components that were typed are meant to change.
struct EnteredVector {
  Vector3 value = Vector3::Zero();
  std::array<bool, 3> typed{true, true, true};

  EnteredVector() = default;
  EnteredVector(const Vector3& all) : value(all) {}  // NOLINT(google-explicit-constructor)
  EnteredVector(const Vector3& all, const std::array<bool, 3>& which) : value(all), typed(which) {}

  /// Whether all components were typed.
  bool is_whole() const { return typed[0] && typed[1] && typed[2]; }
  /// `present` with the components that were typed.
  Vector3 over(const Vector3& present) const;
};

/// Fields for the components of a vector. The vector is entered as a whole: when the user presses Return or
/// leaves the last field, not when the focus goes from one component to the next.
class VectorFields : public QWidget {
  Q_OBJECT

 public:
  VectorFields(const QString& what, const QString& unit, const NumberRange& range,
               QWidget* parent = nullptr);

  NumberField* field(int component) const { return fields_[static_cast<std::size_t>(component)]; }
  Vector3 value() const;
  /// Shows the present vector, unless the user is typing another one.
  void set_value(const Vector3& value);
  /// The same if there is none: the fields are empty.
  void set_none();

 signals:
  void entered(const tetraction::viewer::EnteredVector& vector);
  /// The user entered a number that is not allowed. The argument is the message.
  void refused(const QString& message);

 private:
  bool has_focus() const;
  void commit();

  std::array<NumberField*, 3> fields_{};
  std::array<bool, 3> typed_{};  // components that were typed and are not entered yet
};

}  // namespace tetraction::viewer
