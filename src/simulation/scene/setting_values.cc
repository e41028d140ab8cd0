#include "setting_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/quoting.h"
#include "core/spelling.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr std::int64_t kMostInteger = std::numeric_limits<std::int64_t>::max();

// The kind of a value, for messages.
std::string_view kind_of(const Json& node) {
  if (node.is_object()) return "a table";
  if (node.is_array()) return "a list";
  if (node.is_string()) return "a string";
  if (node.is_number_integer()) return "a whole number";
  if (node.is_number_float()) return "a number";
  if (node.is_boolean()) return "true or false";
  return "a date or time";
}

// A list of `size` entries, or of one or more if `size` is 0.
const Json& list_of(const Json& node, std::size_t size, const char* example,
                    const Refusal& refuse) {
  if (!node.is_array()) {
    refuse(fmt::format("must be a list like {}, not {}.", example, kind_of(node)));
  }
  if (size != 0 ? node.size() != size : node.empty()) {
    refuse(fmt::format("has {} entries; it must have {}, like {}.", node.size(),
                       size != 0 ? std::to_string(size) : "at least one", example));
  }
  return node;
}

double number_of(const Json& node, const NumberRange& range, const Refusal& refuse, bool in_list) {
  if (!node.is_number()) {
    refuse(fmt::format("{} {}, not {}.", in_list ? "must be a list of" : "must be",
                       in_list ? "numbers" : "a number", kind_of(node)));
  }
  const auto value = node.get<double>();
  if (const std::string refusal = range.refusal(value); !refusal.empty()) {
    refuse(fmt::format("{}{}{}", in_list ? "holds " : "= ", value, refusal));
  }
  return value;
}

std::int64_t integer_of(const Json& node, std::int64_t least, std::int64_t most,
                        const Refusal& refuse, bool in_list) {
  if (!node.is_number_integer()) {
    refuse(fmt::format(
        "{} {}, not {}.", in_list ? "must be a list of" : "must be",
        in_list ? "whole numbers" : "a whole number",
        node.is_number_float() ? "a number with a decimal point or exponent" : kind_of(node)));
  }
  const auto value = node.get<std::int64_t>();
  if (value < least || value > most) {
    refuse(fmt::format(
        "{}{}; it must be {}.", in_list ? "holds " : "= ", value,
        value < least ? fmt::format("{} or more", least) : fmt::format("{} at most", most)));
  }
  return value;
}

template <class Three>
void read_three(const Json& node, const NumberRange& range, const Refusal& refuse, Three& value) {
  list_of(node, 3, "[1.0, 0.0, 0.0]", refuse);
  for (std::size_t i = 0; i < 3; ++i) {
    value[static_cast<Index>(i)] = number_of(node[i], range, refuse, true);
  }
}

void check_number(double value, const char* verb, const NumberRange& range,
                  const std::string& name) {
  const std::string refusal = range.refusal(value);
  if (!refusal.empty()) throw InputError(fmt::format("{} {} {}{}", name, verb, value, refusal));
}

// The kinds of values, one struct each. Values of most kinds are checked by their types alone.
struct Unchecked {
  template <class T>
  static void check(const T&, const NumberRange&, const std::string&) {}
};

template <class T>
struct Kind;

template <>
struct Kind<bool> : Unchecked {
  static constexpr const char* kType = "`true` or `false`";
  static Json json(bool value) { return value; }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse, bool& value) {
    if (!node.is_boolean()) {
      refuse(fmt::format("must be true or false, not {}.", kind_of(node)));
    }
    value = node.get<bool>();
  }
};

template <>
struct Kind<int> {
  static constexpr const char* kType = "whole number";
  static Json json(int value) { return value; }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse, int& value) {
    constexpr int kMost = std::numeric_limits<int>::max();
    if (std::isinf(range.most)) {
      value = static_cast<int>(
          integer_of(node, static_cast<std::int64_t>(range.least), kMost, refuse, false));
      return;
    }
    const std::int64_t given = integer_of(node, -kMostInteger, kMostInteger, refuse, false);
    const std::string refusal = range.refusal(static_cast<double>(given));
    if (!refusal.empty()) refuse(fmt::format("= {}{}", given, refusal));
    value = static_cast<int>(given);
  }
  static void check(int value, const NumberRange& range, const std::string& name) {
    check_number(value, "=", range, name);
  }
};

template <>
struct Kind<double> {
  static constexpr const char* kType = "number";
  static Json json(double value) { return std::isfinite(value) ? Json(value) : Json(); }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   double& value) {
    value = number_of(node, range, refuse, false);
  }
  static void check(double value, const NumberRange& range, const std::string& name) {
    check_number(value, "=", range, name);
  }
};

template <>
struct Kind<Vector3> {
  static constexpr const char* kType = "three numbers";
  static Json json(const Vector3& value) { return {value.x(), value.y(), value.z()}; }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   Vector3& value) {
    read_three(node, range, refuse, value);
  }
  static void check(const Vector3& value, const NumberRange& range, const std::string& name) {
    for (const double entry : value) check_number(entry, "holds", range, name);
  }
};

template <>
struct Kind<std::array<double, 2>> : Unchecked {
  static constexpr const char* kType = "two numbers";
  static Json json(const std::array<double, 2>& value) { return value; }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::array<double, 2>& value) {
    list_of(node, 2, "[10.0, 100.0]", refuse);
    for (std::size_t i = 0; i < 2; ++i) value[i] = number_of(node[i], range, refuse, true);
  }
};

template <>
struct Kind<std::array<int, 3>> : Unchecked {
  static constexpr const char* kType = "three whole numbers";
  static Json json(const std::array<int, 3>& value) { return value; }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::array<int, 3>& value) {
    list_of(node, 3, "[40, 10, 10]", refuse);
    for (std::size_t i = 0; i < 3; ++i) {
      value[i] = static_cast<int>(integer_of(node[i], static_cast<std::int64_t>(range.least),
                                             std::numeric_limits<int>::max(), refuse, true));
    }
  }
};

// Components by their letters.
template <>
struct Kind<std::array<bool, 3>> {
  static constexpr const char* kType = "text";
  static Json json(const std::array<bool, 3>& value) { return letters_of(value); }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse,
                   std::array<bool, 3>& value);
  static void check(const std::array<bool, 3>& value, const NumberRange&, const std::string& name) {
    if (value[0] || value[1] || value[2]) return;
    throw InputError(name + " must name at least one of x, y and z.");
  }
};

template <>
struct Kind<std::string> : Unchecked {
  static constexpr const char* kType = "text";
  static Json json(const std::string& value) { return value.empty() ? Json() : Json(value); }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse,
                   std::string& value) {
    if (!node.is_string()) refuse(fmt::format("must be a text in quotes, not {}.", kind_of(node)));
    if (node.get_ref<const std::string&>().empty()) {
      refuse("is empty; name something or leave the key out.");
    }
    value = node.get<std::string>();
  }
};

void Kind<std::array<bool, 3>>::read(const Json& node, const NumberRange& range,
                                     const Refusal& refuse, std::array<bool, 3>& value) {
  std::string letters;
  Kind<std::string>::read(node, range, refuse, letters);
  value.fill(false);
  for (const char letter : letters) {
    if (letter < 'x' || letter > 'z' || value[static_cast<std::size_t>(letter - 'x')]) {
      refuse(fmt::format("= {} must name some of x, y and z, each once, for instance \"xz\".",
                         in_quotes(letters)));
    }
    value[static_cast<std::size_t>(letter - 'x')] = true;
  }
}

template <>
struct Kind<std::vector<std::int64_t>> : Unchecked {
  static constexpr const char* kType = "list of whole numbers";
  static Json json(const std::vector<std::int64_t>& value) { return value; }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse,
                   std::vector<std::int64_t>& value) {
    value.clear();
    for (const Json& entry : list_of(node, 0, "[0, 12, 40]", refuse)) {
      value.push_back(integer_of(entry, 0, kMostInteger, refuse, true));
    }
  }
};

// Two vertices.
template <>
struct Kind<std::array<std::int64_t, 2>> {
  static constexpr const char* kType = "two whole numbers";
  static constexpr const char* kRule = "must name two different vertices, like [3, 40].";
  static Json json(const std::array<std::int64_t, 2>& value) { return value; }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::array<std::int64_t, 2>& value) {
    std::vector<std::int64_t> pair;
    Kind<std::vector<std::int64_t>>::read(node, range, refuse, pair);
    if (pair.size() != 2 || pair[0] == pair[1]) refuse(kRule);
    value = {pair[0], pair[1]};
  }
  static void check(const std::array<std::int64_t, 2>& value, const NumberRange&,
                    const std::string& name) {
    if (value[0] == value[1]) throw InputError(fmt::format("{} {}", name, kRule));
  }
};

template <>
struct Kind<std::vector<Vector3>> {
  static constexpr const char* kType = "list of three numbers each";
  static Json json(const std::vector<Vector3>& value) {
    Json list;
    for (const Vector3& entry : value) list.push_back(Kind<Vector3>::json(entry));
    return list;
  }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::vector<Vector3>& value) {
    value.clear();
    for (const Json& entry : list_of(node, 0, "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]", refuse)) {
      read_three(entry, range, refuse, value.emplace_back());
    }
  }
  static void check(const std::vector<Vector3>& value, const NumberRange& range,
                    const std::string& name) {
    for (const Vector3& entry : value) Kind<Vector3>::check(entry, range, name);
  }
};

template <>
struct Kind<std::vector<std::pair<double, double>>> : Unchecked {
  static constexpr const char* kType = "list of two numbers each";
  static Json json(const std::vector<std::pair<double, double>>& value) {
    return value.empty() ? Json() : Json(value);
  }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::vector<std::pair<double, double>>& value) {
    value.clear();
    for (const Json& entry : list_of(node, 0, "[[0.0, 0.0], [1.0, 2.5]]", refuse)) {
      list_of(entry, 2, "[1.0, 2.5]", refuse);
      const double first = number_of(entry[0], range, refuse, true);
      value.emplace_back(first, number_of(entry[1], range, refuse, true));
    }
  }
};

template <>
struct Kind<std::vector<std::string>> : Unchecked {
  static constexpr const char* kType = "list of texts";
  static Json json(const std::vector<std::string>& value) {
    return value.empty() ? Json() : Json(value);
  }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse,
                   std::vector<std::string>& value) {
    value.clear();
    for (const Json& entry : list_of(node, 0, "[\"a\", \"b\"]", refuse)) {
      if (!entry.is_string()) {
        refuse(fmt::format("must be a list of texts in quotes, not {}.", kind_of(entry)));
      }
      value.push_back(entry.get<std::string>());
    }
  }
};

// Three formulas.
template <>
struct Kind<std::array<std::string, 3>> : Unchecked {
  static constexpr const char* kType = "list of texts";
  static Json json(const std::array<std::string, 3>& value) {
    return value[0].empty() ? Json() : Json(value);
  }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::array<std::string, 3>& value) {
    std::vector<std::string> texts;
    Kind<std::vector<std::string>>::read(node, range, refuse, texts);
    if (texts.size() != 3 || std::find(texts.begin(), texts.end(), "") != texts.end()) {
      refuse("must have three texts that are not empty: one each for x, y and z.");
    }
    std::move(texts.begin(), texts.end(), value.begin());
  }
};

}  // namespace

template <class T>
std::string ValueKind<T>::type() {
  return Kind<T>::kType;
}
template <class T>
Json ValueKind<T>::json(const T& value) {
  return Kind<T>::json(value);
}
template <class T>
void ValueKind<T>::read(const Json& node, const NumberRange& range, const Refusal& refuse,
                        T& value) {
  Kind<T>::read(node, range, refuse, value);
}
template <class T>
void ValueKind<T>::check(const T& value, const NumberRange& range, const std::string& name) {
  Kind<T>::check(value, range, name);
}

template struct ValueKind<bool>;
template struct ValueKind<int>;
template struct ValueKind<double>;
template struct ValueKind<Vector3>;
template struct ValueKind<std::array<double, 2>>;
template struct ValueKind<std::array<int, 3>>;
template struct ValueKind<std::array<bool, 3>>;
template struct ValueKind<std::array<std::int64_t, 2>>;
template struct ValueKind<std::array<std::string, 3>>;
template struct ValueKind<std::string>;
template struct ValueKind<std::vector<std::int64_t>>;
template struct ValueKind<std::vector<Vector3>>;
template struct ValueKind<std::vector<std::pair<double, double>>>;
template struct ValueKind<std::vector<std::string>>;

std::string read_name(const Json& node, const Refusal& refuse,
                      const std::vector<const char*>& names) {
  std::string word;
  Kind<std::string>::read(node, kFinite, refuse, word);
  const NameList valid(names.begin(), names.end());
  if (std::find(valid.begin(), valid.end(), word) == valid.end()) {
    refuse(fmt::format("= {} is unknown: {}", in_quotes(word), advice(word, valid)));
  }
  return word;
}

void refuse_word(const std::string& word, const NumberRange& range, const Refusal& refuse) {
  refuse(fmt::format("= {} must be a number of seconds {}, or \"auto\".", in_quotes(word),
                     range.text()));
}

std::string list_type(int most, bool takes_number) {
  if (most == 0) return "number or array";
  const std::string list = fmt::format("list of 1 to {} numbers or arrays", most);
  return takes_number ? "number or array, or " + list : list;
}

void check_list(const Json& node, int most, const Refusal& refuse) {
  if (!node.is_array()) {
    refuse(
        fmt::format("must be a list of 1 to {} numbers or arrays, not {}.", most, kind_of(node)));
  }
  if (node.empty() || node.size() > static_cast<std::size_t>(most)) {
    refuse(fmt::format("has {} entries; it must have 1 to {}.", node.size(), most));
  }
}

std::string array_of(const Json& entry, const Refusal& refuse) {
  if (entry.size() != 1 || !entry.contains("array") || !entry["array"].is_string() ||
      entry["array"].get_ref<const std::string&>().empty()) {
    refuse(
        "has a table as an entry; it must be { array = \"NAME\" } with the name of a cell array "
        "of the mesh file.");
  }
  return entry["array"].get<std::string>();
}

double entry_of(const Json& entry, const NumberRange& range, const Refusal& refuse) {
  return number_of(entry, range, refuse, true);
}

void check_field(const FieldSettings& field, const std::string& name) {
  if (field.file.empty() || field.formula[0].empty()) return;
  throw InputError(name + " has both a file and a formula; give one of them.");
}

}  // namespace tetraction
