#include "micro/io/scene_weave.h"

#include <fmt/format.h>

#include <charconv>

#include "micro/io/scene_pattern.h"
#include "micro/io/scene_tables.h"

namespace trame::micro {

namespace {

/// "2/2" as {2, 2}: an even number of floats, each at least 1.
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
  value.fail("must be an even number of floats of 1 to 1000 with slashes between them, such as \"2/2\" or \"3/1/1/1\"");
}

WeavePattern read_matrix(const SceneValue& value) {
  constexpr const char* allowed = "rows of equal length of 0 and 1, such as [[1, 0], [0, 1]]";
  WeavePattern pattern;
  for (const SceneValue& row_value : value.items(allowed)) {
    std::vector<bool>& row = pattern.emplace_back();
    for (const SceneValue& entry : row_value.items(allowed)) row.push_back(entry.integer(between(0, 1)) == 1);
    if (row.size() != pattern.front().size()) row_value.fail(fmt::format("must be one of {}", allowed));
  }
  return pattern;
}

WeavePattern read_satin(const SceneValue& table, const WeaveInput& input) {
  constexpr Index most = 1000;
  const Index harnesses = input.harnesses ? input.harnesses->integer(between(5, most)) : 5;
  const Index step = input.step ? input.step->integer(at_least(2)) : 2;
  if (!is_satin(harnesses, step))
    input.step.value_or(input.harnesses.value_or(table))
        .fail(fmt::format("a satin of {} harnesses must have a step from 2 to {} without a common divisor with it",
                          harnesses, harnesses - 2));
  return satin_pattern(harnesses, step);
}

/// Fails for keys that the pattern has no use for.
void check_pattern_keys(const SceneValue& table, const WeaveInput& input) {
  if (input.pattern.has_value() == input.matrix.has_value())
    table.fail("must have either \"pattern\" or \"matrix\"");
  const bool twill = input.pattern == "twill", satin = input.pattern == "satin";
  if (input.repeat && !twill) input.repeat->fail("has no effect, because pattern is not \"twill\"");
  if (input.harnesses && !satin) input.harnesses->fail("has no effect, because pattern is not \"satin\"");
  if (input.step && !satin) input.step->fail("has no effect, because pattern is not \"satin\"");
}

WeavePattern read_pattern(const SceneValue& table, const WeaveInput& input) {
  check_pattern_keys(table, input);
  if (input.matrix) return read_matrix(*input.matrix);
  if (input.pattern == "plain") return twill_pattern({1, 1});
  if (input.pattern == "twill") return twill_pattern(input.repeat ? read_floats(*input.repeat) : std::vector<Index>{2, 2});
  return read_satin(table, input);
}

YarnSystem read_yarns(const SceneValue& weave, const char* family, const Scene& scene) {
  const auto table = weave.find(family);
  if (!table) weave.fail_missing(family, fmt::format("a table, written [weave.{}]", family));
  Names fiber_types;
  for (const FiberType& type : scene.fiber_types) fiber_types.push_back(type.name);
  YarnSystem yarns;
  read_table(*table, yarn_keys(fiber_types), {}, yarns);
  // The pattern is spelled out for each pair of yarns.
  constexpr Index most_yarns = 1000;
  if (yarns.n_yarns > most_yarns) table->find("yarns")->fail(fmt::format("must be at most {}", most_yarns));
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

Weave read_weave(const SceneValue& table, const Scene& scene) {
  WeaveInput input;
  read_table(table, weave_keys(), {"warp", "weft"}, input);
  Weave weave;
  weave.warp = read_yarns(table, "warp", scene);
  weave.weft = read_yarns(table, "weft", scene);
  weave.warp_above = continued(read_pattern(table, input), weave.weft.n_yarns, weave.warp.n_yarns);
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
