#pragma once
/// \file
/// Files that are whole or not there: written under another name and renamed.

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "micro/core/error.h"

namespace trame::micro {

/// Name under which a file is written before it is whole.
[[nodiscard]] inline std::filesystem::path part_of(std::filesystem::path file) { return file += ".part"; }

/// Takes away what was begun of `file`, and says why. `error_number`: 0 where it is not known.
[[noreturn]] inline void fail_to_write(const std::filesystem::path& file, int error_number) {
  std::error_code ignored;
  std::filesystem::remove(part_of(file), ignored);
  throw WriteError(fmt::format("{}: cannot be written: {}", file.string(),
                               error_number != 0 ? std::strerror(error_number) : "is the disk full?"));
}

/// Gives the file that was written as `part_of(file)` its name. Throws WriteError.
inline void put_in_place(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(part_of(file), file, error);
  if (error) fail_to_write(file, error.value());
}

/// Writes `text` so that a reader never meets half a file. Throws WriteError.
inline void write_whole_file(const std::filesystem::path& file, const std::string& text) {
  errno = 0;
  std::ofstream stream(part_of(file), std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) fail_to_write(file, errno);
  put_in_place(file);
}

/// Why a file cannot grow by `bytes`; empty where it can. On file systems that can do so the room is set aside, so that
/// nobody else takes it.
[[nodiscard]] inline std::string lack_of_room(int descriptor, std::int64_t size, std::int64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      size + bytes > static_cast<std::int64_t>(limit.rlim_cur))
    return fmt::format("files may not grow beyond {} bytes (ulimit -f)", limit.rlim_cur);
  while (fallocate(descriptor, FALLOC_FL_KEEP_SIZE, size, bytes) != 0) {
    if (errno == EINTR) continue;
    if (is_lack_of_space(errno)) return std::strerror(errno);
    struct statvfs disk {};  // a file system that cannot set room aside
    const bool is_known = fstatvfs(descriptor, &disk) == 0 && disk.f_blocks > 0;
    if (is_known &&
        static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) < static_cast<double>(bytes))
      return std::strerror(ENOSPC);
    break;
  }
  return {};
}

/// Gives back what `lack_of_room` has set aside behind the end of a file.
inline void give_back_room(int descriptor, std::int64_t size, std::int64_t bytes) {
  [[maybe_unused]] const int result = fallocate(descriptor, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, size, bytes);
}

}  // namespace trame::micro
