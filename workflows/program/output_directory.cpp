#include "workflows/program/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <regex>
#include <vector>

#include "micro/core/error.h"

namespace trame::workflows {

namespace fs = std::filesystem;

namespace {

void remove_run_outputs(const fs::path& root) {
  std::vector<fs::path> ours;
  for (const fs::path& folder : {root, root / "vtk"}) {
    if (!fs::is_directory(folder)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (!entry.is_directory() && is_run_output(entry.path().lexically_relative(root).generic_string()))
        ours.push_back(entry.path());
  }
  for (const fs::path& file : ours) fs::remove(file);
}

bool is_empty_but_for_the_lock(const fs::path& folder) {
  const fs::directory_iterator entries(folder);
  return std::all_of(begin(entries), end(entries),
                     [](const fs::directory_entry& entry) { return entry.path().filename() == FolderLock::file_name; });
}

std::unique_ptr<FolderLock> make_ready(const fs::path& root, OutputDirectory::Earlier earlier) {
  if (fs::exists(root) && !fs::is_directory(root))
    throw InputError(fmt::format("--out {}: is a file; must be a folder, or not exist yet", root.string()));
  fs::create_directories(root);
  if (access(root.c_str(), W_OK | X_OK) != 0)
    throw InputError(
        fmt::format("--out {}: cannot be written to; must be a folder with write permission", root.string()));
  auto lock = std::make_unique<FolderLock>("--out", root);
  if (earlier == OutputDirectory::Earlier::removed)
    remove_run_outputs(root);
  else if (earlier == OutputDirectory::Earlier::refused && !is_empty_but_for_the_lock(root))
    throw InputError(
        fmt::format("--out {}: is not empty; must be a new or empty folder, unless --overwrite is given, "
                    "which replaces the files of an earlier run, or --resume, which goes on with it",
                    root.string()));
  return lock;
}

}  // namespace

bool is_run_output(const std::string& relative_path) {
  static const std::regex names(
      R"((states\.h5|report\.html|summary\.json|curves\.csv|branches\.csv|curves\.gp|curves\.svg)"
      R"(|vtk/(fibers|yarns|surfaces)(\.pvd|_[0-9]+\.vt[pu]))(\.part)?)");
  return std::regex_match(relative_path, names);
}

OutputDirectory::OutputDirectory(const fs::path& root, Earlier earlier) : root_(root) {
  try {
    lock_ = make_ready(root_, earlier);
  } catch (const fs::filesystem_error& error) {
    if (is_lack_of_space(error.code().value()))
      throw WriteError(fmt::format("--out {}: cannot be written to: {}", root.string(), error.code().message()));
    throw InputError(fmt::format("--out {}: cannot be used ({}); must be a folder that can be created and written to",
                                 root.string(), error.code().message()));
  }
}

}  // namespace trame::workflows
