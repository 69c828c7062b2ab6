#include "workflows/program/terminal.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <thread>

#include "micro/core/text.h"

namespace trame::workflows {

namespace {

std::atomic<bool> stops_on_signals{false}, stop_requested{false};

/// The signals by which a run is asked to stop: a terminal that is closed unless nohup had it ignored, and a batch
/// system's limit of computing time.
sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGXCPU, SIGHUP}) {
    struct sigaction before {};
    if (signal == SIGHUP && sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    std::signal(signal, SIG_DFL);  // what is ignored would not be waited for either
    sigaddset(&signals, signal);
  }
  return signals;
}

void answer_signals(const sigset_t& signals) {
  for (;;) {
    int signal = 0;
    sigwait(&signals, &signal);
    if (!stops_on_signals || stop_requested) {
      std::signal(signal, SIG_DFL);
      pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
      std::raise(signal);
    }
    static constexpr std::string_view notice =
        "\nStopping after this iteration; every increment up to here is saved. Again: stop at once.\n";
    [[maybe_unused]] const auto n = write(STDERR_FILENO, notice.data(), notice.size());
    stop_requested = true;
    stop_requested.notify_all();
  }
}

std::size_t screen_width(std::FILE* stream) {
  winsize size{};
  return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

/// Lines of text, in which names of files may steer no terminal.
std::string shown(std::string_view text) {
  std::string lines;
  for (std::size_t end = text.find('\n'); end != text.npos; end = text.find('\n')) {
    lines += printable(text.substr(0, end)) + '\n';
    text.remove_prefix(end + 1);
  }
  return lines + printable(text);
}

}  // namespace

std::string duration_text(double seconds) {
  if (seconds < 0.9995) return fmt::format("{:.0f} ms", 1000 * seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const long whole = std::lround(seconds);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  const long minutes = std::lround(seconds / 60);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string bytes_text(double bytes) {
  static constexpr std::array units = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < units.size(); ++unit) bytes /= 1000;
  return fmt::format("{:.{}f} {}", bytes, bytes < 9.95 && unit > 0 ? 1 : 0, units[unit]);
}

std::string progress_text(const micro::Progress& progress, double elapsed_seconds) {
  std::string text =
      fmt::format("{:3.0f} %  {} ({}/{})  increment {}  {}", 100 * progress.fraction, progress.stage,
                  progress.stage_index + 1, progress.n_stages, progress.increment, duration_text(elapsed_seconds));
  if (const double gone = progress.fraction - progress.begun_at; gone > 0 && progress.fraction < 1)
    text += fmt::format(", about {} left", duration_text(elapsed_seconds * (1 - progress.fraction) / gone));
  text += fmt::format("  {} contacts", progress.n_contact_elements);
  if (progress.solver != nullptr)
    text += fmt::format(", {} iterations, penetration {:.3f} R", progress.solver->n_newton_iterations,
                        progress.solver->max_penetration_over_radius);
  return text;
}

Terminal::Terminal(std::FILE* stream) : stream_(stream), is_screen_(isatty(fileno(stream)) != 0) {}

void Terminal::print(const std::string& text) {
  std::fputs(text.c_str(), stream_);
  std::fflush(stream_);
  std::clearerr(stream_);
}

void Terminal::line(std::string_view text) {
  print((progress_open_ ? "\r\033[K" : "") + shown(text) + "\n");
  progress_open_ = false;
}

void Terminal::progress(const micro::Progress& progress) {
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const std::string text = progress_text(progress, elapsed);
  if (!is_screen_) return line(text);
  print("\r\033[K" + text.substr(0, screen_width(stream_) - 1));
  progress_open_ = true;
}

void Terminal::end_progress() {
  if (progress_open_) std::fputc('\n', stream_);
  progress_open_ = false;
}

void watch_signals() {
  // A thread waits for them, rather than a handler: METIS puts one of its own in that place while it orders a matrix,
  // which would end the ordering half done, and lose the signal. Threads that are made later block them as this one.
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread(answer_signals, signals).detach();
}

const std::atomic<bool>& stop_on_signals() {
  stops_on_signals = true;
  return stop_requested;
}

}  // namespace trame::workflows
