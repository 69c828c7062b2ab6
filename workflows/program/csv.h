#pragma once
/// \file
/// The one writer of our CSV tables.

#include <filesystem>
#include <sstream>
#include <string>
#include <utility>

#include "micro/core/whole_file.h"

namespace trame::workflows {

/// A field of a CSV table by RFC 4180: quoted where it holds a comma, a quote or a line break.
[[nodiscard]] inline std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

/// A table under way: rows are streamed into it, names through `csv_field`.
class CsvFile {
 public:
  CsvFile(std::filesystem::path file, const std::string& header) : file_(std::move(file)) { rows_ << header << '\n'; }

  template <class T>
  CsvFile& operator<<(const T& text) {
    rows_ << text;
    return *this;
  }
  /// Writes all rows so far; a reader never meets half a table. Throws WriteError.
  void write() const { micro::write_whole_file(file_, rows_.str()); }

 private:
  std::filesystem::path file_;
  std::ostringstream rows_;
};

}  // namespace trame::workflows
