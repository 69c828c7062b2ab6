#pragma once
/// \file
/// The figure that a hard case is judged by.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace trame::micro::test {

/// Notes the figure: a line for the terminal, from which the table in tests/hard_cases/README.md is made, and a
/// property in the XML report.
inline void measured(const std::string& figure) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  fmt::print("measured | {}.{} | {}\n", test->test_suite_name(), test->name(), figure);
  ::testing::Test::RecordProperty("measured", figure);
}

}  // namespace trame::micro::test
