#include "workflows/report/gnuplot.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "workflows/child_process.h"
#include "workflows/temporary_folder.h"

namespace trame::workflows {

std::string gnuplot_string(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

bool run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  return run_quietly(folder, {"gnuplot", script});
}

std::optional<std::string> gnuplot_svg(const std::string& commands, const std::string& size) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "plot.gp")
      << fmt::format("set terminal svg size {} font 'sans-serif,13' background rgb 'white'\nset output 'plot.svg'\n{}",
                     size, commands);
  if (!run_gnuplot(folder.path(), "plot.gp")) return std::nullopt;
  std::ifstream stream(folder.path() / "plot.svg", std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

}  // namespace trame::workflows
