#pragma once
/// \file
/// What a file of fiber nodes must be, whatever is in it: fibers whose positions are finite, or an InputError that
/// names the file.

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "micro/core/error.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::test {

/// A file of this process in the folder for temporary files.
inline std::filesystem::path fuzzed_file(const std::string& ending) {
  return std::filesystem::temp_directory_path() / ("trame-fuzz-" + std::to_string(getpid()) + ending);
}

inline void write_bytes(const std::filesystem::path& file, const std::uint8_t* data, std::size_t size) {
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
}

inline void read_nodes(const std::filesystem::path& file) {
  try {
    const auto states = workflows::open_states({file});
    const auto n_nodes = static_cast<std::size_t>(states->header().mesh.n_nodes());
    for (Index i = 0; i < states->n_increments(); ++i) {
      const std::vector<Vec3> positions = states->read(i).fibers.r;
      const bool finite = std::ranges::all_of(positions, [](const Vec3& r) { return r.allFinite(); });
      if (!finite || positions.size() != n_nodes) std::abort();
    }
  } catch (const InputError& error) {  // what is meant
    if (std::string(error.what()).find(file.string()) == std::string::npos) std::abort();
  }
}

}  // namespace trame::test
