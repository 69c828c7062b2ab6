#pragma once
/// \file
/// The folder that a run writes to, and the names of everything in it.

#include <filesystem>
#include <string>

namespace trame::workflows {

/// An existing, writable folder that holds no file of ours yet.
class OutputDirectory {
 public:
  /// Makes `root` ready. A folder that holds anything is refused unless `overwrite`, which removes the files that a run
  /// writes and leaves all others alone. Throws InputError for what cannot be created, written or overwritten.
  OutputDirectory(const std::filesystem::path& root, bool overwrite);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path states() const { return root_ / "states.h5"; }
  [[nodiscard]] std::filesystem::path summary() const { return root_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path curves() const { return root_ / "curves.csv"; }
  [[nodiscard]] std::filesystem::path report() const { return root_ / "report.html"; }
  [[nodiscard]] std::filesystem::path vtk() const { return root_ / "vtk"; }

 private:
  std::filesystem::path root_;
};

/// Whether a run writes a file of this name, relative to the output folder.
[[nodiscard]] bool is_run_output(const std::string& relative_path);

/// Writes `text` under a temporary name beside `file` and renames it, so that a reader never meets half a file.
/// Throws std::runtime_error where that fails.
void write_whole_file(const std::filesystem::path& file, const std::string& text);

}  // namespace trame::workflows
