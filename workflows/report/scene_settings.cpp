#include "workflows/report/scene_settings.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "micro/core/error.h"
#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

/// "hexagonal", "random, 0.6 full, 400 turns/m Z".
std::string lay_text(const micro::YarnKind& kind) {
  std::string text =
      kind.volume_fraction > 0 ? fmt::format("random, {:g} full", kind.volume_fraction) : std::string("hexagonal");
  if (kind.twist != 0) text += fmt::format(", {:g} turns/m {}", std::abs(kind.twist), kind.twist > 0 ? "Z" : "S");
  return text;
}

/// A row for each kind of yarn of a system, with the number of its yarns.
void add_rows(const micro::Scene& scene, const char* name, const micro::YarnSystem& yarns,
              std::vector<std::vector<std::string>>& rows) {
  for (const micro::YarnKind& kind : yarns.kinds) {
    Index n = 0;
    for (Index yarn = 0; yarn < yarns.n_yarns; ++yarn) n += &yarns.kind_of(yarn) == &kind;
    const micro::FiberType& type = scene.fiber_types[kind.type];
    rows.push_back({kind.name.empty() ? name : fmt::format("{}, {}", name, escaped(kind.name)), fmt::format("{}", n),
                    fmt::format("{}", kind.n_fibers), lay_text(kind), fmt::format("{:.3g} µm", 2e6 * type.radius),
                    fmt::format("{:.4g} µm", 1e6 * yarns.yarn_spacing), escaped(scene.materials[type.material].name)});
  }
}

std::string systems_table(const micro::Scene& scene) {
  HtmlTable rows{.header = {"", "yarns", "fibers each", "lay", "fiber diameter", "spacing of yarns", "material"},
                 .rows = {}};
  add_rows(scene, "warp", scene.weave->warp, rows.rows);
  add_rows(scene, "weft", scene.weave->weft, rows.rows);
  return table(rows);
}

/// The bodies that a stage drives and the fibers that it loads, each name once.
std::string drives_text(const micro::Stage& stage) {
  std::string text;
  for (const micro::Drive& drive : stage.drives) {
    constexpr std::array<const char*, 4> how = {"moved", "pulled", "strained", "following"};
    const std::string one = fmt::format("{} {}", escaped(drive.bodies), how[static_cast<std::size_t>(drive.mode)]);
    if (text.find(one) == std::string::npos) text += (text.empty() ? "" : ", ") + one;
  }
  for (const micro::FiberLoad& load : stage.loads)
    text += fmt::format("{}{} on {}", text.empty() ? "" : ", ", escaped(load.name),
                        escaped(fmt::format("{}", fmt::join(load.fibers, ", "))));
  return text.empty() ? "nothing" : text;
}

std::string stages_table(const micro::Scene& scene) {
  HtmlTable rows{.header = {"stage", "increments", "fibers", "friction", "damping η", "what is driven"},
                 .rows = {},
                 .kind = "text"};
  for (const micro::Stage& stage : scene.stages) {
    const char* model = !stage.fiber_model                             ? "each type’s own model"
                        : *stage.fiber_model == micro::FiberModel::rod ? "rods"
                                                                       : "enriched beams";
    const bool friction = stage.friction && scene.contact.friction && scene.contact.scope != micro::ContactScope::none;
    rows.rows.push_back({escaped(stage.name), fmt::format("{}", stage.n_increments), model, friction ? "yes" : "no",
                         fmt::format("{:g} → {:g}", stage.proximal_start, stage.proximal_end),
                         (stage.separate_yarns ? "crossing order; " : "") + drives_text(stage)});
  }
  return table(rows);
}

std::string contact_html(const micro::Scene& scene) {
  const micro::ContactSettings& contact = scene.contact;
  return filled("contact", {{"none", contact.scope == micro::ContactScope::none},
                            {"all", contact.scope == micro::ContactScope::all},
                            {"friction", contact.friction},
                            {"coefficient", fmt::format("{:g}", contact.friction_coefficient)},
                            {"penetration", fmt::format("{:g}", 100 * contact.target_penetration)},
                            {"constant", !contact.adapt_penalty},
                            {"force_tolerance", fmt::format("{:g}", scene.solver.force_tolerance)}});
}

}  // namespace

std::optional<micro::Scene> scene_of(const micro::SnapshotHeader& header) {
  if (header.version.empty()) return std::nullopt;
  try {
    return micro::parse_scene(header.scene_text, header.scene_name);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::string scene_title(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene) {
  if (scene && !scene->title.empty()) return scene->title;
  return header.scene_name.empty() ? "Fibers from elsewhere" : header.scene_name;
}

std::string settings_html(const micro::SnapshotHeader& header, const std::optional<micro::Scene>& scene) {
  Fields fields = {{"no_text", header.scene_text.empty()}, {"text", header.scene_text}};
  if (scene && scene->weave) fields.emplace_back("yarns", systems_table(*scene));
  if (scene) {
    fields.emplace_back("stages", stages_table(*scene));
    fields.emplace_back("contact", contact_html(*scene));
  }
  return filled("settings", fields);
}

}  // namespace trame::workflows
