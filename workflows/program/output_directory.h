#pragma once
/// \file
/// The folder that a run writes to, and the names of everything in it.

#include <filesystem>
#include <memory>
#include <string>

#include "micro/core/whole_file.h"
#include "workflows/program/folder_lock.h"

namespace trame::workflows {

using micro::write_whole_file;

/// Where a run into `folder` saves its states.
[[nodiscard]] inline std::filesystem::path states_in(const std::filesystem::path& folder) {
  return folder / "states.h5";
}

/// An existing, writable folder.
class OutputDirectory {
 public:
  /// What becomes of the files of an earlier run: a folder that holds anything is refused; the files that a run writes
  /// are removed, all others left alone; they stay, for a run that goes on.
  enum class Earlier : std::uint8_t { refused, removed, kept };

  /// Makes `root` ready, and this process the only one of ours that writes into it. Throws InputError for what cannot
  /// be created, written or overwritten, WriteError for a full disk.
  OutputDirectory(const std::filesystem::path& root, Earlier earlier);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path states() const { return states_in(root_); }
  [[nodiscard]] std::filesystem::path summary() const { return root_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path curves() const { return root_ / "curves.csv"; }
  [[nodiscard]] std::filesystem::path branches() const { return root_ / "branches.csv"; }
  [[nodiscard]] std::filesystem::path report() const { return root_ / "report.html"; }
  [[nodiscard]] std::filesystem::path vtk() const { return root_ / "vtk"; }

 private:
  std::filesystem::path root_;
  std::unique_ptr<FolderLock> lock_;
};

/// Whether a run writes a file of this name, relative to the output folder.
[[nodiscard]] bool is_run_output(const std::string& relative_path);

}  // namespace trame::workflows
