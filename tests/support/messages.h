// Messages of errors.
#pragma once

#include <gtest/gtest.h>

#include <string>

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

inline void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "\nhas no " << part;
}

}  // namespace tetraction::testing_support
