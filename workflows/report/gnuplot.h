#pragma once
/// \file
/// gnuplot, where it is installed.

#include <filesystem>
#include <optional>
#include <string>

namespace trame::workflows {

/// A gnuplot string: single quotes are doubled inside it and nothing else is special.
[[nodiscard]] std::string gnuplot_string(const std::string& text);

/// Runs `script` in `folder` without its chatter; whether gnuplot was found and succeeded.
[[nodiscard]] bool run_gnuplot(const std::filesystem::path& folder, const std::string& script);

/// The SVG that `commands` draw, which need to set neither terminal nor output. `size`: such as "800,400", pixels.
/// Empty where gnuplot is missing or fails.
[[nodiscard]] std::optional<std::string> gnuplot_svg(const std::string& commands, const std::string& size);

}  // namespace trame::workflows
