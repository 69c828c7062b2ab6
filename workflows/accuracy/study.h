#pragma once
/// \file
/// A study of what accuracy costs: runs every case of a scene in a process of its own, and compares.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workflows/accuracy/cases.h"
#include "workflows/accuracy/profile.h"
#include "workflows/accuracy/quantity.h"

namespace trame::workflows {

/// What a case came to. A case that failed has no quantities.
struct CaseResult {
  Case what;
  std::string status = "not run";  ///< "done", "gave up", "bad input", "failed", "crashed", "interrupted"
  std::string message;             ///< of a failure
  std::vector<double> wall_seconds, cpu_seconds;  ///< of each repeat
  double peak_memory_bytes = 0;                   ///< that the run itself reports
  std::map<std::string, double> counts;           ///< of summary.json
  std::optional<double> estimate;                 ///< a posteriori, of the run's own summary.json
  std::vector<Quantity> quantities;
  std::map<std::string, double> errors;  ///< relative to the reference, by quantity
  double error = 0;                      ///< largest of the primary ones
  /// The largest error of this case and of all of the same effects that are at least as fine in every knob: a coarse
  /// run may be close to the reference by chance, and the next finer one shows it.
  double trusted_error = 0;

  [[nodiscard]] bool is_done() const { return status == "done"; }
  [[nodiscard]] double seconds() const;  ///< wall clock, median
  [[nodiscard]] double cpu() const;      ///< median
};

struct Study {
  std::string scene, title;
  std::map<std::string, std::string> scene_values;  ///< of each knob that the scene has a use for
  std::vector<CaseResult> results;                  ///< the base comes first
  std::optional<ClosedForm> closed_form;
  bool has_reference = false;  ///< the reference and the looser one are there: errors are known
  double reference_uncertainty = 0;
  std::string reference;  ///< in words
  std::string measure;    ///< in words
  int n_threads = 0, n_repeats = 0;
};

struct StudyOptions {
  std::filesystem::path scene_file, program, folder;  ///< program: simulate_fibers; folder: for the runs' files
  int n_threads = 1, n_repeats = 3;                   ///< of each run; of each case
  std::function<bool()> stop;                         ///< asked before each run
  std::function<void(const std::string&)> tell;
  std::function<std::vector<Quantity>(const micro::Scene&, const std::filesystem::path&)> read;
};

[[nodiscard]] double median(std::vector<double> values);

/// Quantities by name that a case is compared with: the closed form where it has the quantity, else `run`.
[[nodiscard]] std::vector<Quantity> with_closed_form(std::vector<Quantity> run,
                                                     const std::optional<ClosedForm>& closed_form);
/// |value − reference| over the largest reference of the group, by name; quantities that only one side has are left
/// out.
[[nodiscard]] std::map<std::string, double> relative_errors(const std::vector<Quantity>& quantities,
                                                            const std::vector<Quantity>& reference);
/// Largest of the errors of primary quantities; NaN where there is none.
[[nodiscard]] double primary_error(const std::vector<Quantity>& quantities,
                                   const std::map<std::string, double>& errors);

/// Runs the cases: all once, then again in reverse order, and so on; the references once only.
[[nodiscard]] Study run_study(const micro::Scene& scene, const std::vector<Case>& cases,
                              std::optional<ClosedForm> closed_form, const StudyOptions& options);

/// Fills in the errors, once all cases have run.
void compare(Study& study);

/// The runs that ended well, for `--accuracy`.
[[nodiscard]] Profile profile_of(const Study& study, const micro::Scene& scene, const std::string& command);

}  // namespace trame::workflows
