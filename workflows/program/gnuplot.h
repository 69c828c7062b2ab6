#pragma once
/// \file
/// gnuplot, where it is installed.

#include <filesystem>
#include <optional>
#include <string>

namespace trame::workflows {

/// Text of a user as a gnuplot string, in UTF-8. Whatever could mean something to gnuplot, a quote, a backquote, the
/// end of a line, stands as an octal escape, so that no text becomes part of a script.
[[nodiscard]] std::string gnuplot_string(const std::string& text);

/// Runs `script` in `folder` without its chatter; whether gnuplot was found and succeeded.
[[nodiscard]] bool run_gnuplot(const std::filesystem::path& folder, const std::string& script);

/// Whether a picture was written to its end.
[[nodiscard]] bool is_whole_svg(const std::filesystem::path& file);

/// The SVG that `commands` draw, which need to set neither terminal nor output. `size`: such as "800,400", pixels.
/// Empty where gnuplot is missing or fails.
[[nodiscard]] std::optional<std::string> gnuplot_svg(const std::string& commands, const std::string& size);

}  // namespace trame::workflows
