#pragma once
/// \file
/// How failures travel: `InputError` for what the user can mend (exit code 2). An increment that no cut could save is
/// no exception but a status of the run (exit code 3). Programmer errors are asserts.

#include <stdexcept>
#include <string>

namespace trame {

/// Bad input: the message names the file, the key, the value and what is allowed.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace trame
