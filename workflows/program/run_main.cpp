#include "workflows/program/run_main.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <omp.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "micro/core/error.h"
#include "micro/core/quantity.h"
#include "micro/core/text.h"
#include "workflows/program/environment.h"

namespace trame::workflows {

namespace {

/// A file of results would else get the number of a closed stream, and what is printed would go into it.
void open_standard_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0 && open("/dev/null", O_RDWR) != descriptor) _exit(exit_unexpected);
}

bool is_address_space_limited() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

/// A shell may leave no stack that is worth the name (ulimit -s 128), to threads neither: they get what is usual, and
/// so does the program where it may. Throws InputError where it has too little.
void take_stack() {
  constexpr rlim_t usual = 8 << 20, least = 512 << 10;
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= usual) return;
  limit.rlim_cur = std::min(usual, limit.rlim_max);
  setrlimit(RLIMIT_STACK, &limit);
  pthread_attr_t of_threads;
  pthread_attr_init(&of_threads);
  pthread_attr_setstacksize(&of_threads, usual);
  pthread_setattr_default_np(&of_threads);
  pthread_attr_destroy(&of_threads);
  if (limit.rlim_cur < least)
    throw InputError(fmt::format("ulimit -s {}: so little stack does not do; must be at least {}", limit.rlim_cur >> 10,
                                 least >> 10));
}

/// The lines of a message; what it quotes does not steer the terminal.
std::string shown(const std::string& message) {
  std::string text;
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) text += printable(line) + '\n';
  return text;
}

/// Never fails: there may be no one to tell it to.
int tell(const std::string& program, const std::string& message, int code) {
  std::fflush(stdout);
  std::fputs((program + ": " + shown(message)).c_str(), stderr);
  return code;
}

constexpr const char* no_memory = "there is not enough memory for what is asked for";

/// The end of the exception that is being handled.
int tell_exception(const std::string& program) {
  try {
    throw;
  } catch (const InputError& error) {
    return tell(program, error.what(), exit_bad_input);
  } catch (const WriteError& error) {
    return tell(program, error.what(), exit_ended_early);
  } catch (const NoUnits& error) {
    return tell(program, error.what(), exit_ended_early);
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string message = fmt::format("{}: {}", error.path1().string(), error.code().message());
    return tell(program, message, is_lack_of_space(error.code().value()) ? exit_ended_early : exit_bad_input);
  } catch (const std::system_error& error) {  // standard output: its reader has seen enough, or its disk is full
    if (error.code().value() == EPIPE) return exit_done;
    return tell(program, error.what(), is_lack_of_space(error.code().value()) ? exit_ended_early : exit_unexpected);
  } catch (const std::bad_alloc&) {
    return tell(program, no_memory, exit_bad_input);
  } catch (const std::length_error&) {  // the same, where the size is beyond all measure
    return tell(program, no_memory, exit_bad_input);
  } catch (const std::exception& error) {
    return tell(program, fmt::format("unexpected failure: {}", error.what()), exit_unexpected);
  } catch (...) {
    return tell(program, "unexpected failure", exit_unexpected);
  }
}

/// The OpenMP library does not survive any number.
void check_number_of_threads() {
  constexpr int most = 1024;
  if (const int n = omp_get_max_threads(); n > most)
    throw InputError(fmt::format("OMP_NUM_THREADS = {}: must be at most {}", n, most));
}

/// A list that is cut because its disk is full is no list.
void flush_standard_output() {
  if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category(), "standard output");
}

std::string running_program = "trame";

/// Threads cannot hand their exceptions on. What a run has saved up to here is whole.
[[noreturn]] void end_of_a_thread() {
  const int code = std::current_exception() ? tell_exception(running_program)
                                            : tell(running_program, "unexpected failure", exit_unexpected);
  _exit(code == exit_bad_input ? exit_ended_early : code);
}

}  // namespace

int run_main(const std::string& program, char** argv, const std::function<int()>& body) {
  open_standard_streams();
  if (is_address_space_limited()) prepare_blas(argv);
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  running_program = program;
  std::set_terminate(end_of_a_thread);
  try {
    take_stack();
    check_number_of_threads();
    const int code = body();
    flush_standard_output();
    return code;
  } catch (...) {
    return tell_exception(program);
  }
}

bool parse_arguments(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    app.exit(success);
    return false;
  } catch (const CLI::ParseError& error) {
    throw InputError(fmt::format("{} (--help explains the options)", error.what()));
  }
  return true;
}

}  // namespace trame::workflows
