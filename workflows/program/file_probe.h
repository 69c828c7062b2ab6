#pragma once
/// \file
/// A guard against files that bring down what reads them.

#include <filesystem>
#include <functional>
#include <string>

namespace trame::workflows {

/// Seconds of computing that a reading of `file` may take: many times what it takes from a slow disk.
[[nodiscard]] unsigned seconds_to_read(const std::filesystem::path& file);

/// Runs `read` in a child process: HDF5 follows damaged pointers of a file into crashes and endless loops, which no
/// check of ours can foresee. Throws InputError that names `file` if the child ends by a signal, computes for more than
/// `seconds`, or waits for much longer than that. What `read` throws or prints is for the next reading, in this
/// process, to tell. To be called while the process has one thread.
void probe(const std::filesystem::path& file, const std::function<void()>& read, unsigned seconds);
inline void probe(const std::filesystem::path& file, const std::function<void()>& read) {
  probe(file, read, seconds_to_read(file));
}

/// To be called by `read` in the child: it may compute for so many seconds from now on, whatever it took up to here.
void allow_seconds(unsigned seconds);

}  // namespace trame::workflows
