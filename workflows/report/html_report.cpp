#include "workflows/report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "micro/core/error.h"
#include "micro/core/whole_file.h"
#include "workflows/report/body_loads.h"
#include "workflows/report/curve_chapters.h"
#include "workflows/report/fabric_table.h"
#include "workflows/report/html.h"
#include "workflows/report/report_pictures.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/run_facts.h"
#include "workflows/report/scene_settings.h"
#include "workflows/report/section_pages.h"
#include "workflows/report/yarn_tables.h"

namespace trame::workflows {

namespace {

void check(const ReportInput& input) {
  if (input.states.header().mesh.yarns.empty()) throw InputError(input.states.name() + ": holds no yarn");
  if (input.comparisons.empty()) throw InputError("report: there is no pair of states to compare");
}

/// A part of the page: its title in the list of contents and above its content.
struct Chapter {
  std::string title, content;
};

std::string size_text(const micro::FiberMesh& mesh) {
  const auto count = [](auto n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); };
  return fmt::format("{}, {}, {} nodes", count(mesh.yarns.size(), "yarn"), count(mesh.n_fibers(), "fiber"),
                     mesh.n_nodes());
}

std::string origin_text(const micro::SnapshotHeader& header) {
  if (header.version.empty()) return "fiber nodes from elsewhere";
  return fmt::format("scene “{}”, computed with Trame {}", header.scene_name, header.version);
}

Chapter patch_chapter(const PatchPictures& patch, const micro::FiberMesh& mesh) {
  const std::string what = has_weave(mesh) ? "patch" : "fibers";
  std::string pictures;
  for (const ReportPicture& picture : patch.pictures)
    pictures +=
        figure(inline_image(picture.png, "image/png", "the " + what), picture.caption, picture.wide ? "wide" : "");
  return {"The " + what, filled("patch", {{"missing", patch.pictures.empty()},
                                          {"what", what},
                                          {"why", patch.missing},
                                          {"pictures", pictures},
                                          {"cell", patch.of_cell},
                                          {"weave", has_weave(mesh)}})};
}

/// Of every increment where the run left them, else of the saved ones.
std::string curves_content(const ReportInput& input, const ReportData& last) {
  const CurvesTable table = input.curves.empty() ? saved_curves(input.states, last.scene, last.comparison.pair.to)
                                                 : read_curves(input.curves);
  return curves_html(curves_of(table, last.scene), has_weave(last.header.mesh), input.curves.empty());
}

Chapter run_chapter(const RunSummary& summary, const ReportData& last) {
  const std::string certificates = certificates_html(last.header.mesh, last.scene, last.comparison.b, summary);
  Fields fields = {
      {"b", last.name_b()}, {"certificates", certificates}, {"settings", settings_html(last.header, last.scene)}};
  if (const std::string work = work_table(summary); !work.empty()) fields.emplace_back("work", work);
  if (const std::string timing = timing_figure(summary); !timing.empty()) fields.emplace_back("timing", timing);
  return {"The run", filled("run", fields)};
}

Chapter strain_chapter(const ReportData& data) {
  const meso::Comparison& comparison = data.comparison;
  const std::string title = fmt::format("Strain from A, {}, to B, {}", data.name_a(), data.name_b());
  const bool no_mesh = std::none_of(comparison.yarns.begin(), comparison.yarns.end(),
                                    [](const meso::YarnComparison& yarn) { return yarn.on_mesh().has_mesh(); });
  if (no_mesh) return {title, filled("strain", {{"no_mesh", true}, {"fibers", fibers_table(data)}})};
  Fields fields = {{"no_mesh", false},
                   {"from", std::to_string(comparison.pair.from)},
                   {"to", std::to_string(comparison.pair.to)},
                   {"mesh", std::string(text(comparison.yarns.front().on_mesh().kind))},
                   {"yarns", yarns_table(data)},
                   {"histogram", histogram_figure(data)},
                   {"validity", validity_table(data)}};
  if (!data.details.empty()) {
    fields.emplace_back("maps", strain_maps_html(data));
    fields.emplace_back("bands", bands_html(data));
  }
  return {title, filled("strain", fields)};
}

std::vector<Chapter> chapters(const RunSummary& summary, const std::vector<ReportData>& data,
                              const PatchPictures& patch, const std::string& curves, const std::string& bodies) {
  const ReportData& last = data.back();
  std::vector<Chapter> result = {patch_chapter(patch, last.header.mesh)};
  if (!last.header.version.empty()) result.push_back(run_chapter(summary, last));
  if (!curves.empty()) result.push_back({"Curves of what is driven", curves});
  if (!bodies.empty()) result.push_back({"Bodies", bodies});
  if (!last.details.empty()) result.push_back({"Sections of yarns", sections_html(last)});
  for (const ReportData& pair : data) result.push_back(strain_chapter(pair));
  return result;
}

std::string page_html(const ReportData& last, const RunSummary& summary, const std::vector<Chapter>& chapters) {
  const micro::SnapshotHeader& header = last.header;
  std::vector<Fields> parts;
  for (std::size_t i = 0; i < chapters.size(); ++i)
    parts.push_back(
        {{"number", std::to_string(i + 1)}, {"title", chapters[i].title}, {"content", chapters[i].content}});
  Fields fields = {
      {"title", scene_title(header, last.scene)}, {"style", std::string(style())},      {"origin", origin_text(header)},
      {"size", size_text(header.mesh)},           {"warnings", warnings_html(summary)}, {"chapters", parts}};
  if (const auto& fabric = last.comparison.fabric) {
    fields.emplace_back("fabric", fabric_html(*fabric));
    fields.emplace_back("b", last.name_b());
  }
  return filled("page", fields);
}

}  // namespace

std::string write_report(const ReportInput& input) {
  check(input);
  RunSummary summary = input.summary.empty() ? RunSummary{} : read_run_summary(input.summary);
  const micro::SnapshotHeader& header = input.states.header();
  const std::optional<micro::Scene> scene = scene_of(header);
  const std::vector<Index> detailed = detailed_yarns(header.mesh.yarns, input.yarns);
  std::vector<ReportData> data;
  for (const meso::Comparison* comparison : input.comparisons)
    data.push_back(report_data(header, scene, *comparison, detailed));
  const ReportData& last = data.back();
  PatchPictures patch{{}, "they were not asked for", false};
  if (input.draw_patch) patch = patch_pictures(input.states, last.comparison.pair.to, last.name_b());
  const std::string unfinished = what_is_missing(scene, input.states.read(input.states.n_increments() - 1));
  if (!unfinished.empty()) summary.warnings.insert(summary.warnings.begin(), unfinished);
  // The many bodies of a weave say nothing that its curves do not.
  const std::string bodies = has_weave(header.mesh) ? "" : bodies_html(input.states, last.comparison.pair.to),
                    curves = curves_content(input, last);
  micro::write_whole_file(input.file, page_html(last, summary, chapters(summary, data, patch, curves, bodies)));
  return patch.missing.empty() || !input.draw_patch ? "" : "no pictures of the patch: " + patch.missing;
}

}  // namespace trame::workflows
