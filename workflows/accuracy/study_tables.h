#pragma once
/// \file
/// A study as tables: CSV for programs, Markdown for people.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "workflows/accuracy/study.h"

namespace trame::workflows {

/// A line for each case, failures among them: what ran, how it ended, what it took, then each quantity with its error.
/// Throws WriteError.
void write_study_csv(const std::filesystem::path& file, const Study& study);

/// Reference, orders, effects, recommendation.
[[nodiscard]] std::string study_markdown(const Study& study, const Profile& profile, const std::string& command);

/// How errors of the primary quantities fall along a knob.
struct OrderPoint {
  Setting setting;
  double cpu_seconds = 0;
  double error = 0;                 ///< against the reference or the closed form: with what the other knobs contribute
  double distance = 0;              ///< from the knob's own finest value: its own contribution
  std::optional<double> order;      ///< of the error, since the value before
  std::optional<double> own_order;  ///< of the distance
};
/// The values of a knob of numbers while everything else is the scene's own, coarse to fine.
[[nodiscard]] std::vector<OrderPoint> orders_along(const Study& study, const Knob& knob);

/// Cases that vary only this knob, the base among them with its value of the scene, in the order in which they were
/// planned.
[[nodiscard]] std::vector<const CaseResult*> along_knob(const Study& study, const std::string& knob);
/// Done cases of the scene's effects that no other is both cheaper in CPU time and of a smaller trusted error than;
/// cheapest first.
[[nodiscard]] std::vector<const CaseResult*> pareto_front(const Study& study);

}  // namespace trame::workflows
