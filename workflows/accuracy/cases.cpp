#include "workflows/accuracy/cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "micro/core/error.h"

namespace trame::workflows {

namespace {

const std::string* value_of(const Settings& settings, const std::string& knob) {
  const auto s = std::find_if(settings.begin(), settings.end(), [&](const Setting& x) { return x.knob == knob; });
  return s == settings.end() ? nullptr : &s->value;
}

bool is_wanted(const Knob& knob, const CaseOptions& options) {
  return options.knobs.empty() ||
         std::find(options.knobs.begin(), options.knobs.end(), knob.name) != options.knobs.end();
}

bool keeps_effects(const Settings& settings) {
  return std::all_of(settings.begin(), settings.end(), [](const Setting& s) { return find_knob(s.knob).is_numerical; });
}

/// Adds a case unless its settings are there.
void add(std::vector<Case>& cases, const micro::Scene& scene, const Settings& settings, CasePart part) {
  const Settings wanted = canonical(scene, settings);
  if (std::none_of(cases.begin(), cases.end(), [&](const Case& c) { return c.settings == wanted; }))
    cases.push_back({wanted, part, keeps_effects(wanted)});
}

void add_grid(std::vector<Case>& cases, const micro::Scene& scene, const std::vector<Settings>& grid) {
  std::vector<Settings> points = {{}};
  for (const Settings& axis : grid) {
    std::vector<Settings> more;
    for (const Settings& point : points)
      for (const Setting& setting : axis) {
        more.push_back(point);
        more.back().push_back(setting);
      }
    points = std::move(more);
  }
  for (const Settings& point : points) add(cases, scene, point, CasePart::grid);
}

/// The reference, or what is `looser` by one value in every knob.
Settings reference_settings(const micro::Scene& scene, const CaseOptions& options, bool looser) {
  Settings reference;
  for (const Knob& knob : knobs()) {
    if (!knob.is_numerical || knob.current(scene).empty() || !is_wanted(knob, options)) continue;
    const Settings values = values_to_try(scene, knob, options);
    auto at = values.end() - 1;
    if (const std::string* wanted = value_of(options.reference, knob.name))
      at = std::find_if(values.begin(), values.end(), [&](const Setting& s) { return same_value(s.value, *wanted); });
    reference.push_back(looser && at != values.begin() ? *(at - 1) : *at);
  }
  return reference;
}

/// The reference cases may be in the sweeps already; they are found by what they are for.
void add_reference(std::vector<Case>& cases, const micro::Scene& scene, const Settings& settings, CasePart part) {
  const Settings wanted = canonical(scene, settings);
  std::erase_if(cases, [&](const Case& c) { return c.settings == wanted && c.part != CasePart::base; });
  cases.push_back({wanted, part, true});
}

void check_use(const micro::Scene& scene, const std::string& knob) {
  if (find_knob(knob).current(scene).empty())
    throw InputError(fmt::format("knob {}: scene {} has no use for it", knob, scene.name));
}

}  // namespace

std::string text(CasePart part) {
  switch (part) {
    case CasePart::base: return "base";
    case CasePart::one_knob: return "one knob";
    case CasePart::grid: return "grid";
    case CasePart::reference: return "reference";
    case CasePart::looser_reference: return "looser reference";
  }
  return "";
}

bool same_value(const std::string& a, const std::string& b) {
  return a == b || number_of(a) == number_of(b);  // NaN for words equals nothing
}

Settings canonical(const micro::Scene& scene, const Settings& settings) {
  Settings kept;
  for (const Knob& knob : knobs())
    if (const std::string* value = value_of(settings, knob.name); value && !same_value(*value, knob.current(scene)))
      kept.push_back({knob.name, *value});
  return kept;
}

Settings values_to_try(const micro::Scene& scene, const Knob& knob, const CaseOptions& options) {
  Settings values;
  for (const Settings& given : options.values)
    if (!given.empty() && given.front().knob == knob.name) values = given;
  if (values.empty())
    for (const std::string& value : knob.values) values.push_back({knob.name, value});
  const auto offer = [&](const std::string& value) {
    if (std::none_of(values.begin(), values.end(), [&](const Setting& s) { return same_value(s.value, value); }))
      values.push_back({knob.name, value});
  };
  const bool has_numbers = std::isfinite(fineness(values.front()));
  if (has_numbers) offer(knob.current(scene));
  if (const std::string* reference = value_of(options.reference, knob.name)) offer(*reference);
  if (has_numbers)
    std::stable_sort(values.begin(), values.end(),
                     [](const Setting& a, const Setting& b) { return fineness(a) < fineness(b); });
  return values;
}

std::vector<Case> plan_cases(const micro::Scene& scene, const CaseOptions& options) {
  for (const std::string& name : options.knobs) check_use(scene, name);
  for (const std::vector<Settings>* lists : {&options.values, &options.grid})
    for (const Settings& list : *lists) check_use(scene, list.front().knob);
  for (const Setting& s : options.reference)
    if (check_use(scene, s.knob); !find_knob(s.knob).is_numerical)
      throw InputError(fmt::format(
          "reference {}={}: must be a knob of the numerics; the reference has the scene's effects", s.knob, s.value));
  std::vector<Case> cases = {{}};
  for (const Knob& knob : knobs())
    if (is_wanted(knob, options) && !knob.current(scene).empty())
      for (const Setting& setting : values_to_try(scene, knob, options))
        add(cases, scene, {setting}, CasePart::one_knob);
  add_grid(cases, scene, options.grid);
  add_reference(cases, scene, reference_settings(scene, options, true), CasePart::looser_reference);
  add_reference(cases, scene, reference_settings(scene, options, false), CasePart::reference);
  return cases;
}

}  // namespace trame::workflows
