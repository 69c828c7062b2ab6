#include "workflows/program/gnuplot.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <string_view>

#include "workflows/program/child_process.h"
#include "workflows/program/temporary_folder.h"

namespace trame::workflows {

namespace {

std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// gnuplot does not fail on a full disk, nor on a plot without points.
bool is_whole_svg(const std::string& svg) { return svg.find("</svg>") != std::string::npos; }

}  // namespace

std::string gnuplot_string(const std::string& text) {
  constexpr std::string_view plain = " ,.:;=+-_/()%";
  std::string quoted = "\"";
  for (const char c : text)
    quoted += std::isalnum(static_cast<unsigned char>(c)) != 0 || plain.find(c) != plain.npos
                  ? std::string(1, c)
                  : fmt::format("\\{:03o}", static_cast<unsigned char>(c));
  return quoted + '"';
}

bool run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  return run_quietly(folder, {"gnuplot", "--default-settings", script});
}

bool is_whole_svg(const std::filesystem::path& file) { return is_whole_svg(read_file(file)); }

std::optional<std::string> gnuplot_svg(const std::string& commands, const std::string& size) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "plot.gp") << fmt::format(
      "set encoding utf8\nset terminal svg size {} font 'sans-serif,13' background rgb 'white'\n"
      "set output 'plot.svg'\n{}",
      size, commands);
  if (!run_gnuplot(folder.path(), "plot.gp")) return std::nullopt;
  std::string svg = read_file(folder.path() / "plot.svg");
  return is_whole_svg(svg) ? std::optional(std::move(svg)) : std::nullopt;
}

}  // namespace trame::workflows
