#pragma once
/// \file
/// Any bytes as a file of fiber nodes: fibers whose positions are finite, or an InputError.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "micro/core/error.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::test {

/// Reads the bytes as the only state of `ending`, .vtp or .csv.
inline int read_as_nodes(const std::uint8_t* data, std::size_t size, const char* ending) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("trame-fuzz-" + std::to_string(getpid()) + ending);
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const auto states = workflows::open_states({file});
    const micro::Increment state = states->read(0);
    for (const Vec3& r : state.fibers.r)
      if (!r.allFinite()) std::abort();
    if (state.fibers.r.size() != static_cast<std::size_t>(states->header().mesh.n_nodes())) std::abort();
  } catch (const InputError&) {  // what is meant
  }
  return 0;
}

}  // namespace trame::test
