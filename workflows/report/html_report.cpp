#include "workflows/report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "meso/analyse.h"
#include "micro/core/error.h"
#include "micro/io/whole_file.h"
#include "workflows/report/body_loads.h"
#include "workflows/report/html.h"
#include "workflows/report/report_pictures.h"
#include "workflows/report/report_plots.h"
#include "workflows/report/run_facts.h"
#include "workflows/report/scene_settings.h"
#include "workflows/report/section_pages.h"
#include "workflows/report/yarn_tables.h"

namespace trame::workflows {

namespace {

std::vector<Index> detailed_yarns(const ReportInput& input) {
  const std::vector<micro::Yarn>& yarns = input.states.header().mesh.yarns;
  // A fiber or two have no section that tells anything.
  const auto is_bundle = [&](Index y) { return yarns[y].n_fibers >= 3; };
  std::vector<Index> chosen;
  if (!input.yarns.empty()) {
    const std::vector<Index> named = meso::choose_yarns(yarns, input.yarns);
    std::copy_if(named.begin(), named.end(), std::back_inserter(chosen), is_bundle);
    return chosen;
  }
  for (const auto family : {micro::YarnFamily::warp, micro::YarnFamily::weft, micro::YarnFamily::free}) {
    std::vector<Index> own;
    for (Index y = 0; y < static_cast<Index>(yarns.size()); ++y)
      if (yarns[y].family == family && is_bundle(y)) own.push_back(y);
    if (!own.empty()) chosen.push_back(own[own.size() / 2]);
  }
  return chosen;
}

void check_states(const ReportInput& input) {
  if (input.states.header().mesh.yarns.empty()) throw InputError(input.states.name() + ": holds no yarn");
  if (input.pairs.empty()) throw InputError("report: there is no pair of states to compare");
  const Index n = input.states.n_increments();
  for (const StatePair& pair : input.pairs)
    for (const auto& [name, index] : {std::pair{"A", pair.from}, std::pair{"B", pair.to}})
      if (index < 0 || index >= n)
        throw InputError(fmt::format("report of state {} = {}: allowed are 0 … {}", name, index, n - 1));
}

/// A part of the page: its title in the list of contents and above its content.
struct Chapter {
  std::string title, content;
};

std::string header_html(const micro::SnapshotHeader& header) {
  const std::string origin = header.version.empty() ? "fiber nodes from elsewhere"
                                                    : fmt::format("scene “{}”, computed with Trame {}",
                                                                  escaped(header.scene_name), escaped(header.version));
  return fmt::format("<h1>{}</h1>\n<p class=\"subtitle\">{}: {} yarn{}, {} fiber{}, {} nodes</p>\n",
                     escaped(scene_title(header)), origin, header.mesh.yarns.size(),
                     header.mesh.yarns.size() == 1 ? "" : "s", header.mesh.n_fibers(),
                     header.mesh.n_fibers() == 1 ? "" : "s", header.mesh.n_nodes());
}

std::string patch_words(const micro::FiberMesh& mesh) {
  if (!has_weave(mesh)) return "Neighbouring yarns have different shades; what lies behind a cut is paler.";
  return "Warp yarns are blue, weft yarns orange; what lies behind a cut is paler. In the reference state the yarns "
         "lie "
         "flat, in one plane, and pass through each other.";
}

Chapter patch_chapter(const PatchPictures& patch, const micro::FiberMesh& mesh) {
  const std::string what = has_weave(mesh) ? "patch" : "fibers", title = "The " + what;
  std::string content;
  for (const ReportPicture& picture : patch.pictures)
    content +=
        figure(inline_image(picture.png, "image/png", "the " + what), picture.caption, picture.wide ? "wide" : "");
  if (content.empty())
    return {title, note(fmt::format("There are no pictures of the {}: {}.", what, escaped(patch.missing)))};
  return {title, "<div class=\"pictures-grid\">" + content + "</div>\n" + paragraph(patch_words(mesh))};
}

/// What a run wrote beside its states.
struct RunFiles {
  RunSummary summary;
  std::vector<CurveRow> curves;
};

RunFiles run_files(const ReportInput& input) {
  return {input.summary.empty() ? RunSummary{} : read_run_summary(input.summary),
          input.curves.empty() ? std::vector<CurveRow>{} : read_curves(input.curves)};
}

Chapter run_chapter(const RunSummary& summary, const ReportData& last) {
  return {"The run", fmt::format("<h3>Certificates, {}</h3>\n", state_name(last.pair.to, last.b)) +
                         certificates_html(last.header, last.b, summary) + work_html(summary) + timing_html(summary) +
                         settings_html(last.header)};
}

std::string strain_words(const ReportData& data) {
  return paragraph(fmt::format(
      "State A is increment {}, state B increment {}. Strains are Green-Lagrange strains of the yarns as continua, in "
      "the axes of the yarn in A: <i>axial</i> along it, <i>vertical</i> along the global z made normal to it, through "
      "the thickness of a flat fabric, <i>horizontal</i> across. γ<sub>max</sub> is the difference between the largest "
      "and the smallest principal strain.",
      data.pair.from, data.pair.to));
}

Chapter strain_chapter(const ReportData& data) {
  const std::string title =
      fmt::format("Strain from A, {}, to B, {}", state_name(data.pair.from, data.a), state_name(data.pair.to, data.b));
  const auto has_field = [](const YarnField& yarn) { return yarn.field.has_value(); };
  if (std::none_of(data.fields.begin(), data.fields.end(), has_field))
    return {title, note("No yarn here is a continuum: one or two fibers, or one layer of them, enclose no volume. What "
                        "there is to say of strain is how much longer the fibers have become.") +
                       fibers_html(data)};
  const std::string maps =
      data.details.empty() ? "" : strain_maps_html(data) + "<h3>Shear bands</h3>\n" + bands_html(data);
  return {title, strain_words(data) + "<h3>Yarn by yarn</h3>\n" + yarns_html(data) + maps + "<h3>Distributions</h3>\n" +
                     histogram_figure(data) + "<h3>May the yarns be taken as continua?</h3>\n" + validity_html(data)};
}

std::vector<Chapter> chapters(const RunFiles& files, const std::vector<ReportData>& data, const PatchPictures& patch,
                              const std::string& bodies) {
  const ReportData& last = data.back();
  std::vector<Chapter> result = {patch_chapter(patch, last.header.mesh)};
  if (!last.header.version.empty()) result.push_back(run_chapter(files.summary, last));
  if (!files.curves.empty()) result.push_back({"Force and strain of the sides", curves_figure(files.curves)});
  if (!bodies.empty()) result.push_back({"Forces on bodies and their motions", bodies});
  if (!last.details.empty()) result.push_back({"Sections of yarns", sections_html(last)});
  for (const ReportData& pair : data) result.push_back(strain_chapter(pair));
  return result;
}

std::string page_html(const micro::SnapshotHeader& header, const RunSummary& summary,
                      const std::vector<Chapter>& chapters) {
  std::string contents, body;
  for (std::size_t i = 0; i < chapters.size(); ++i) {
    contents += fmt::format("<li><a href=\"#part-{}\">{}</a></li>\n", i + 1, chapters[i].title);
    body += section(fmt::format("part-{}", i + 1), chapters[i].title, chapters[i].content);
  }
  return page(scene_title(header),
              header_html(header) + warnings_html(summary) + "<nav><ol>\n" + contents + "</ol></nav>\n" + body);
}

}  // namespace

std::string write_report(const ReportInput& input) {
  check_states(input);
  const RunFiles files = run_files(input);
  const std::vector<ReportData> data = report_data(input.states, input.pairs, detailed_yarns(input));
  const ReportData& last = data.back();
  PatchPictures patch{{}, "they were not asked for"};
  if (input.draw_patch) patch = patch_pictures(input.states, last.pair.to, state_name(last.pair.to, last.b));
  // A weave has sides, whose forces are the curves.
  const std::string bodies = has_weave(last.header.mesh) ? "" : bodies_html(input.states, last.pair.to);
  micro::write_whole_file(input.file,
                          page_html(input.states.header(), files.summary, chapters(files, data, patch, bodies)));
  return patch.missing.empty() || !input.draw_patch ? "" : "no pictures of the patch: " + patch.missing;
}

std::vector<StatePair> pairs_of_run(const meso::FiberStates& states) {
  const Index last = states.n_increments() - 1;
  const std::string stage = states.read(last).stage;
  Index middle = last;
  while (middle > 0 && states.read(middle).stage == stage) --middle;
  if (middle == 0) return {{0, last}};
  return {{0, middle}, {middle, last}};
}

}  // namespace trame::workflows
