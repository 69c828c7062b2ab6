#include "workflows/curves/curves_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "micro/core/whole_file.h"
#include "workflows/program/gnuplot.h"

namespace trame::workflows {

namespace {

constexpr std::array<const char*, 8> colours = {"#3b75af", "#d5813a", "#5a9e6f", "#8a6bb1",
                                                "#b5524d", "#c9a227", "#6b7a8a", "#0f8a8a"};

/// Names come from a file: what is no text must not get into a script.
std::string plot_title(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return gnuplot_string(name) + " noenhanced";
}

std::string data_block(const Curve& curve, const Branch& branch, const std::string& name) {
  const CurveKind& kind = curve.kind();
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t i = branch.first; i <= branch.last; ++i)
    text += fmt::format("{:.9g} {:.9g}\n", kind.motion.factor * curve.points[i].motion,
                        kind.reaction.factor * curve.points[i].reaction);
  return text + "EOD\n";
}

}  // namespace

Axes axes_of(const Curve& curve) {
  const CurveKind& kind = curve.kind();
  return {fmt::format("{} ({})", kind.motion_label, kind.motion.unit),
          fmt::format("{} ({})", kind.reaction_label, kind.reaction.unit)};
}

std::vector<Curve> curves_to_draw(const CurveKind& kind, const std::vector<Curve>& curves, std::size_t most) {
  std::vector<std::pair<double, const Curve*>> found;
  for (const Curve& curve : curves)
    if (&curve.kind() == &kind && !branches_of(curve).empty()) found.emplace_back(largest_work(curve), &curve);
  const bool are_sides = !found.empty() && found.front().second->is_of_sides();
  if (!are_sides)  // those are warp, then weft
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Curve> chosen;
  for (std::size_t i = 0; i < std::min(found.size(), most); ++i) chosen.push_back(*found[i].second);
  return chosen;
}

std::string plot_commands(const std::vector<Curve>& curves) {
  std::string data, plots;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    bool is_named = false;
    const std::vector<Branch> branches = branches_of(curves[c]);
    for (std::size_t b = 0; b < branches.size(); ++b) {
      const std::string name = fmt::format("curve{}_{}", c, b);
      data += data_block(curves[c], branches[b], name);
      plots +=
          fmt::format("{}${} with linespoints pt 7 ps 0.4 lw 2 dt {} lc rgb '{}' {}",
                      plots.empty() ? "" : ", \\\n     ", name, branches[b].kind == Branch::Kind::unloading ? 2 : 1,
                      colours[c % colours.size()], is_named ? "notitle" : "title " + plot_title(curves[c].name));
      is_named = true;
    }
  }
  if (plots.empty()) return {};
  const Axes axes = axes_of(curves.front());
  return fmt::format("{}set xlabel '{}'\nset ylabel '{}'\nset grid\nset key top left Left reverse\nplot {}\n", data,
                     axes.motion, axes.reaction, plots);
}

bool plot_curves(const std::filesystem::path& folder, const std::vector<Curve>& curves, const std::string& title) {
  const auto moves = [](const Curve& curve) { return !branches_of(curve).empty(); };
  const auto first = std::find_if(curves.begin(), curves.end(), moves);
  if (first == curves.end()) return true;
  const auto most = std::max_element(curves.begin(), curves.end(),
                                     [](const Curve& a, const Curve& b) { return largest_work(a) < largest_work(b); });
  const Curve& leads = first->is_of_fabric() ? *first : *most;
  const std::string commands = plot_commands(curves_to_draw(leads.kind(), curves));
  if (commands.empty()) return true;
  micro::write_whole_file(
      folder / "curves.gp",
      fmt::format("# Loading solid, unloading dashed: gnuplot curves.gp\nset encoding utf8\n"
                  "set terminal svg size 800,600 dynamic background rgb 'white'\nset output 'curves.svg'\n"
                  "set title {}\n{}",
                  plot_title(title), commands));
  const bool drawn = run_gnuplot(folder, "curves.gp") && is_whole_svg(folder / "curves.svg");
  if (!drawn) std::filesystem::remove(folder / "curves.svg");
  return drawn;
}

}  // namespace trame::workflows
