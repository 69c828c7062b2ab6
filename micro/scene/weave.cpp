#include "micro/scene/weave.h"

#include <fmt/format.h>

#include <charconv>

#include "micro/scene/pattern.h"
#include "micro/scene/tables.h"

namespace trame::micro {

namespace {

constexpr const char* floats_allowed =
    "an even number of floats of 1 to 1000 with slashes between them, such as \"2/2\" or \"3/1/1/1\"";
constexpr const char* matrix_allowed = "rows of equal length of 0 and 1, such as [[1, 0], [0, 1]]";

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

/// Fails for keys that the pattern has no use for.
void check_pattern_keys(const SceneValue& table, const WeaveInput& input) {
  if (input.pattern.has_value() == input.matrix.has_value()) table.fail("must have either \"pattern\" or \"matrix\"");
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

Weave read_weave(const SceneValue& table, const Scene& scene) {
  WeaveInput input;
  read_table(table, weave_keys(), {"warp", "weft"}, input);
  Weave weave;
  weave.warp = read_yarns(table, "warp", scene);
  weave.weft = read_yarns(table, "weft", scene);
  weave.warp_above = continued(make_pattern(table, input), weave.weft.n_yarns, weave.warp.n_yarns);
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
