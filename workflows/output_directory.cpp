#include "workflows/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <regex>
#include <stdexcept>
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

void make_ready(const fs::path& root, bool overwrite) {
  if (fs::exists(root) && !fs::is_directory(root))
    throw InputError(fmt::format("--out {}: is a file; must be a folder, or not exist yet", root.string()));
  fs::create_directories(root);
  if (access(root.c_str(), W_OK | X_OK) != 0)
    throw InputError(
        fmt::format("--out {}: cannot be written to; must be a folder with write permission", root.string()));
  if (overwrite)
    remove_run_outputs(root);
  else if (!fs::is_empty(root))
    throw InputError(
        fmt::format("--out {}: is not empty; must be a new or empty folder, unless --overwrite is given, "
                    "which replaces the files of an earlier run",
                    root.string()));
}

}  // namespace

bool is_run_output(const std::string& relative_path) {
  static const std::regex names(R"(states\.h5|report\.html)"
                                R"(|(summary\.json|curves\.csv|curves\.gp|curves\.svg)(\.part)?)"
                                R"(|vtk/(fibers|yarns)(\.pvd|_[0-9]+\.vt[pu]))");
  return std::regex_match(relative_path, names);
}

OutputDirectory::OutputDirectory(const fs::path& root, bool overwrite) : root_(root) {
  try {
    make_ready(root_, overwrite);
  } catch (const fs::filesystem_error& error) {
    throw InputError(fmt::format("--out {}: cannot be used ({}); must be a folder that can be created and written to",
                                 root.string(), error.code().message()));
  }
}

void write_whole_file(const fs::path& file, const std::string& text) {
  fs::path part = file;
  part += ".part";
  std::ofstream stream(part, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: could not be written; is the disk full?", part.string()));
  fs::rename(part, file);
}

}  // namespace trame::workflows
