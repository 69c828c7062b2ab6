#pragma once
/// \file
/// How failures travel: `InputError` for what the user can mend (exit code 2), `WriteError` for results that could not
/// be written (exit code 3). A solver that gives up is an outcome, not an exception. Programmer errors are asserts.

#include <cerrno>
#include <stdexcept>
#include <string>

namespace trame {

/// Bad input: the message names the file, the key, the value and what is allowed.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file cannot be written any further, most often because the disk is full: the message names the file, says what of
/// it is whole, and how to go on.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What has been written is gone: there is nothing left to go on from.
class LostError : public WriteError {
 public:
  using WriteError::WriteError;
};

/// Whether `error_number` says that there is no room: of the disk, of a quota, of a limit for files.
[[nodiscard]] inline bool is_lack_of_space(int error_number) {
  return error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
}

}  // namespace trame
