// Messages of errors.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tetraction/core/error.h"

namespace tetraction::testing_support {

/// The message of the error that the action throws, or `otherwise` if it throws none.
template <class Error = InputError, class Action>
std::string message_of(const Action& action, const std::string& otherwise = "accepted") {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return otherwise;
}

/// Expects that a text has a part.
inline void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "\nhas no " << part;
}

/// Expects that the action throws an error whose message has all these parts.
template <class Error = InputError, class Action>
void expect_error(const Action& action, const std::vector<std::string>& parts) {
  const std::string message = message_of<Error>(action, "");
  for (const std::string& part : parts) expect_part(message, part);
}

}  // namespace tetraction::testing_support
