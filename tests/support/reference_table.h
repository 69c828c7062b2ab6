#pragma once
/// \file
/// Published numbers in data/reference: CSV with the source in comment lines.

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace trame::test {

/// Rows of numbers of data/reference/<name>.csv. Lines that start with # and the line of column names are passed over.
inline std::vector<std::vector<double>> reference_table(const std::string& name) {
  const std::string path = std::string(TRAME_DATA_DIR) + "/reference/" + name + ".csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("missing reference " + path);
  std::vector<std::vector<double>> rows;
  bool names_read = false;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (!names_read) {
      names_read = true;
      continue;
    }
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

}  // namespace trame::test
