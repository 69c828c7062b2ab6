#pragma once
/// \file
/// Accuracy profile of a scene: what settings cost and how far off they are, from a study by accuracy_cost.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "workflows/accuracy/knobs.h"

namespace trame::workflows {

/// A setting that the study ran.
struct ProfileRun {
  Settings settings;
  bool same_effects = true;  ///< simulates what the scene names: only such runs are chosen
  /// Relative error of what the profile is about: the largest of this run and of all that are at least as fine in every
  /// knob.
  double error = 0;
  double own_error = 0;    ///< of this run alone, which may be small because errors happen to cancel
  double seconds = 0;      ///< wall clock, median
  double cpu_seconds = 0;  ///< median; what a run costs, whatever else the machine does
  double peak_memory_bytes = 0;
  std::map<std::string, double> errors;  ///< of every quantity, relative
};

struct Profile {
  std::string scene;
  std::string fingerprint;  ///< of the scene's text
  std::string version;      ///< of the program that ran the study
  std::string command;      ///< that repeats the study
  int n_threads = 0;
  std::string measure;               ///< what `error` is the error of, in words
  std::string reference;             ///< what it is measured against, in words
  double reference_uncertainty = 0;  ///< of the reference itself, relative, in the same measure
  std::vector<ProfileRun> runs;      ///< those that ended well

  /// What a run is trusted to: its distance from the reference and what the reference may be off itself.
  [[nodiscard]] double expected_error(const ProfileRun& run) const { return run.error + reference_uncertainty; }
};

/// Hash of a scene's text that comments, blank lines and indentation do not change.
[[nodiscard]] std::string fingerprint(const std::string& scene_text);

/// Where the profile of a scene is kept: <data>/accuracy/<scene>.json for the scenes of the data folder, beside the
/// scene as <scene>.accuracy.json for all others.
[[nodiscard]] std::filesystem::path profile_file(const std::filesystem::path& scene_file,
                                                 const std::filesystem::path& data);

[[nodiscard]] std::string profile_json(const Profile& profile);
/// Throws InputError for a file that is missing or not a profile.
[[nodiscard]] Profile read_profile(const std::filesystem::path& file);
/// The same; throws InputError also where the profile was measured on another version of `scene`.
[[nodiscard]] Profile read_profile_of(const std::filesystem::path& file, const micro::Scene& scene);

/// Reads "1%". Throws InputError unless it is a percentage between 0 and 100.
[[nodiscard]] double parse_accuracy(const std::string& text);

/// The run of the same effects that took the least CPU time, among those whose expected error is at most `accuracy`;
/// null where there is none.
[[nodiscard]] const ProfileRun* cheapest(const Profile& profile, double accuracy);
/// The same, but throws InputError, with what is allowed, where none held it.
[[nodiscard]] const ProfileRun& choose_settings(const Profile& profile, double accuracy);
/// The run with these settings, if the study had it.
[[nodiscard]] const ProfileRun* find_run(const Profile& profile, const Settings& settings);

}  // namespace trame::workflows
