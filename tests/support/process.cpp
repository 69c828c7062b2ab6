#include "support/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "support/text_file.h"

namespace trame::test {

namespace {

void redirect(const std::filesystem::path& file, int descriptor) {
  dup2(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), descriptor);
}

[[noreturn]] void become(std::vector<std::string> command) {
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments.front(), arguments.data());
  _exit(127);
}

}  // namespace

Process::Process(const std::filesystem::path& folder, std::vector<std::string> command,
                 const std::vector<std::string>& environment)
    : out_(folder / "stdout.txt"), err_(folder / "stderr.txt") {
  id_ = fork();
  if (id_ < 0) throw std::runtime_error("fork failed");
  if (id_ != 0) return;
  redirect(out_, STDOUT_FILENO);
  redirect(err_, STDERR_FILENO);
  if (chdir(folder.c_str()) != 0) _exit(126);
  for (std::string variable : environment) {
    const std::size_t split = variable.find('=');
    setenv(variable.substr(0, split).c_str(), variable.substr(split + 1).c_str(), 1);
  }
  become(std::move(command));
}

Process::~Process() {
  if (has_ended()) return;
  kill(id_, SIGKILL);
  waitpid(id_, nullptr, 0);
}

bool Process::has_ended() {
  if (!ended_) ended_ = waitpid(id_, &status_, WNOHANG) == id_;
  return ended_;
}

bool Process::wait_for_output(const std::string& text, double seconds) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (read_text(out_).find(text) == std::string::npos) {
    if (has_ended() || std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

void Process::send(int signal) const { kill(id_, signal); }

Outcome Process::wait() {
  if (!ended_) waitpid(id_, &status_, 0);
  ended_ = true;
  return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_), read_text(out_), read_text(err_)};
}

namespace {

/// Fails the test if the states of a run are wrong.
void judge(const std::filesystem::path& folder, const std::vector<std::string>& command) {
  const char* const judge = std::getenv("TRAME_JUDGE");
  const auto out = std::find(command.begin(), command.end(), "--out");
  if (judge == nullptr || command.end() - out < 2) return;
  const std::filesystem::path states = folder / *(out + 1) / "states.h5";
  if (!std::filesystem::exists(states)) return;
  Process process(folder, {judge, states.string()});
  const Outcome verdict = process.wait();
  EXPECT_EQ(verdict.exit_code, 0) << verdict.out << verdict.err;
}

}  // namespace

Outcome run(const std::filesystem::path& folder, const std::vector<std::string>& command,
            const std::vector<std::string>& environment) {
  const Outcome outcome = Process(folder, command, environment).wait();
  if (outcome.exit_code == 0) judge(folder, command);
  return outcome;
}

}  // namespace trame::test
