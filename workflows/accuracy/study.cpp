#include "workflows/accuracy/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "micro/core/error.h"
#include "workflows/accuracy/measured_run.h"
#include "workflows/program/run_main.h"

namespace trame::workflows {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool is_reference(CasePart part) { return part == CasePart::reference || part == CasePart::looser_reference; }

std::string last_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string last;
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) last = line;
  return last;
}

/// Names what became of a child, and where it failed what it said last.
void tell_end(const MeasuredRun& run, const fs::path& log, CaseResult& result) {
  if (run.signal != 0) {
    result.status = run.signal == SIGINT || run.signal == SIGTERM ? "interrupted" : "crashed";
    result.message = strsignal(run.signal);
    return;
  }
  result.status = run.exit_code == exit_done          ? "done"
                  : run.exit_code == exit_bad_input   ? "bad input"
                  : run.exit_code == exit_ended_early ? "gave up"
                                                      : "failed";
  if (run.exit_code != exit_done) result.message = last_line(log);
}

void read_summary(const fs::path& folder, CaseResult& result) {
  std::ifstream stream(folder / "summary.json");
  if (!stream) return;
  const json summary = json::parse(stream);
  for (const char* key : {"n_dofs", "n_increments", "n_cut_increments", "n_newton_iterations", "n_factorizations",
                          "n_contact_elements_max"})
    result.counts[key] = summary.at(key);
  result.peak_memory_bytes = std::max(result.peak_memory_bytes, summary.at("peak_memory_bytes").get<double>());
  if (result.status == "gave up") result.message = summary.at("message");
  if (result.status == "done") result.status = summary.at("status");
  if (const json& total = summary.at("error_estimate").at("a_posteriori").at("total"); total.is_number())
    result.estimate = total.get<double>();
}

std::vector<std::string> command_of(const CaseResult& result, const StudyOptions& options, const fs::path& out) {
  std::vector<std::string> command = {options.program.string(), options.scene_file.string(), "--out", out.string()};
  if (options.n_threads > 0) command.insert(command.end(), {"--threads", std::to_string(options.n_threads)});
  for (const Setting& s : result.what.settings) command.insert(command.end(), {"--set", s.knob + "=" + s.value});
  return command;
}

/// Runs a case once more; the first time also reads what it came to.
void run_once(const micro::Scene& scene, const StudyOptions& options, CaseResult& result) {
  const fs::path out = options.folder / "run", log = options.folder / "run.log";
  fs::remove_all(out);
  const MeasuredRun run = run_measured(command_of(result, options, out), log);
  const bool is_first = result.wall_seconds.empty();
  CaseResult now = result;
  tell_end(run, log, now);
  try {
    read_summary(out, now);
    if (is_first && now.is_done()) now.quantities = options.read(scene, out);
  } catch (const std::exception& error) {  // half a summary, damaged states
    now.status = "failed";
    now.message = error.what();
  }
  now.wall_seconds.push_back(run.wall_seconds);
  now.cpu_seconds.push_back(run.cpu_seconds);
  result = std::move(now);
  fs::remove_all(out);
  fs::remove(log);
}

const CaseResult* find(const Study& study, CasePart part) {
  for (const CaseResult& r : study.results)
    if (r.what.part == part && r.is_done()) return &r;
  return nullptr;
}

bool all_primary_known(const std::vector<Quantity>& quantities, const ClosedForm& form) {
  return std::all_of(quantities.begin(), quantities.end(),
                     [&](const Quantity& q) { return !q.is_primary || form.values.count(q.name) > 0; });
}

/// Rank of a value of a knob that grows with accuracy; NaN for values that cannot be compared.
double rank(const std::string& knob, const std::string& value) {
  if (const double number = fineness({knob, value}); std::isfinite(number)) return number;
  const std::vector<std::string>& words = find_knob(knob).values;
  const auto word = std::find(words.begin(), words.end(), value);
  return word == words.end() ? nan : static_cast<double>(word - words.begin());
}

/// Whether `a` is at least as fine as `b` in every knob.
bool is_as_fine(const Settings& a, const Settings& b, const std::map<std::string, std::string>& scene_values) {
  const auto value = [&](const Settings& settings, const std::string& knob) {
    for (const Setting& s : settings)
      if (s.knob == knob) return s.value;
    return scene_values.count(knob) > 0 ? scene_values.at(knob) : std::string();
  };
  for (const Settings* settings : {&a, &b})
    for (const Setting& s : *settings)
      if (!(rank(s.knob, value(a, s.knob)) >= rank(s.knob, value(b, s.knob)))) return false;
  return true;
}

void find_trusted_errors(Study& study) {
  for (CaseResult& result : study.results) {
    result.trusted_error = result.error;
    for (const CaseResult& other : study.results)
      if (result.what.same_effects && other.what.same_effects && other.is_done() &&
          is_as_fine(other.what.settings, result.what.settings, study.scene_values))
        result.trusted_error = std::max(result.trusted_error, other.error);
  }
}

std::string measure_of(const std::vector<Quantity>& quantities) {
  std::vector<std::string> groups;
  for (const Quantity& q : quantities)
    if (q.is_primary && std::find(groups.begin(), groups.end(), q.group) == groups.end()) groups.push_back(q.group);
  std::string joined;
  for (std::size_t i = 0; i < groups.size(); ++i)
    joined += (i == 0 ? "" : i + 1 == groups.size() ? " and " : ", ") + groups[i];
  return "largest error of " + joined;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return nan;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double CaseResult::seconds() const { return median(wall_seconds); }
double CaseResult::cpu() const { return median(cpu_seconds); }

std::vector<Quantity> with_closed_form(std::vector<Quantity> run, const std::optional<ClosedForm>& closed_form) {
  for (Quantity& q : run)
    if (closed_form && closed_form->values.count(q.name) > 0) q.value = closed_form->values.at(q.name);
  return run;
}

std::map<std::string, double> relative_errors(const std::vector<Quantity>& quantities,
                                              const std::vector<Quantity>& reference) {
  std::map<std::string, double> scale, by_name, errors;
  for (const Quantity& r : reference) {
    scale[r.group] = std::max(scale[r.group], std::abs(r.value));
    by_name[r.name] = r.value;
  }
  for (const Quantity& q : quantities)
    if (by_name.count(q.name) > 0 && scale[q.group] > 0)
      errors[q.name] = std::abs(q.value - by_name[q.name]) / scale[q.group];
  return errors;
}

double primary_error(const std::vector<Quantity>& quantities, const std::map<std::string, double>& errors) {
  double largest = nan;
  for (const Quantity& q : quantities)
    if (q.is_primary && errors.count(q.name) > 0)
      largest = std::isnan(largest) ? errors.at(q.name) : std::max(largest, errors.at(q.name));
  return largest;
}

Study run_study(const micro::Scene& scene, const std::vector<Case>& cases, std::optional<ClosedForm> closed_form,
                const StudyOptions& options) {
  Study study;
  study.scene = scene.name;
  study.title = scene.title;
  study.closed_form = std::move(closed_form);
  study.n_repeats = options.n_repeats;
  study.n_threads = options.n_threads;
  for (const Knob& knob : knobs())
    if (const std::string value = knob.current(scene); !value.empty()) study.scene_values[knob.name] = value;
  for (const Case& c : cases) study.results.emplace_back().what = c;
  const int n = static_cast<int>(cases.size());
  for (int pass = 0; pass < options.n_repeats; ++pass)
    for (int i = 0; i < n; ++i) {
      CaseResult& result = study.results[pass % 2 == 0 ? i : n - 1 - i];
      if (pass > 0 && (!result.is_done() || is_reference(result.what.part))) continue;
      if (options.stop()) return study;
      run_once(scene, options, result);
      options.tell(fmt::format("pass {}, case {} of {}: {}: {}, {:.2f} s", pass + 1, i + 1, n,
                               text(result.what.settings), result.status, result.wall_seconds.back()));
    }
  return study;
}

void compare(Study& study) {
  const CaseResult* reference = find(study, CasePart::reference);
  const CaseResult* looser = find(study, CasePart::looser_reference);
  if (reference == nullptr || looser == nullptr) return;
  const std::vector<Quantity> expected = with_closed_form(reference->quantities, study.closed_form);
  const bool is_closed = study.closed_form && all_primary_known(expected, *study.closed_form);
  study.reference_uncertainty =
      is_closed ? study.closed_form->uncertainty
                : primary_error(looser->quantities, relative_errors(looser->quantities, reference->quantities));
  study.reference = is_closed ? "a closed form: " + study.closed_form->source
                              : fmt::format("the finest settings ({})", text(reference->what.settings));
  study.measure = measure_of(expected);
  for (CaseResult& result : study.results) {
    if (!result.is_done()) continue;
    result.errors = relative_errors(result.quantities, expected);
    result.error = primary_error(result.quantities, result.errors);
  }
  find_trusted_errors(study);
  study.has_reference = std::isfinite(study.reference_uncertainty);
}

Profile profile_of(const Study& study, const micro::Scene& scene, const std::string& command) {
  Profile profile{scene.name,
                  fingerprint(scene.text),
                  TRAME_VERSION,
                  command,
                  study.n_threads,
                  study.measure,
                  study.reference,
                  study.reference_uncertainty,
                  {}};
  for (const CaseResult& r : study.results)
    if (r.is_done() && std::isfinite(r.error))
      profile.runs.push_back({r.what.settings, r.what.same_effects, r.trusted_error, r.error, r.seconds(), r.cpu(),
                              r.peak_memory_bytes, r.errors});
  return profile;
}

}  // namespace trame::workflows
