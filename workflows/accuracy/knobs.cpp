#include "workflows/accuracy/knobs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "micro/core/error.h"

namespace trame::workflows {

using namespace micro;

namespace {

[[noreturn]] void refuse(const std::string& knob, const std::string& value, const std::string& allowed) {
  throw InputError(fmt::format("setting {}={}: must be {}", knob, value, allowed));
}

/// A knob that is a number above 0 and up to `most`.
Knob number_knob(const std::string& name, const std::string& meaning, double most, std::vector<std::string> values,
                 const std::string& theory, const std::function<void(Scene&, double)>& set,
                 const std::function<std::string(const Scene&)>& current) {
  const std::string allowed = fmt::format("a number above 0, up to {:g}", most);
  const auto apply = [=](Scene& scene, const std::string& value) {
    const double x = number_of(value);
    if (!(x > 0 && x <= most)) refuse(name, value, allowed);
    set(scene, x);
  };
  return {name, meaning, allowed, std::move(values), true, false, theory, apply, current};
}

/// A knob that multiplies numbers of the scene.
Knob multiple_knob(const std::string& name, const std::string& meaning, std::vector<std::string> values,
                   const std::string& theory, const std::function<void(Scene&, double)>& multiply) {
  Knob knob = number_knob(name, meaning, 100, std::move(values), theory, multiply, [](const Scene&) { return "1"; });
  knob.larger_is_finer = true;
  return knob;
}

/// A knob that is one of a few words, and how each changes a scene.
Knob word_knob(const std::string& name, const std::string& meaning,
               const std::vector<std::pair<std::string, std::function<void(Scene&)>>>& words,
               const std::function<std::string(const Scene&)>& current) {
  std::vector<std::string> values;
  for (const auto& word : words) values.push_back(word.first);
  const std::string allowed = fmt::format("one of {}", fmt::join(values, ", "));
  const auto apply = [=](Scene& scene, const std::string& value) {
    const auto word = std::find_if(words.begin(), words.end(), [&](const auto& w) { return w.first == value; });
    if (word == words.end()) refuse(name, value, allowed);
    word->second(scene);
  };
  return {name, meaning, allowed, values, false, false, "", apply, current};
}

Knob switch_knob(const std::string& name, const std::string& meaning, const std::function<bool&(Scene&)>& field,
                 const std::function<bool(const Scene&)>& has_use) {
  return word_knob(name, meaning,
                   {{"off", [=](Scene& s) { field(s) = false; }}, {"on", [=](Scene& s) { field(s) = true; }}},
                   [=](const Scene& scene) -> std::string {
                     if (!has_use(scene)) return "";
                     Scene copy = scene;
                     return field(copy) ? "on" : "off";
                   });
}

Index scaled(Index n, double factor) { return std::max<Index>(1, static_cast<Index>(std::lround(n * factor))); }

void scale_elements(Scene& scene, double factor) {
  for (FiberSpec& fiber : scene.fibers) fiber.n_elements = scaled(fiber.n_elements, factor);
  for (BundleSpec& bundle : scene.bundles) bundle.n_elements = scaled(bundle.n_elements, factor);
  if (!scene.weave) return;
  for (YarnSystem* system : {&scene.weave->warp, &scene.weave->weft})
    system->n_elements = scaled(system->n_elements, factor);
}

bool has_contact(const Scene& scene) { return scene.contact.scope != ContactScope::none; }

void use_model(Scene& scene, FiberModel model) {
  for (FiberType& type : scene.fiber_types) type.model = model;
  for (Stage& stage : scene.stages)
    if (stage.fiber_model) stage.fiber_model = model;
}

/// "enriched" or "rod" where all fibers of all stages agree, else "scene".
std::string current_model(const Scene& scene) {
  bool rods = false, enriched = false;
  const auto meet = [&](FiberModel model) { (model == FiberModel::rod ? rods : enriched) = true; };
  for (const FiberType& type : scene.fiber_types) meet(type.model);
  for (const Stage& stage : scene.stages)
    if (stage.fiber_model) meet(*stage.fiber_model);
  return rods && enriched ? "scene" : rods ? "rod" : "enriched";
}

void use_contact(Scene& scene, ContactScope scope) {
  scene.contact.scope = scope;
  if (scope == ContactScope::none)
    scene.contact.self_contact = scene.contact.friction = scene.contact.adapt_penalty = false;
}

std::string current_contact(const Scene& scene) {
  return !has_contact(scene) ? "none" : scene.contact.scope == ContactScope::all ? "all" : "between_yarns";
}

std::function<std::string(const Scene&)> shown(const std::function<double(const Scene&)>& value,
                                               const std::function<bool(const Scene&)>& has_use) {
  return [=](const Scene& scene) { return has_use(scene) ? fmt::format("{:g}", value(scene)) : std::string(); };
}

bool always(const Scene&) { return true; }

std::vector<Knob> numerical_knobs() {
  const auto adapts = [](const Scene& s) { return has_contact(s) && s.contact.adapt_penalty; };
  return {
      multiple_knob("elements", "elements of every fiber, as a multiple of the scene's",
                    {"0.5", "0.75", "1", "1.5", "2"}, "4 in smooth bending, less at contacts", scale_elements),
      multiple_knob("increments", "increments of every stage, as a multiple of the scene's",
                    {"0.25", "0.5", "1", "2", "4"}, "1 with friction or adapted penalties, else no dependence",
                    [](Scene& s, double x) {
                      for (Stage& stage : s.stages) stage.n_increments = scaled(stage.n_increments, x);
                    }),
      number_knob(
          "contact_spacing", "distance of contact elements, in element lengths", 10, {"1", "0.5", "0.25"}, "2",
          [](Scene& s, double x) { s.contact.spacing = x; },
          shown([](const Scene& s) { return s.contact.spacing; }, has_contact)),
      number_knob(
          "target_penetration", "penetration that penalties are adapted to, in R", 1,
          {"0.06", "0.03", "0.015", "0.0075"}, "1", [](Scene& s, double x) { s.contact.target_penetration = x; },
          shown([](const Scene& s) { return s.contact.target_penetration; }, adapts)),
      number_knob(
          "force_tolerance", "residual at which Newton's method ends", 0.5, {"1e-3", "1e-4", "1e-5", "1e-6"},
          "1 or more", [](Scene& s, double x) { s.solver.force_tolerance = x; },
          shown([](const Scene& s) { return s.solver.force_tolerance; }, always)),
  };
}

Knob precision_knob() {
  Knob knob = word_knob("factor_precision", "precision of the matrix factor behind conjugate gradients",
                        {{"auto", [](Scene& s) { s.solver.factor_precision = FactorPrecision::automatic; }},
                         {"single", [](Scene& s) { s.solver.factor_precision = FactorPrecision::single_precision; }},
                         {"double", [](Scene& s) { s.solver.factor_precision = FactorPrecision::double_precision; }}},
                        [](const Scene& s) {
                          switch (s.solver.factor_precision) {
                            case FactorPrecision::automatic: return "auto";
                            case FactorPrecision::single_precision: return "single";
                            case FactorPrecision::double_precision: return "double";
                          }
                          return "";
                        });
  knob.is_numerical = true;
  return knob;
}

std::vector<Knob> effect_knobs() {
  const auto enriched = [](const Scene& s) { return current_model(s) != "rod"; };
  return {
      word_knob("fiber_model", "model of every fiber in every stage",
                {{"rod", [](Scene& s) { use_model(s, FiberModel::rod); }},
                 {"enriched", [](Scene& s) { use_model(s, FiberModel::enriched); }}},
                current_model),
      word_knob("contact", "fibers that feel each other",
                {{"none", [](Scene& s) { use_contact(s, ContactScope::none); }},
                 {"between_yarns", [](Scene& s) { use_contact(s, ContactScope::between_yarns); }},
                 {"all", [](Scene& s) { use_contact(s, ContactScope::all); }}},
                [](const Scene& s) { return has_contact(s) ? current_contact(s) : ""; }),
      switch_knob(
          "self_contact", "contact of a fiber with itself", [](Scene& s) -> bool& { return s.contact.self_contact; },
          has_contact),
      switch_knob(
          "friction", "friction", [](Scene& s) -> bool& { return s.contact.friction; }, has_contact),
      switch_knob(
          "adapt_penalty", "penalties adapted zone by zone", [](Scene& s) -> bool& { return s.contact.adapt_penalty; },
          has_contact),
      switch_knob(
          "twist_stretch", "coupling of twist and stretch", [](Scene& s) -> bool& { return s.twist_stretch; },
          enriched),
  };
}

}  // namespace

std::string text(const Settings& settings) {
  std::vector<std::string> words;
  for (const Setting& s : settings) words.push_back(s.knob + "=" + s.value);
  return words.empty() ? "as the scene" : fmt::format("{}", fmt::join(words, " "));
}

const std::vector<Knob>& knobs() {
  static const std::vector<Knob> all = [] {
    std::vector<Knob> made = numerical_knobs();
    made.push_back(precision_knob());
    for (Knob& knob : effect_knobs()) made.push_back(std::move(knob));
    return made;
  }();
  return all;
}

const Knob& find_knob(const std::string& name) {
  std::vector<std::string> names;
  for (const Knob& knob : knobs()) {
    if (knob.name == name) return knob;
    names.push_back(knob.name);
  }
  throw InputError(fmt::format("knob {}: unknown; must be one of {}", name, fmt::join(names, ", ")));
}

Settings parse_values(const std::string& text) {
  const std::size_t split = text.find('=');
  if (split == std::string::npos) throw InputError(fmt::format("setting {}: must be knob=value", text));
  const Knob& knob = find_knob(text.substr(0, split));
  Settings settings;
  for (std::size_t at = split; at != std::string::npos;) {
    const std::size_t next = text.find(',', at + 1);
    settings.push_back({knob.name, text.substr(at + 1, next - at - 1)});
    Scene any;
    knob.apply(any, settings.back().value);
    at = next;
  }
  return settings;
}

Setting parse_setting(const std::string& text) {
  const Settings settings = parse_values(text);
  if (settings.size() != 1) throw InputError(fmt::format("setting {}: must be one value", text));
  return settings.front();
}

double number_of(const std::string& value) {
  double x = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), x);
  return error == std::errc() && end == value.data() + value.size() ? x : std::numeric_limits<double>::quiet_NaN();
}

double fineness(const Setting& setting) {
  const double x = number_of(setting.value);
  return find_knob(setting.knob).larger_is_finer ? x : 1 / x;
}

Scene with_settings(Scene scene, const Settings& settings) {
  for (auto s = settings.begin(); s != settings.end(); ++s) {
    const Knob& knob = find_knob(s->knob);
    if (knob.current(scene).empty())
      throw InputError(fmt::format("setting {}={}: scene {} has no use for it", s->knob, s->value, scene.name));
    if (std::any_of(settings.begin(), s, [&](const Setting& other) { return other.knob == s->knob; }))
      throw InputError(fmt::format("setting {}={}: {} is set twice", s->knob, s->value, s->knob));
    knob.apply(scene, s->value);
  }
  if (!settings.empty()) scene.text += fmt::format("\n# Run with these changes: {}\n", text(settings));
  return scene;
}

}  // namespace trame::workflows
