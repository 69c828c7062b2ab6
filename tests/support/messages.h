#pragma once
/// \file
/// What is said of bad input.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "micro/core/error.h"

namespace trame::test {

/// What is thrown as InputError by `action`; empty where nothing is.
template <class Action>
std::string input_error(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

inline void expect_mentions(const std::string& text, const std::vector<std::string>& fragments) {
  for (const std::string& fragment : fragments)
    EXPECT_NE(text.find(fragment), std::string::npos) << fragment << "\nin: " << text;
}

}  // namespace trame::test
