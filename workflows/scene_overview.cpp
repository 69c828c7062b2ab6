#include "workflows/scene_overview.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "workflows/terminal.h"

namespace trame::workflows {

using namespace micro;

namespace {

const char* model_name(FiberModel model) { return model == FiberModel::enriched ? "enriched" : "rod"; }
const char* model_effect(FiberModel model) { return model == FiberModel::enriched ? "enriched beams" : "rods"; }

std::vector<CalledEffect> fiber_effects(const Scene& scene) {
  std::vector<CalledEffect> called;
  for (const FiberType& type : scene.fiber_types)
    called.push_back(
        {model_effect(type.model), fmt::format("fiber_type.{}.model = \"{}\"", type.name, model_name(type.model))});
  if (scene.twist_stretch) called.push_back({"coupling of twist and stretch", "effects.twist_stretch = true"});
  return called;
}

std::vector<CalledEffect> contact_effects(const ContactSettings& contact) {
  if (contact.scope == ContactScope::none) return {};
  const bool all = contact.scope == ContactScope::all;
  std::vector<CalledEffect> called;
  called.push_back({all ? "contact of all fibers" : "contact of fibers of different yarns",
                    fmt::format("effects.contact = \"{}\"", all ? "all" : "between_yarns")});
  if (contact.self_contact) called.push_back({"contact of a fiber with itself", "effects.self_contact = true"});
  if (contact.friction)
    called.push_back(
        {fmt::format("friction, coefficient {:g}", contact.friction_coefficient), "effects.friction = true"});
  if (contact.adapt_penalty)
    called.push_back({fmt::format("penalties adapted toward a penetration of {:g} R", contact.target_penetration),
                      "effects.adapt_penalty = true"});
  return called;
}

std::vector<CalledEffect> stage_effects(const Stage& stage) {
  std::vector<CalledEffect> called;
  const auto add = [&](std::string effect, const std::string& key) {
    called.push_back({std::move(effect), fmt::format("{} of stage \"{}\"", key, stage.name)});
  };
  if (stage.fiber_model)
    add(model_effect(*stage.fiber_model), fmt::format("fiber_model = \"{}\"", model_name(*stage.fiber_model)));
  if (stage.separate_yarns) add("crossing order of the weave", "separate_yarns = true");
  if (stage.proximal_start > 0) add("proximal damping", fmt::format("proximal_start = {:g}", stage.proximal_start));
  return called;
}

std::string drive_text(const Drive& drive) {
  static constexpr std::array dof_names = {"x", "y", "z", "rx", "ry", "rz"};
  const bool rotates = drive.dof >= BodyDof::rx;
  const std::string driven = fmt::format("{} {}", drive.bodies, dof_names[static_cast<std::size_t>(drive.dof)]);
  switch (drive.mode) {
    case DriveMode::displacement:
      return fmt::format("{} by {:g} {}", driven, drive.value, rotates ? "rad" : "m");
    case DriveMode::force:
      return fmt::format("{} to {} {:g} {}", driven, rotates ? "moment" : "force", drive.value, rotates ? "N m" : "N");
    case DriveMode::strain:
      return fmt::format("{} to strain {:g}", driven, drive.value);
    case DriveMode::follow:
      return fmt::format("{} follows {}", driven, drive.leader);
  }
  return driven;
}

std::string stage_text(const Stage& stage, std::int64_t n_dofs, bool may_have_friction) {
  std::string text = fmt::format("  {}: {} increments, {} dofs{}\n", stage.name, stage.n_increments, n_dofs,
                                 may_have_friction && !stage.friction ? ", no friction" : "");
  for (const Drive& drive : stage.drives) text += fmt::format("    {}\n", drive_text(drive));
  return text;
}

std::string bodies_text(const Scene& scene, Index n_bodies) {
  std::vector<std::string> names;
  if (scene.weave)
    names = {fmt::format("warp/1..{}/start|end", scene.weave->warp.n_yarns),
             fmt::format("weft/1..{}/start|end", scene.weave->weft.n_yarns), "side/warp|weft/start|end"};
  for (const BodySpec& body : scene.bodies) names.push_back(body.name);
  return fmt::format("Bodies: {}{}{}\n", n_bodies, names.empty() ? "" : ": ", fmt::join(names, ", "));
}

}  // namespace

std::vector<CalledEffect> called_effects(const Scene& scene) {
  std::vector<CalledEffect> called = fiber_effects(scene);
  const auto append = [&](const std::vector<CalledEffect>& more) {
    called.insert(called.end(), more.begin(), more.end());
  };
  append(contact_effects(scene.contact));
  for (const Stage& stage : scene.stages) append(stage_effects(stage));
  return called;
}

std::string size_text(const ModelSize& size) {
  return fmt::format("{} fibers, {} nodes, {} dofs, {} bodies; about {} and {}", size.n_fibers, size.n_nodes,
                     size.n_dofs, size.n_bodies, duration_text(size.estimated_seconds),
                     bytes_text(size.estimated_bytes));
}

std::string scene_overview(const Scene& scene, const ModelSize& size) {
  std::string text = fmt::format("Size: {} (order of magnitude, two cores)\n", size_text(size));
  text += bodies_text(scene, size.n_bodies);
  text += "Effects, and the keys that call for them:\n";
  for (const CalledEffect& called : called_effects(scene))
    text += fmt::format("  {:<48} {}\n", called.effect, called.key);
  text += "Stages:\n";
  for (std::size_t i = 0; i < scene.stages.size(); ++i)
    text += stage_text(scene.stages[i], i < size.n_dofs_per_stage.size() ? size.n_dofs_per_stage[i] : size.n_dofs,
                       scene.contact.scope != ContactScope::none && scene.contact.friction);
  return text;
}

}  // namespace trame::workflows
