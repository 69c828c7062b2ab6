#pragma once
/// \file
/// The folder that a run writes to, and the names of everything in it.

#include <filesystem>
#include <memory>
#include <string>

#include "micro/io/whole_file.h"
#include "workflows/folder_lock.h"

namespace trame::workflows {

using micro::write_whole_file;

/// An existing, writable folder that holds no file of ours yet.
class OutputDirectory {
 public:
  /// Makes `root` ready, and this process the only one of ours that writes into it. A folder that holds anything is
  /// refused unless `overwrite`, which removes the files that a run writes and leaves all others alone. Throws
  /// InputError for what cannot be created, written or overwritten, WriteError for a full disk.
  OutputDirectory(const std::filesystem::path& root, bool overwrite);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path states() const { return root_ / "states.h5"; }
  [[nodiscard]] std::filesystem::path summary() const { return root_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path curves() const { return root_ / "curves.csv"; }
  [[nodiscard]] std::filesystem::path report() const { return root_ / "report.html"; }
  [[nodiscard]] std::filesystem::path vtk() const { return root_ / "vtk"; }

 private:
  std::filesystem::path root_;
  std::unique_ptr<FolderLock> lock_;
};

/// Whether a run writes a file of this name, relative to the output folder.
[[nodiscard]] bool is_run_output(const std::string& relative_path);

}  // namespace trame::workflows
