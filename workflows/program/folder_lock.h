#pragma once
/// \file
/// One writer a folder.

#include <filesystem>
#include <string>

namespace trame::workflows {

/// While alive, keeps other processes of ours from writing into a folder. A process that dies gives it up.
class FolderLock {
 public:
  /// Name of the file in the folder that says who writes.
  static constexpr const char* file_name = ".trame.lock";

  /// `option`: what messages begin with. Throws InputError where another process writes into `folder`, WriteError where
  /// there is no room for the file. A file system without locks goes by the process that the file names.
  FolderLock(const std::string& option, const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace trame::workflows
