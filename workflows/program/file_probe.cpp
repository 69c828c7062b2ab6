#include "workflows/program/file_probe.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>

#include "micro/core/error.h"

namespace trame::workflows {
namespace {

/// Seconds on the clock for each of computing: the machine may be busy.
constexpr unsigned wall_factor = 5;

[[noreturn]] void read_and_exit(const std::function<void()>& read, unsigned seconds) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  allow_seconds(seconds);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) dup2(open("/dev/null", O_WRONLY), descriptor);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGXCPU, SIGALRM}) std::signal(signal, SIG_DFL);
  try {
    read();
  } catch (...) {  // told by the reading in the parent
  }
  _exit(0);
}

}  // namespace

void allow_seconds(unsigned seconds) {
  // What waits for ever computes nothing: a pipe, a network file system that does not answer.
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const rlim_t spent = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  rlimit time{};
  getrlimit(RLIMIT_CPU, &time);
  time.rlim_cur = std::min<rlim_t>(spent + seconds, time.rlim_max);
  setrlimit(RLIMIT_CPU, &time);
  alarm(wall_factor * seconds);
}

unsigned seconds_to_read(const std::filesystem::path& file) {
  constexpr unsigned least = 15, longest = 3600;
  constexpr double bytes_a_second = 5e6;
  std::error_code none;
  const double bytes = static_cast<double>(std::filesystem::file_size(file, none));
  return least + (none ? 0 : static_cast<unsigned>(std::min<double>(longest, bytes / bytes_a_second)));
}

void probe(const std::filesystem::path& file, const std::function<void()>& read, unsigned seconds) {
  const std::string name = file.string();
  const pid_t child = fork();
  if (child < 0) return;  // no process to be had: then without the guard
  if (child == 0) read_and_exit(read, seconds);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFSIGNALED(status)) return;
  if (WTERMSIG(status) == SIGALRM)
    throw InputError(
        fmt::format("{}: cannot be read: reading it does not end within {} s", name, wall_factor * seconds));
  if (WTERMSIG(status) == SIGXCPU)
    throw InputError(fmt::format("{}: damaged: reading it does not end within {} s", name, seconds));
  throw InputError(fmt::format("{}: damaged: reading it crashes (signal {})", name, WTERMSIG(status)));
}

}  // namespace trame::workflows
