#include "workflows/scene_overview.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <set>

#include "micro/scene/weave.h"
#include "micro/weave/overlaps.h"
#include "workflows/program/terminal.h"

namespace trame::workflows {

using namespace micro;

namespace {

const char* model_name(FiberModel model) { return model == FiberModel::enriched ? "enriched" : "rod"; }
const char* model_effect(FiberModel model) { return model == FiberModel::enriched ? "enriched beams" : "rods"; }

/// "effects.friction = true", and whether the scene says so itself.
std::string effect_key(const Scene& scene, const std::string& name, const std::string& value) {
  const auto& stated = scene.stated_effects;
  const bool is_stated = std::find(stated.begin(), stated.end(), name) != stated.end();
  return fmt::format("effects.{} = {}{}", name, value, is_stated ? "" : " (default)");
}

PricedEffect priced(FiberModel model) {
  return model == FiberModel::enriched ? PricedEffect::enriched_beams : PricedEffect::rods;
}

/// Models of the fibers. A fiber type calls for its model only where fibers are of the type and a stage leaves them
/// their own.
std::vector<CalledEffect> fiber_effects(const Scene& scene) {
  std::vector<CalledEffect> called;
  const auto by_type = [](const Stage& stage) { return !stage.fiber_model; };
  if (scene.stages.empty() || std::any_of(scene.stages.begin(), scene.stages.end(), by_type))
    for (const Index t : fiber_types_in_use(scene)) {
      const FiberType& type = scene.fiber_types[t];
      called.push_back({priced(type.model), model_effect(type.model),
                        fmt::format("fiber_type.{}.model = \"{}\"", type.name, model_name(type.model))});
    }
  for (const Stage& stage : scene.stages)
    if (stage.fiber_model)
      called.push_back(
          {priced(*stage.fiber_model), model_effect(*stage.fiber_model),
           fmt::format("fiber_model = \"{}\" of stage \"{}\"", model_name(*stage.fiber_model), stage.name)});
  const auto is_enriched = [](const CalledEffect& effect) { return effect.kind == PricedEffect::enriched_beams; };
  if (scene.twist_stretch && std::any_of(called.begin(), called.end(), is_enriched))
    called.push_back(
        {PricedEffect::twist_stretch, "coupling of twist and stretch", effect_key(scene, "twist_stretch", "true")});
  return called;
}

std::vector<CalledEffect> contact_effects(const Scene& scene) {
  const ContactSettings& contact = scene.contact;
  if (contact.scope == ContactScope::none) return {};
  const bool all = contact.scope == ContactScope::all;
  std::vector<CalledEffect> called;
  called.push_back({PricedEffect::contact, all ? "contact of all fibers" : "contact of fibers of different yarns",
                    effect_key(scene, "contact", all ? "\"all\"" : "\"between_yarns\"")});
  if (contact.self_contact)
    called.push_back(
        {PricedEffect::self_contact, "contact of a fiber with itself", effect_key(scene, "self_contact", "true")});
  const auto rubs = [](const Stage& stage) { return stage.friction; };
  const bool somewhere = scene.stages.empty() || std::any_of(scene.stages.begin(), scene.stages.end(), rubs);
  if (contact.friction && contact.friction_coefficient > 0 && somewhere)
    called.push_back({PricedEffect::friction, fmt::format("friction, coefficient {:g}", contact.friction_coefficient),
                      effect_key(scene, "friction", "true")});
  if (contact.adapt_penalty)
    called.push_back({PricedEffect::adaptation,
                      fmt::format("penalties adapted to penetrate by {:g} R", contact.target_penetration),
                      effect_key(scene, "adapt_penalty", "true")});
  return called;
}

std::vector<CalledEffect> body_effects(const Scene& scene) {
  std::vector<CalledEffect> called;
  if (scene.weave) called.push_back({PricedEffect::bodies, "rigid bodies and their ties", "[weave]"});
  if (!scene.bodies.empty()) called.push_back({PricedEffect::bodies, "rigid bodies and their ties", "[[body]]"});
  for (const BodySpec& body : scene.bodies)
    if (!body.surfaces.empty())
      called.push_back(
          {PricedEffect::surfaces, "contact with rigid surfaces", fmt::format("surface of body \"{}\"", body.name)});
  return called;
}

std::string key_of(LoadKind kind) { return kind == LoadKind::gravity ? "gravity" : "force_per_length"; }

std::vector<CalledEffect> stage_effects(const Stage& stage) {
  std::vector<CalledEffect> called;
  const auto add = [&](PricedEffect kind, std::string effect, const std::string& key) {
    called.push_back({kind, std::move(effect), fmt::format("{} of stage \"{}\"", key, stage.name)});
  };
  const auto drives = [&](DriveMode mode) {
    return std::any_of(stage.drives.begin(), stage.drives.end(), [=](const Drive& d) { return d.mode == mode; });
  };
  if (stage.separate_yarns) add(PricedEffect::crossing_order, "crossing order of the weave", "separate_yarns = true");
  if (drives(DriveMode::follow)) add(PricedEffect::follow, "bodies that follow others", "follow");
  if (drives(DriveMode::force)) add(PricedEffect::loads, "forces and moments on bodies", "force");
  for (const char* key : {"force_per_length", "gravity"})
    if (std::any_of(stage.loads.begin(), stage.loads.end(), [=](const FiberLoad& l) { return key == key_of(l.kind); }))
      add(PricedEffect::fiber_loads, "forces per length on fibers", key);
  if (stage.proximal_start > 0)
    add(PricedEffect::proximal, "proximal damping", fmt::format("proximal_start = {:g}", stage.proximal_start));
  return called;
}

/// An effect a line, with what it costs; further keys that call for it on lines of their own.
std::string effects_text(const Scene& scene, const CostEstimate& cost) {
  const std::vector<CalledEffect> called = called_effects(scene);
  std::string text = fmt::format("  {:<40}{:>9}{:>9}{:>13}  {}\n", "effect", "dofs", "memory", "time", "called for by");
  for (int kind = 0; kind < n_priced_effects; ++kind) {
    bool first = true;
    for (const CalledEffect& call : called) {
      if (call.kind != static_cast<PricedEffect>(kind)) continue;
      const auto price = std::find_if(cost.effects.begin(), cost.effects.end(),
                                      [&](const EffectCost& c) { return c.effect == call.kind; });
      if (first && price != cost.effects.end())
        text += fmt::format("  {:<40}{:>9}{:>9}{:>13}  {}\n", call.effect, price->n_dofs, bytes_text(price->bytes),
                            duration_text(price->seconds), call.key);
      else
        text += fmt::format("  {:<71}  {}\n", first ? call.effect : "", call.key);
      first = false;
    }
  }
  return text + fmt::format("  {:<49}{:>9}{:>13}\n", "all, with program and files", bytes_text(cost.bytes),
                            duration_text(cost.seconds));
}

/// ", times 1 at 0.5, 0 at 1"; nothing for a ramp.
std::string amplitude_text(const Amplitude& amplitude) {
  std::string text;
  for (const Amplitude::Point& point : amplitude.points)
    text += fmt::format("{}{:g} at {:g}", text.empty() ? ", times " : ", ", point.share, point.time);
  return text;
}

std::string drive_text(const Drive& drive) {
  const bool rotates = drive.dof >= BodyDof::rx;
  std::string driven = fmt::format("{} {}", drive.bodies, dof_name(drive.dof));
  switch (drive.mode) {
    case DriveMode::displacement: return fmt::format("{} by {:g} {}", driven, drive.value, rotates ? "rad" : "m");
    case DriveMode::force:
      return fmt::format("{} to {} {:g} {}", driven, rotates ? "moment" : "force", drive.value, rotates ? "N m" : "N");
    case DriveMode::strain: return fmt::format("{} to strain {:g}", driven, drive.value);
    case DriveMode::follow: return fmt::format("{} follows {}", driven, drive.leader);
  }
  return driven;
}

/// "gravity of (0, 0, -9.81) m/s2 on *"; with its name where it has one of its own.
std::string load_text(const FiberLoad& load) {
  const std::string key = key_of(load.kind);
  return fmt::format("{}{} of ({:g}, {:g}, {:g}) {} on {}", load.name == key ? "" : load.name + ": ", key,
                     load.value[0], load.value[1], load.value[2], load.kind == LoadKind::gravity ? "m/s2" : "N/m",
                     fmt::join(load.fibers, ", "));
}

/// The loads of a stage, and those of earlier ones that stay on, of which the names stand in `standing`.
std::string loads_text(const Stage& stage, std::set<std::string>& standing) {
  std::string text;
  for (const std::string& name : standing)
    if (std::none_of(stage.loads.begin(), stage.loads.end(), [&](const FiberLoad& l) { return l.name == name; }))
      text += fmt::format("    {} stays on\n", name);
  for (const FiberLoad& load : stage.loads) {
    text += fmt::format("    {}{}\n", load_text(load), amplitude_text(load.amplitude));
    const double share = load.amplitude.at(1);
    if (share == 1 && load.value.isZero(0))
      standing.erase(load.name);
    else if (share != 0 && !load.value.isZero(0))
      standing.insert(load.name);
  }
  return text;
}

std::string stage_text(const Stage& stage, std::int64_t n_dofs, bool may_have_friction,
                       std::set<std::string>& standing_loads) {
  std::string text = fmt::format("  {}: {} increments, {} dofs{}", stage.name, stage.n_increments, n_dofs,
                                 may_have_friction && !stage.friction ? ", no friction" : "");
  if (stage.fiber_model) text += fmt::format(", {}", model_effect(*stage.fiber_model));
  if (!stage.sliding_ends.empty()) text += fmt::format(", fibers slide in {}", stage.sliding_ends);
  if (stage.proximal_start > 0) text += fmt::format(", damping {:g} to {:g}", stage.proximal_start, stage.proximal_end);
  text += "\n";
  for (const Drive& drive : stage.drives)
    text += fmt::format("    {}{}\n", drive_text(drive), amplitude_text(drive.amplitude));
  return text + loads_text(stage, standing_loads);
}

std::string bodies_text(const Scene& scene, Index n_bodies) {
  std::vector<std::string> names;
  if (scene.weave && scene.weave->is_periodic()) {
    for (const auto& [family, yarns] : {std::pair{"warp", &scene.weave->warp}, {"weft", &scene.weave->weft}})
      if (yarns->periodic) {
        names.emplace_back(period_name(yarns == &scene.weave->warp));
      } else {
        names.push_back(fmt::format("{}/1..{}/start|end", family, yarns->n_yarns));
        names.push_back(fmt::format("side/{}/start|end", family));
      }
  } else if (scene.weave) {
    names = {fmt::format("warp/1..{}/start|end", scene.weave->warp.n_yarns),
             fmt::format("weft/1..{}/start|end", scene.weave->weft.n_yarns), "side/warp|weft/start|end"};
  }
  if (scene.weave && scene.weave->is_skew())
    names.back() +=
        fmt::format(" (x along the warp, y along the weft at {:.4g} deg)", scene.weave->angle * 180 / std::numbers::pi);
  for (const BodySpec& body : scene.bodies) names.push_back(body.name);
  return fmt::format("Bodies: {}{}{}\n", n_bodies, names.empty() ? "" : ": ", fmt::join(names, ", "));
}

}  // namespace

std::vector<CalledEffect> called_effects(const Scene& scene) {
  std::vector<CalledEffect> called = fiber_effects(scene);
  const auto append = [&](const std::vector<CalledEffect>& more) {
    called.insert(called.end(), more.begin(), more.end());
  };
  append(contact_effects(scene));
  append(body_effects(scene));
  for (const Stage& stage : scene.stages) append(stage_effects(stage));
  return called;
}

std::string size_text(const ModelSize& size, const CostEstimate& cost) {
  return fmt::format("{} fibers, {} nodes, {} dofs, {} bodies; about {} and {}{}", size.n_fibers, size.n_nodes,
                     size.n_dofs, size.n_bodies, duration_text(cost.seconds), bytes_text(cost.bytes),
                     cost.extrapolated ? ", extrapolated from fewer fibers or elements" : "");
}

std::string scene_overview(const Scene& scene, const ModelSize& size, const CostEstimate& cost) {
  std::string text = fmt::format("Size: {}\n", size_text(size, cost));
  text += bodies_text(scene, size.n_bodies);
  text +=
      "Effects, what each costs (order of magnitude, two cores; memory in the stage with most), and the keys that call "
      "for them:\n";
  text += effects_text(scene, cost);
  text += scene.stages_are_chosen ? "Stages, chosen from the geometry, because the scene names none:\n" : "Stages:\n";
  std::set<std::string> standing_loads;
  for (std::size_t i = 0; i < scene.stages.size(); ++i)
    text += stage_text(scene.stages[i], i < size.n_dofs_per_stage.size() ? size.n_dofs_per_stage[i] : size.n_dofs,
                       scene.contact.scope != ContactScope::none && scene.contact.friction, standing_loads);
  return text;
}

std::string start_warning(const Scene& scene) {
  const Assembly assembly = assemble_scene(scene);
  const std::optional<Overlap> overlap = deepest_overlap(assembly);
  if (!overlap) return "";
  const auto name = [&](Index fiber) { return assembly.mesh.yarns[assembly.mesh.yarn_of_fiber[fiber]].name; };
  return fmt::format(
      "\"{}\" and \"{}\" lie in each other at the start, by {:.3g} m at ({:.4g}, {:.4g}, {:.4g}) m, {:.2g} of the "
      "thinner fiber's radius: contact will throw them apart",
      name(overlap->fiber_a), name(overlap->fiber_b), overlap->depth, overlap->place[0], overlap->place[1],
      overlap->place[2],
      overlap->depth / std::min(assembly.mesh.radius[overlap->fiber_a], assembly.mesh.radius[overlap->fiber_b]));
}

}  // namespace trame::workflows
