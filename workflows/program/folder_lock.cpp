#include "workflows/program/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string>

#include "micro/core/error.h"

namespace trame::workflows {

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

/// Who a lock file says has written it.
struct Holder {
  pid_t process = 0;
  std::string host;
};

Holder holder_of(const std::filesystem::path& file) {
  Holder holder;
  std::ifstream(file) >> holder.process >> holder.host;
  return holder;
}

[[noreturn]] void refuse(const std::string& option, const std::filesystem::path& folder, const Holder& holder) {
  const std::string who = holder.process > 0 ? fmt::format("process {} on {}", holder.process, holder.host)
                                             : std::string("another process");
  throw InputError(fmt::format("{} {}: {} is writing into it; wait for its end, or choose another folder", option,
                               folder.string(), who));
}

/// Whether the process may still be there. That of another machine may.
bool may_be_alive(const Holder& holder) {
  if (holder.process <= 0 || holder.process == getpid()) return false;
  return holder.host != host_name() || kill(holder.process, 0) == 0 || errno == EPERM;
}

}  // namespace

FolderLock::FolderLock(const std::string& option, const std::filesystem::path& folder) : file_(folder / file_name) {
  while (true) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && is_lack_of_space(errno))
      throw WriteError(fmt::format("{} {}: cannot be written to: {}", option, folder.string(), std::strerror(errno)));
    if (descriptor_ < 0) return;  // whoever writes results will say what is wrong
    const Holder before = holder_of(file_);
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const bool is_taken = errno == EWOULDBLOCK || (errno != EINTR && may_be_alive(before));
      if (is_taken) {
        close(descriptor_);
        refuse(option, folder, before);
      }
    }
    // The one who held it may have removed the file between our opening it and locking it.
    struct stat ours {
    }, named{};
    if (fstat(descriptor_, &ours) == 0 && stat(file_.c_str(), &named) == 0 && ours.st_ino == named.st_ino) break;
    close(descriptor_);
  }
  const std::string text = fmt::format("{} {}\n", getpid(), host_name());
  [[maybe_unused]] const bool told =
      ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) > 0;
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  unlink(file_.c_str());
  close(descriptor_);
}

}  // namespace trame::workflows
