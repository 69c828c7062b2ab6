#include "workflows/accuracy/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "micro/core/error.h"

namespace trame::workflows {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A line without its comment and without blanks at its ends. Quotes protect a # inside them.
std::string essence(const std::string& line) {
  char quote = 0;
  std::size_t end = 0;
  for (; end < line.size() && (quote != 0 || line[end] != '#'); ++end)
    if (line[end] == '"' || line[end] == '\'') quote = quote == 0 ? line[end] : quote == line[end] ? 0 : quote;
  const std::size_t first = line.find_first_not_of(" \t\r"),
                    last = line.find_last_not_of(" \t\r", end == 0 ? 0 : end - 1);
  return first >= end ? "" : line.substr(first, last + 1 - first);
}

json settings_json(const Settings& settings) {
  json object = json::object();
  for (const Setting& s : settings) object[s.knob] = s.value;
  return object;
}

Settings settings_from(const json& object) {
  Settings settings;
  for (const auto& [knob, value] : object.items()) settings.push_back({knob, value.get<std::string>()});
  return settings;
}

json run_json(const ProfileRun& run) {
  return {{"settings", settings_json(run.settings)},
          {"same_effects", run.same_effects},
          {"error", run.error},
          {"own_error", run.own_error},
          {"seconds", run.seconds},
          {"cpu_seconds", run.cpu_seconds},
          {"peak_memory_bytes", run.peak_memory_bytes},
          {"errors", run.errors}};
}

ProfileRun run_from(const json& object) {
  ProfileRun run;
  run.settings = settings_from(object.at("settings"));
  object.at("same_effects").get_to(run.same_effects);
  object.at("error").get_to(run.error);
  object.at("own_error").get_to(run.own_error);
  object.at("seconds").get_to(run.seconds);
  object.at("cpu_seconds").get_to(run.cpu_seconds);
  object.at("peak_memory_bytes").get_to(run.peak_memory_bytes);
  object.at("errors").get_to(run.errors);
  return run;
}

Profile profile_from(const json& object) {
  Profile p;
  object.at("scene").get_to(p.scene);
  object.at("fingerprint").get_to(p.fingerprint);
  object.at("version").get_to(p.version);
  object.at("command").get_to(p.command);
  object.at("threads").get_to(p.n_threads);
  object.at("measure").get_to(p.measure);
  object.at("reference").get_to(p.reference);
  object.at("reference_uncertainty").get_to(p.reference_uncertainty);
  for (const json& run : object.at("runs")) p.runs.push_back(run_from(run));
  return p;
}

bool same(const Settings& a, const Settings& b) { return std::is_permutation(a.begin(), a.end(), b.begin(), b.end()); }

}  // namespace

std::string fingerprint(const std::string& scene_text) {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  const auto feed = [&](unsigned char c) { hash = (hash ^ c) * 0x100000001b3u; };
  std::istringstream lines(scene_text);
  for (std::string line; std::getline(lines, line);) {
    const std::string rest = essence(line);
    for (const char c : rest) feed(static_cast<unsigned char>(c));
    if (!rest.empty()) feed('\n');
  }
  return fmt::format("{:016x}", hash);
}

fs::path profile_file(const fs::path& scene_file, const fs::path& data) {
  std::error_code none;
  const std::string name = scene_file.stem().string();
  const fs::path folder = scene_file.has_parent_path() ? scene_file.parent_path() : fs::path(".");
  if (fs::equivalent(folder, data / "scenes", none)) return data / "accuracy" / (name + ".json");
  return folder / (name + ".accuracy.json");
}

std::string profile_json(const Profile& p) {
  json object = {{"scene", p.scene},         {"fingerprint", p.fingerprint},
                 {"version", p.version},     {"command", p.command},
                 {"threads", p.n_threads},   {"measure", p.measure},
                 {"reference", p.reference}, {"reference_uncertainty", p.reference_uncertainty},
                 {"runs", json::array()}};
  for (const ProfileRun& run : p.runs) object["runs"].push_back(run_json(run));
  return object.dump(1) + "\n";
}

Profile read_profile(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(
        fmt::format("accuracy profile {}: there is none; accuracy_cost with the scene makes it", file.string()));
  try {
    return profile_from(json::parse(stream));
  } catch (const json::exception& error) {
    throw InputError(fmt::format("accuracy profile {}: not a profile ({}); accuracy_cost makes it anew", file.string(),
                                 error.what()));
  }
}

Profile read_profile_of(const fs::path& file, const micro::Scene& scene) {
  Profile profile = read_profile(file);
  if (profile.fingerprint != fingerprint(scene.text))
    throw InputError(
        fmt::format("accuracy profile {}: scene {} has changed since it was measured; measure again with: {}",
                    file.string(), scene.name, profile.command));
  return profile;
}

double parse_accuracy(const std::string& text) {
  double percent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), percent);
  const bool is_percentage = error == std::errc() && end + 1 == text.data() + text.size() && *end == '%';
  if (!is_percentage || !(percent > 0 && percent < 100))
    throw InputError(fmt::format("--accuracy {}: must be a percentage above 0 and below 100, such as 1%", text));
  return percent / 100;
}

const ProfileRun* cheapest(const Profile& profile, double accuracy) {
  const ProfileRun* best = nullptr;
  for (const ProfileRun& run : profile.runs)
    if (run.same_effects && profile.expected_error(run) <= accuracy &&
        (best == nullptr || run.cpu_seconds < best->cpu_seconds))
      best = &run;
  return best;
}

const ProfileRun& choose_settings(const Profile& profile, double accuracy) {
  if (const ProfileRun* run = cheapest(profile, accuracy)) return *run;
  double least = HUGE_VAL;
  for (const ProfileRun& run : profile.runs)
    if (run.same_effects) least = std::min(least, profile.expected_error(run));
  if (!std::isfinite(least))
    throw InputError(fmt::format("--accuracy: the study of scene {} has no run that ended well; repeat it with: {}",
                                 profile.scene, profile.command));
  // Rounded up, so that the value named is one that is held.
  throw InputError(fmt::format("--accuracy {:g}%: no settings of scene {} held it in the study; must be at least {:g}%",
                               100 * accuracy, profile.scene, std::ceil(1e4 * least) / 100));
}

const ProfileRun* find_run(const Profile& profile, const Settings& settings) {
  const auto run = std::find_if(profile.runs.begin(), profile.runs.end(),
                                [&](const ProfileRun& r) { return same(r.settings, settings); });
  return run == profile.runs.end() ? nullptr : &*run;
}

}  // namespace trame::workflows
