#pragma once
/// \file
/// A folder for what lies between two programs, or for the files of one test.

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace trame::workflows {

/// An empty folder that is gone when the object is. Throws std::runtime_error where none can be made.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // TMPDIR may name what is not there, on a node of a cluster for example.
    std::error_code none;
    for (const std::filesystem::path& place :
         {std::filesystem::temp_directory_path(none), std::filesystem::path("/tmp"), std::filesystem::path("/var/tmp"),
          std::filesystem::path(".")}) {
      std::string pattern = std::filesystem::absolute(place / "trame-XXXXXX", none).string();
      if (place.empty() || mkdtemp(pattern.data()) == nullptr) continue;
      path_ = pattern;
      return;
    }
    throw std::runtime_error("no temporary folder can be made, neither in TMPDIR nor in /tmp, /var/tmp and here");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace trame::workflows
