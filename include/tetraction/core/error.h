// The exceptions of the library. Bad input throws an exception. Numerical outcomes such as no
// convergence or an inverted element are returned as a status. The library neither prints nor exits.
#pragma once

#include <stdexcept>
#include <string>

namespace tetraction {

/// Base class of the exceptions of the library. what() says what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A wrong value given by the user or the calling program (command line, scene, argument).
/// The program exits with code 2.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A computation that must succeed before a run can begin failed numerically, such as the search for
/// the equilibrium that it starts from (exit code 1).
class NumericalError : public Error {
 public:
  using Error::Error;
};

/// A file is missing, unreadable or malformed, or holds a mesh that is refused (exit code 3).
class FileError : public Error {
 public:
  using Error::Error;
};

/// Output cannot be written (exit code 4).
class OutputError : public Error {
 public:
  using Error::Error;
};

}  // namespace tetraction
