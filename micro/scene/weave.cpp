#include "micro/scene/weave.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>

#include "micro/core/error.h"
#include "micro/scene/draft.h"
#include "micro/scene/pattern.h"
#include "micro/scene/tables.h"
#include "micro/scene/yarn_section.h"

namespace trame::micro {

namespace {

constexpr const char* floats_allowed =
    "an even number of floats of 1 to 1000 with slashes between them, such as \"2/2\" or \"3/1/1/1\"";
constexpr const char* matrix_allowed = "rows of equal length of 0 and 1, such as [[1, 0], [0, 1]]";
constexpr Index most_layers = 100;
constexpr const char* levels_allowed =
    "for each warp yarn of a repeat a list, all equally long, of the layers of weft that it passes above, column by "
    "column, such as [[0, 2], [2, 0]]";
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

WarpLevels read_levels(const SceneValue& value) {
  WarpLevels levels;
  for (const SceneValue& warp : value.items(levels_allowed)) {
    std::vector<Index>& along = levels.emplace_back();
    for (const SceneValue& level : warp.items(levels_allowed)) along.push_back(level.integer(between(0, most_layers)));
    if (along.size() != levels.front().size()) warp.fail("must be as long as the list of the first warp yarn");
  }
  return levels;
}

/// Fails for levels that there are not.
void check_levels(const SceneValue& table, const WeaveInput& input) {
  if (!input.levels) {
    if (const auto layers = table.find("weft_layers"))
      layers->fail("has no effect without \"levels\", which say where warps pass through the layers");
    return;
  }
  const std::vector<SceneValue> warps = table.find("levels")->items(levels_allowed);
  for (const SceneValue& warp : warps)
    for (const SceneValue& level : warp.items(levels_allowed))
      if (level.integer(any()) > input.weft_layers)
        level.fail(fmt::format("must be at most {}, which is above all layers of weft", input.weft_layers));
}

/// Fails for keys that the pattern has no use for.
void check_pattern_keys(const SceneValue& table, const WeaveInput& input) {
  if (input.pattern.has_value() + input.matrix.has_value() + input.picture.has_value() +
          input.pattern_file.has_value() + input.levels.has_value() !=
      1)
    table.fail("must have exactly one of \"pattern\", \"matrix\", \"picture\", \"pattern_file\" and \"levels\"");
  check_levels(table, input);
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
  if (input.levels) return layered_pattern(*input.levels, input.weft_layers);
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

WeavePattern whole_draft(const std::filesystem::path& file) {
  const Draft draft = read_draft(file);
  return pattern_of(draft, 0, 0, draft.n_weft(), draft.n_warp());
}

NameTable fiber_type_names(const Scene& scene) {
  NameTable names;
  for (const FiberType& type : scene.fiber_types) names.add(type.name);
  return names;
}

/// Mass of a fiber per length; fails at `value` where the density is not known.
double fiber_linear_density(const SceneValue& value, const Scene& scene, Index type) {
  const FiberType& fiber = scene.fiber_types[type];
  return known_density(value, scene.materials[fiber.material]) * std::numbers::pi * fiber.radius * fiber.radius;
}

Index number_of_fibers(const SceneValue& table, const YarnKindInput& input, const Scene& scene) {
  if (input.n_fibers.has_value() == input.linear_density.has_value())
    table.fail("must have either \"fibers\" or \"linear_density\"");
  if (input.n_fibers) return *input.n_fibers;
  const SceneValue value = *table.find("linear_density");
  const double of_a_fiber = fiber_linear_density(value, scene, *input.type);
  const double n = std::round(*input.linear_density / of_a_fiber);
  constexpr double most = 1e6;
  if (n < 1 || n > most)
    value.fail(fmt::format("{:g} fibers of {:.4g} tex; must be 1 to {:g}", *input.linear_density / of_a_fiber,
                           1e6 * of_a_fiber, most));
  return static_cast<Index>(n);
}

/// Fails for those of `keys` that the table has.
void refuse(const SceneValue& table, std::initializer_list<const char*> keys, const std::string& because) {
  for (const char* name : keys)
    if (const auto value = table.find(name)) value->fail("has no effect, because " + because);
}

YarnKind make_kind(const SceneValue& table, const YarnKindInput& input, const Scene& scene) {
  if (!input.type) table.fail_missing("fiber_type", "the name of a fiber type");
  YarnKind kind{.name = "",
                .type = *input.type,
                .n_fibers = number_of_fibers(table, input, scene),
                .n_layers = input.n_layers,
                .lattice_spacing = input.lattice_spacing};
  if (kind.n_layers > kind.n_fibers) table.find("layers")->fail("must be at most the number of fibers");
  if (input.twist > 0) {
    if (!input.twist_direction) table.fail_missing("twist_direction", "\"S\" or \"Z\"");
    if (const auto layers = table.find("layers")) layers->fail("has no effect, because twist makes a yarn round");
    kind.twist = *input.twist_direction == TwistDirection::z ? input.twist : -input.twist;
  } else {
    refuse(table, {"twist_direction"}, "there is no twist");
  }
  if (input.lay == Lay::hexagonal) {
    refuse(table, {"volume_fraction", "seed"}, "lay is \"hexagonal\"");
    return kind;
  }
  refuse(table, {"lattice_spacing"}, "lay is \"random\"");
  if (!input.volume_fraction) table.fail_missing("volume_fraction", "a number of at least 0.05 and at most 0.8");
  kind.volume_fraction = *input.volume_fraction;
  kind.seed = input.seed;
  return kind;
}

/// The kinds that the order of a system names, once each, and their order.
void read_order(const SceneValue& value, const std::vector<YarnKind>& kinds, YarnSystem& yarns) {
  Names known;
  for (const YarnKind& kind : kinds) known.push_back(kind.name);
  if (known.empty()) value.fail("must be names of [yarn.NAME], but the scene has none");
  yarns.order.clear();
  std::istringstream words(value.text());
  for (std::string word; words >> word;) {
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const YarnKind& k) { return k.name == word; });
    if (kind == kinds.end())
      value.fail(fmt::format("\"{}\" is no [yarn.NAME]; must be of {}{}", word, allowed_names(known),
                             suggestion(word, known)));
    auto mine = std::find(yarns.kinds.begin(), yarns.kinds.end(), *kind);
    if (mine == yarns.kinds.end()) mine = yarns.kinds.insert(mine, *kind);
    yarns.order.push_back(static_cast<Index>(mine - yarns.kinds.begin()));
  }
  if (yarns.order.empty()) value.fail("must be names of [yarn.NAME] with blanks between them");
}

/// Neighbours must not overlap.
void check_spacing(const SceneValue& table, const Scene& scene, const YarnSystem& yarns) {
  const auto radius = [&](const YarnKind& kind) { return scene.fiber_types[kind.type].radius; };
  std::set<std::pair<const YarnKind*, const YarnKind*>> checked;
  for (Index yarn = 0; yarn + yarns.n_layers < yarns.n_yarns; ++yarn) {
    const YarnKind &a = yarns.kind_of(yarn), &b = yarns.kind_of(yarn + yarns.n_layers);
    if (!checked.emplace(&a, &b).second) continue;
    const double least = least_yarn_spacing(a, radius(a), b, radius(b));
    if (yarns.yarn_spacing >= least * (1 - 1e-9)) continue;
    const std::string sizes =
        &a == &b ? "the width of a yarn" : fmt::format("what \"{}\" and \"{}\" need side by side", a.name, b.name);
    if (const auto spacing = table.find("yarn_spacing"))
      spacing->fail(fmt::format("must be at least {}, {:.4g} m, or neighbouring yarns overlap", sizes, least));
    table.find("sett")->fail(
        fmt::format("must be at most {:.4g} per m, 1 over {}, {:.4g} m, or neighbouring yarns "
                    "overlap",
                    1 / least, sizes, least));
  }
}

/// A lay that cannot be is told before anything runs.
void check_lays(const SceneValue& table, const Scene& scene, const YarnSystem& yarns) {
  for (Index yarn = 0; yarn < yarns.n_yarns; ++yarn) {
    const YarnKind& kind = yarns.kind_of(yarn);
    if (kind.volume_fraction == 0) continue;
    try {
      (void)yarn_section(kind, scene.fiber_types[kind.type].radius, yarn);
    } catch (const InputError& error) {
      const auto own = table.find("volume_fraction");
      (own ? *own : *table.find("order"))
          .fail(kind.name.empty() ? error.what() : fmt::format("yarn \"{}\": {}", kind.name, error.what()));
    }
  }
}

/// A periodic cell is a whole number of repeats, of the pattern and of the order of kinds of yarn, along each of its
/// periods, and its last yarn must not overlap the first one of the next cell.
void check_repeats(const SceneValue& table, const WeaveInput& input, const Scene& scene,
                   const std::filesystem::path& folder, const Weave& weave) {
  const Index n_weft = weave.weft.n_yarns, n_warp = weave.warp.n_yarns;
  // All of a pattern's rows, or columns, are seen from each yarn of the cell on.
  const auto period = [](Index n_rows, Index n_layers, const auto& equal) {
    for (Index period = n_layers; period < n_rows; period += n_layers) {
      bool all = true;
      for (Index i = 0; i < n_rows && all; ++i) all = equal(i, (i + period) % n_rows);
      if (all && n_rows % period == 0) return period;
    }
    return n_rows;
  };
  const WeavePattern repeat =
      input.pattern_file ? whole_draft(folder / *input.pattern_file) : make_pattern(table, input);
  const auto n_rows = static_cast<Index>(repeat.size()), n_columns = static_cast<Index>(repeat.front().size());
  const Index of_weft = period(n_rows, weave.weft.n_layers, [&](Index i, Index k) { return repeat[i] == repeat[k]; });
  const Index of_warp = period(n_columns, weave.warp.n_layers, [&](Index j, Index k) {
    return std::all_of(repeat.begin(), repeat.end(), [&](const std::vector<bool>& row) { return row[j] == row[k]; });
  });
  // Along the warp's period weft yarns repeat, and the other way round.
  const auto check = [&](const char* family, const YarnSystem& yarns, Index n, Index of_pattern) {
    const SceneValue system = *table.find(family);
    const auto of_order = static_cast<Index>(yarns.order.size());
    for (const auto& [what, repeat_of] : {std::pair{"pattern", of_pattern}, {"order", of_order}})
      if (n % repeat_of != 0)
        system.find("yarns")->fail(
            fmt::format("must be a multiple of {}, the {} yarns of a repeat of the {}, which else does not close in a "
                        "periodic cell",
                        repeat_of, family, what));
    const auto radius = [&](const YarnKind& kind) { return scene.fiber_types[kind.type].radius; };
    for (Index layer = 0; layer < yarns.n_layers; ++layer) {
      const YarnKind &last = yarns.kind_of(n - yarns.n_layers + layer), &first = yarns.kind_of(layer);
      const double least = least_yarn_spacing(last, radius(last), first, radius(first));
      if (yarns.yarn_spacing < least * (1 - 1e-9))
        system.find("yarns")->fail(fmt::format(
            "the last yarn overlaps the first one of the next cell; they need {:.4g} m side by side", least));
    }
  };
  if (weave.warp.periodic) check("weft", weave.weft, n_weft, of_weft);
  if (weave.weft.periodic) check("warp", weave.warp, n_warp, of_warp);
}

/// All of a system but what follows from the other one.
YarnSystem read_yarns(const SceneValue& weave, const char* family, const Scene& scene,
                      const std::vector<YarnKind>& kinds, Index n_layers, YarnSystemInput& input) {
  const auto table = weave.find(family);
  if (!table) weave.fail_missing(family, fmt::format("a table, written [weave.{}]", family));
  read_table(*table, yarn_system_keys(fiber_type_names(scene)), {}, input);
  YarnSystem yarns;
  yarns.n_yarns = input.n_yarns;
  yarns.n_layers = n_layers;
  if (yarns.n_yarns % n_layers != 0)
    table->find("yarns")->fail(fmt::format("must be a multiple of {}, the layers of {}", n_layers, family));
  if (input.order) {
    for (const Key<YarnKindInput>& key : yarn_kind_keys({}))
      refuse(*table, {key.name.c_str()}, "yarns are of the kinds that order names");
    read_order(*table->find("order"), kinds, yarns);
  } else {
    yarns.kinds = {make_kind(*table, input, scene)};
  }
  if (input.yarn_spacing.has_value() == input.sett.has_value())
    table->fail("must have either \"sett\" or \"yarn_spacing\"");
  yarns.yarn_spacing = input.sett ? 1 / *input.sett : *input.yarn_spacing;
  check_spacing(*table, scene, yarns);
  check_lays(*table, scene, yarns);
  return yarns;
}

/// Twist must fit together where yarns come back to where they start.
void check_turns(const SceneValue& table, double length, const YarnSystem& yarns) {
  constexpr double tolerance = 1e-6;
  for (const YarnKind& kind : yarns.kinds) {
    const double turns = length * std::abs(kind.twist);
    if (std::abs(turns - std::round(turns)) <= tolerance) continue;
    const auto own = table.find("twist");
    const std::string complaint = fmt::format(
        "{:.6g} turns over the {:.6g} m of a periodic cell; must be a whole number of them, such as {:.6g} per m",
        turns, length, std::max(1.0, std::round(turns)) / length);
    (own ? *own : *table.find("order"))
        .fail(kind.name.empty() ? complaint : fmt::format("yarn \"{}\": {}", kind.name, complaint));
  }
}

/// Margin and elements, which go by the crossing yarns.
void fit_to_crossing(const SceneValue& table, const Scene& scene, const YarnSystemInput& input, const Weave& weave,
                     const YarnSystem& crossing, YarnSystem& yarns) {
  constexpr double diameters = 2.5, elements_a_crossing = 4, elements_a_turn = 10;
  if (yarns.periodic) refuse(table, {"margin"}, "yarns of a periodic cell have no ends");
  const double pitch = weave.pitch(crossing);
  yarns.margin = yarns.periodic ? 0.5 * pitch : input.margin.value_or(pitch);
  const double length = weave.yarn_length(yarns, crossing);
  if (yarns.periodic) check_turns(table, length, yarns);
  double most = pitch / elements_a_crossing, most_for_twist = std::numeric_limits<double>::infinity();
  for (const YarnKind& kind : yarns.kinds) {
    most = std::min(most, diameters * 2 * scene.fiber_types[kind.type].radius);
    if (kind.twist != 0) most_for_twist = std::min(most_for_twist, 1 / (elements_a_turn * std::abs(kind.twist)));
  }
  const double needed = std::ceil(length / most_for_twist * (1 - 1e-9));
  constexpr double most_elements = 1e6;
  const double chosen = input.n_elements ? *input.n_elements : std::ceil(std::max(needed, length / most * (1 - 1e-9)));
  if (chosen > most_elements)
    table.fail(fmt::format("{:g} elements along a fiber; must be at most {:g}: give elements, or take a smaller patch",
                           chosen, most_elements));
  if (chosen < needed)
    table.find("elements")
        ->fail(fmt::format("must be at least {:g}, or an element has more than a tenth of a turn of twist", needed));
  constexpr double least_of_a_loop = 2;
  if (yarns.periodic && chosen < least_of_a_loop)
    table.find("elements")->fail("must be at least 2 in a periodic cell, where the last one joins the first one");
  yarns.n_elements = static_cast<Index>(std::max(1.0, chosen));
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

Kind<WarpLevels> warp_levels() { return {levels_allowed, read_levels, {}}; }

Kind<double> crossing_angle() {
  constexpr double least = 15, most = 165, degree = std::numbers::pi / 180;
  const std::string allowed = fmt::format("an angle of {:g} to {:g} deg, such as \"60 deg\"", least, most);
  return {allowed,
          [allowed](const SceneValue& value) {
            const double read = value.quantity(angle, any());
            constexpr double hair = 1e-9;
            if (read < least * degree - hair || read > most * degree + hair) value.fail("must be " + allowed);
            return std::abs(read - Weave{}.angle) < hair ? Weave{}.angle : read;
          },
          [](double value) { return fmt::format("{:g} deg", value / degree); }};
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

std::vector<YarnKind> read_yarn_kinds(const SceneValue& root, const Scene& scene) {
  std::vector<YarnKind> kinds;
  const auto tables = root.find("yarn");
  const auto keys = yarn_kind_keys(fiber_type_names(scene));
  for (const SceneValue& table : tables ? tables->children() : std::vector<SceneValue>()) {
    YarnKindInput input;
    read_table(table, keys, {}, input);
    kinds.push_back(make_kind(table, input, scene));
    kinds.back().name = table.table_name();
    if (kinds.back().name.find_first_of(" \t") != std::string::npos)
      table.fail("must have a name without blanks, which stand between names in an order");
  }
  return kinds;
}

Weave read_weave(const SceneValue& table, const Scene& scene, const std::vector<YarnKind>& kinds,
                 const std::filesystem::path& folder) {
  WeaveInput input;
  read_table(table, weave_keys(), {"warp", "weft"}, input);
  Weave weave;
  YarnSystemInput warp, weft;
  weave.warp = read_yarns(table, "warp", scene, kinds, 1, warp);
  weave.weft = read_yarns(table, "weft", scene, kinds, input.weft_layers, weft);
  weave.warp.periodic = input.periodic[0];
  weave.weft.periodic = input.periodic[1];
  weave.angle = input.angle;
  fit_to_crossing(*table.find("warp"), scene, warp, weave, weave.weft, weave.warp);
  fit_to_crossing(*table.find("weft"), scene, weft, weave, weave.warp, weave.weft);
  const Index n_weft = weave.weft.n_yarns, n_warp = weave.warp.n_yarns;
  weave.warp_above = input.pattern_file ? read_draft_of(table, input, folder, n_weft, n_warp)
                                        : continued(make_pattern(table, input), n_weft, n_warp,
                                                    (input.first_weft - 1) * input.weft_layers, input.first_warp - 1);
  if (weave.is_periodic()) check_repeats(table, input, scene, folder, weave);
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
  const auto system_of = [&](const std::string& yarn) -> const YarnSystem& {
    return is_warp(yarn) ? weave.warp : weave.weft;
  };
  for (const std::string& yarn : yarn_names(weave))
    for (const char* end : {"/start", "/end"})
      if (!system_of(yarn).periodic) names.push_back(yarn + end);
  for (const auto& [family, yarns] : {std::pair{"warp", &weave.warp}, {"weft", &weave.weft}}) {
    if (yarns->periodic) {
      names.push_back(period_name(yarns == &weave.warp));
      continue;
    }
    for (const char* end : {"start", "end"}) names.push_back(fmt::format("side/{}/{}", family, end));
  }
  return names;
}

double cell_width(const Weave& weave, bool across_warp) {
  const YarnSystem& yarns = across_warp ? weave.warp : weave.weft;
  return yarns.n_columns() * yarns.yarn_spacing;
}

}  // namespace trame::micro
