#include "formula.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <numbers>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {

struct Formula::Impl {
  mu::Parser parser;
  std::vector<double> values;
};

namespace {

[[noreturn]] void refuse(const std::string& text, int position, const std::string& what) {
  throw InputError(position < 0
                       ? fmt::format("{}: {}", in_quotes(text), what)
                       : fmt::format("{}, character {}: {}", in_quotes(text),
                                     std::min(position, static_cast<int>(text.size())) + 1, what));
}

std::string text_of(const mu::Parser::exception_type& error) {
  const std::string& token = error.GetToken();
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN:
      return fmt::format("{} is not a variable, a function or a number.", in_quotes(token));
    case mu::ecUNEXPECTED_EOF:
      return "the formula ends too early.";
    case mu::ecMISSING_PARENS:
      return "a closing parenthesis is missing.";
    case mu::ecUNEXPECTED_PARENS:
      return "a parenthesis is in a wrong place.";
    case mu::ecTOO_FEW_PARAMS:
      return fmt::format("the function {} has too few arguments.", in_quotes(token));
    case mu::ecTOO_MANY_PARAMS:
      return fmt::format("the function {} has too many arguments.", in_quotes(token));
    case mu::ecMISSING_ELSE_CLAUSE:
      return "a ? has no : after it.";
    case mu::ecEXPRESSION_TOO_LONG:
      return "the formula is too long.";
    default:
      return token.empty() ? "the formula cannot be read."
                           : fmt::format("{} does not fit here.", in_quotes(token));
  }
}

}  // namespace

Formula::Formula(const std::string& text, const std::vector<std::string>& variables)
    : impl_(std::make_unique<Impl>()) {
  constexpr std::size_t kLongest = 4000;
  if (text.size() > kLongest) {
    throw InputError(
        fmt::format("the formula has {} characters, and {} are the most.", text.size(), kLongest));
  }
  if (text.find('\0') != std::string::npos) {
    throw InputError("the formula has a character with the code zero in it.");
  }
  // muParser would take "X = 1" as an assignment.
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool is_second = i > 0 && std::string("=<>!").find(text[i - 1]) != std::string::npos;
    const bool is_first = i + 1 < text.size() && text[i + 1] == '=';
    if (!is_second && !is_first) {
      refuse(text, static_cast<int>(i), "a formula has no \"=\"; for a comparison write \"==\".");
    }
  }
  impl_->values.assign(variables.size(), 0.5);
  try {
    for (std::size_t i = 0; i < variables.size(); ++i) {
      impl_->parser.DefineVar(variables[i], &impl_->values[i]);
    }
    impl_->parser.DefineConst("pi", std::numbers::pi);
    impl_->parser.SetExpr(text);
    impl_->parser.Eval();
    if (impl_->parser.GetNumResults() != 1) {
      refuse(text, static_cast<int>(text.find(',')), "a comma does not fit here.");
    }
  } catch (const mu::Parser::exception_type& error) {
    refuse(text, static_cast<int>(error.GetPos()), text_of(error));
  }
}

Formula::~Formula() = default;
Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;

double Formula::operator()(const std::vector<double>& values) const {
  std::copy(values.begin(), values.end(), impl_->values.begin());
  return impl_->parser.Eval();
}

}  // namespace tetraction
