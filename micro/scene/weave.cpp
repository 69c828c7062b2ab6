#include "micro/scene/weave.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>

#include "micro/core/error.h"
#include "micro/scene/draft.h"
#include "micro/scene/pattern.h"
#include "micro/scene/tables.h"

namespace trame::micro {

namespace {

constexpr const char* floats_allowed =
    "an even number of floats of 1 to 1000 with slashes between them, such as \"2/2\" or \"3/1/1/1\"";
constexpr const char* matrix_allowed = "rows of equal length of 0 and 1, such as [[1, 0], [0, 1]]";
constexpr const char* picture_allowed = "rows of equal length of X and dots, such as [\"X.\", \".X\"]";

std::vector<Index> read_floats(const SceneValue& value) {
  constexpr Index longest = 1000;
  const std::string text = value.text();
  std::vector<Index> floats;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    Index n = 0;
    const auto [rest, status] = std::from_chars(at, end, n);
    if (status != std::errc() || n < 1 || n > longest) break;
    floats.push_back(n);
    if (rest == end && floats.size() % 2 == 0) return floats;
    if (rest == end || *rest != '/') break;
    at = rest + 1;
  }
  value.fail(fmt::format("must be {}", floats_allowed));
}

WeavePattern read_matrix(const SceneValue& value) {
  WeavePattern pattern;
  for (const SceneValue& row_value : value.items(matrix_allowed)) {
    std::vector<bool>& row = pattern.emplace_back();
    for (const SceneValue& entry : row_value.items(matrix_allowed)) row.push_back(entry.integer(between(0, 1)) == 1);
    if (row.size() != pattern.front().size()) row_value.fail(fmt::format("must be one of {}", matrix_allowed));
  }
  return pattern;
}

WeavePattern read_picture(const SceneValue& value) {
  const std::string allowed = fmt::format("must be {}", picture_allowed);
  std::vector<std::pair<SceneValue, std::string>> rows;
  if (value.is_list()) {
    for (const SceneValue& row : value.items(picture_allowed)) rows.emplace_back(row, row.text());
  } else {
    for (const std::string& line : value.lines(allowed)) rows.emplace_back(value, line);
  }
  WeavePattern pattern;
  for (const auto& [row_value, row] : rows) {
    if (row.find_first_not_of("Xx.") != row.npos || row.size() != rows.front().second.size()) row_value.fail(allowed);
    std::vector<bool>& above = pattern.emplace_back();
    for (const char c : row) above.push_back(c != '.');
  }
  return pattern;
}

/// Fails for keys that the pattern has no use for.
void check_pattern_keys(const SceneValue& table, const WeaveInput& input) {
  if (input.pattern.has_value() + input.matrix.has_value() + input.picture.has_value() +
          input.pattern_file.has_value() !=
      1)
    table.fail("must have exactly one of \"pattern\", \"matrix\", \"picture\" and \"pattern_file\"");
  const auto only_for = [&](const char* pattern, const char* key) {
    if (const auto value = table.find(key); value && input.pattern != pattern)
      value->fail(fmt::format("has no effect, because pattern is not \"{}\"", pattern));
  };
  only_for("twill", "repeat");
  only_for("satin", "harnesses");
  only_for("satin", "step");
}

WeavePattern make_pattern(const SceneValue& table, const WeaveInput& input) {
  check_pattern_keys(table, input);
  if (input.matrix) return *input.matrix;
  if (input.picture) return *input.picture;
  if (input.pattern == "plain") return twill_pattern({1, 1});
  if (input.pattern == "twill") return twill_pattern(input.repeat);
  if (!is_satin(input.harnesses, input.step)) {
    const auto step = table.find("step"), harnesses = table.find("harnesses");
    (step ? *step : *harnesses)
        .fail(fmt::format("a satin of {} harnesses must have a step from 2 to {} without a common divisor with it",
                          input.harnesses, input.harnesses - 2));
  }
  return satin_pattern(input.harnesses, input.step);
}

/// The pattern of a draft, for the yarns of the patch.
WeavePattern read_draft_of(const SceneValue& table, const WeaveInput& input, const std::filesystem::path& folder,
                           Index n_weft, Index n_warp) {
  check_pattern_keys(table, input);
  const SceneValue value = *table.find("pattern_file");
  if (folder.empty()) value.fail("needs a scene that is a file, in whose folder it can be looked for");
  try {
    return pattern_of(read_draft(folder / *input.pattern_file), input.first_weft - 1, input.first_warp - 1, n_weft,
                      n_warp);
  } catch (const InputError& error) {
    value.fail(error.what());
  }
}

YarnSystem read_yarns(const SceneValue& weave, const char* family, const Scene& scene) {
  const auto table = weave.find(family);
  if (!table) weave.fail_missing(family, fmt::format("a table, written [weave.{}]", family));
  NameTable fiber_types;
  for (const FiberType& type : scene.fiber_types) fiber_types.add(type.name);
  YarnSystem yarns;
  read_table(*table, yarn_keys(fiber_types), {}, yarns);
  if (yarns.n_layers > yarns.n_fibers) table->find("layers")->fail("must be at most the number of fibers");
  if (yarns.n_layers == 0 || yarns.n_yarns == 1) return yarns;
  const double diameter = 2 * scene.fiber_types[yarns.type].radius;
  const Index widest_layer = (yarns.n_fibers + yarns.n_layers - 1) / yarns.n_layers;
  const double width = diameter * (1 + yarns.lattice_spacing * (widest_layer - 1));
  if (yarns.yarn_spacing < width)
    table->find("yarn_spacing")
        ->fail(fmt::format("must be at least the width of a yarn, {:.4g} m, or neighbouring yarns overlap", width));
  return yarns;
}

}  // namespace

Kind<std::vector<Index>> twill_floats() {
  return {floats_allowed, read_floats,
          [](const std::vector<Index>& floats) { return fmt::format("\"{}\"", fmt::join(floats, "/")); }};
}

Kind<WeavePattern> pattern_matrix() { return {matrix_allowed, read_matrix, {}}; }

Kind<WeavePattern> pattern_picture() {
  return {fmt::format("{}, or one text with a row a line", picture_allowed), read_picture, {}};
}

std::string picture_instead(const std::string& pattern_file, const Weave& weave, Index first_weft, Index first_warp) {
  const std::size_t n_weft = weave.warp_above.size(), n_warp = weave.warp_above.front().size();
  std::vector<std::string> rows(n_weft, std::string(n_warp, '.'));
  for (std::size_t i = 0; i < n_weft; ++i)
    for (std::size_t j = 0; j < n_warp; ++j)
      if (weave.warp_above[i][j])
        rows[(i + static_cast<std::size_t>(first_weft) - 1) % n_weft]
            [(j + static_cast<std::size_t>(first_warp) - 1) % n_warp] = 'X';
  return fmt::format("picture = [ # {}\n  \"{}\"]", pattern_file, fmt::join(rows, "\",\n  \""));
}

Weave read_weave(const SceneValue& table, const Scene& scene, const std::filesystem::path& folder) {
  WeaveInput input;
  read_table(table, weave_keys(), {"warp", "weft"}, input);
  Weave weave;
  weave.warp = read_yarns(table, "warp", scene);
  weave.weft = read_yarns(table, "weft", scene);
  const Index n_weft = weave.weft.n_yarns, n_warp = weave.warp.n_yarns;
  weave.warp_above = input.pattern_file ? read_draft_of(table, input, folder, n_weft, n_warp)
                                        : continued(make_pattern(table, input), n_weft, n_warp, input.first_weft - 1,
                                                    input.first_warp - 1);
  return weave;
}

std::vector<std::string> yarn_names(const Weave& weave) {
  Names names;
  for (Index i = 1; i <= weave.warp.n_yarns; ++i) names.push_back(fmt::format("warp/{}", i));
  for (Index i = 1; i <= weave.weft.n_yarns; ++i) names.push_back(fmt::format("weft/{}", i));
  return names;
}

std::vector<std::string> weave_body_names(const Weave& weave) {
  Names names;
  for (const std::string& yarn : yarn_names(weave))
    for (const char* end : {"/start", "/end"}) names.push_back(yarn + end);
  for (const char* side : {"side/warp/start", "side/warp/end", "side/weft/start", "side/weft/end"})
    names.push_back(side);
  return names;
}

}  // namespace trame::micro
