#include "workflows/report/report_pictures.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "micro/scene/weave.h"
#include "micro/states/cell_copies.h"
#include "workflows/program/child_process.h"
#include "workflows/program/temporary_folder.h"
#include "workflows/report/html.h"

namespace trame::workflows {

namespace {

namespace fs = std::filesystem;
using Command = std::vector<std::string>;

constexpr int half_page = 540, whole_page = 1040;  // pixels, as the page shows them

/// Views of render_patch, and what captions call them.
constexpr std::array<std::pair<const char*, const char*>, 3> views = {
    {{"perspective", "in perspective"}, {"top", "from above"}, {"cut", "cut open along the middle of "}}};

/// Starts a command with an X server of its own, which keeps its files in `folder`, whatever TMPDIR is; one that hangs
/// is ended.
Command own_server(const fs::path& folder) {
  return {"env", "TMPDIR=" + folder.string(),      "timeout", "300", "xvfb-run", "-a",
          "-s",  "-screen 0 1280x1024x24 -noreset"};
}

Command joined(Command first, const Command& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// The numbers of the bodies that are periods of a cell.
std::vector<std::size_t> periods_among(const std::vector<std::string>& body_names) {
  std::vector<std::size_t> periods;
  for (std::size_t b = 0; b < body_names.size(); ++b)
    if (micro::is_period(body_names[b])) periods.push_back(b);
  return periods;
}

/// The two states alone, fibers and periods, in a file that render_patch reads whatever the states come from.
void write_states(const meso::FiberStates& states, Index state, const fs::path& file) {
  micro::SnapshotHeader header = states.header();
  const std::vector<std::size_t> periods = periods_among(header.body_names);
  header.body_names.clear();
  for (const std::size_t b : periods) header.body_names.push_back(states.header().body_names[b]);
  micro::SnapshotWriter writer(file, header);
  for (const Index i : {Index(0), state}) {
    const micro::Increment all = states.read(i);
    micro::Increment shape;
    shape.stage = all.stage;
    shape.fibers = all.fibers;
    for (const std::size_t b : periods) shape.bodies.position.push_back(all.bodies.position.at(b));
    shape.bodies.rotation.assign(periods.size(), Mat3::Identity());
    for (auto* vectors : {&shape.bodies.force, &shape.bodies.moment, &shape.bodies.motion, &shape.bodies.turn})
      vectors->assign(periods.size(), Vec3::Zero());
    writer.append(shape);
  }
}

Eigen::AlignedBox3d box_of(const micro::FiberMesh& mesh, const micro::Yarn& yarn, const std::vector<Vec3>& r) {
  Eigen::AlignedBox3d box;
  for (Index n = mesh.first_node[yarn.first_fiber]; n < mesh.first_node[yarn.first_fiber + yarn.n_fibers]; ++n)
    box.extend(r[n]);
  return box;
}

/// The yarn to cut along: the middle warp yarn of a weave, else the one that reaches farthest.
const micro::Yarn& yarn_to_cut(const micro::FiberMesh& mesh, const std::vector<Vec3>& r) {
  std::vector<const micro::Yarn*> warp;
  for (const micro::Yarn& yarn : mesh.yarns)
    if (yarn.family == micro::YarnFamily::warp && yarn.n_fibers > 0) warp.push_back(&yarn);
  if (!warp.empty()) return *warp[warp.size() / 2];
  const auto reach = [&](const micro::Yarn& yarn) {
    return yarn.n_fibers > 0 ? box_of(mesh, yarn, r).diagonal().norm() : 0;
  };
  return *std::max_element(mesh.yarns.begin(), mesh.yarns.end(),
                           [&](const auto& p, const auto& q) { return reach(p) < reach(q); });
}

/// --at of the upright plane along a yarn.
std::string plane_along(const micro::FiberMesh& mesh, const micro::Yarn& yarn, const std::vector<Vec3>& r) {
  const Vec3 size = box_of(mesh, yarn, r).sizes();
  const int across = size.x() >= size.y() ? 1 : 0;
  const Index first = mesh.first_node[yarn.first_fiber], end = mesh.first_node[yarn.first_fiber + yarn.n_fibers];
  double sum = 0;
  for (Index n = first; n < end; ++n) sum += r[n][across];
  return fmt::format("{}={:.9g}um", across == 0 ? 'x' : 'y', 1e6 * sum / double(end - first));
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string why_not() {
  if (!fs::exists(program_folder() / "render_patch")) return "the program render_patch is not beside this one";
  if (!run_quietly(".", {"xvfb-run", "--help"}) || !run_quietly(".", {"xauth", "version"}))
    return "no X server answers at DISPLAY, and xvfb-run, which would start one, is not installed (Debian: xvfb, "
           "xauth)";
  return "render_patch failed; xvfb-run -a render_patch states.h5 --out patch.png says why";
}

}  // namespace

PatchPictures patch_pictures(const meso::FiberStates& states, Index state, const std::string& name) {
  const micro::FiberMesh& mesh = states.header().mesh;
  if (!std::all_of(mesh.radius.begin(), mesh.radius.end(), [](double r) { return r > 0; }))
    return {{}, "the radii of the fibers are not known", false};
  const TemporaryFolder folder;
  write_states(states, state, folder.path() / "states.h5");
  const micro::Increment shown = states.read(state);
  const std::vector<Vec3>& r = shown.fibers.r;
  const micro::Yarn& along = yarn_to_cut(mesh, r);
  // All from one process, which starts VTK, and where need be an X server, but once.
  Command render = {(program_folder() / "render_patch").string(), "states.h5", "--at", plane_along(mesh, along, r)};
  PatchPictures result;
  const auto [along_warp, along_weft] = micro::is_periodic(micro::periods_of(states.header(), shown));
  result.of_cell = along_warp || along_weft;
  for (const auto& [view, what] : views)
    for (const auto& [increment, which] : {std::pair<const char*, std::string>{"0", "reference"}, {"1", name}}) {
      if (state == 0 && *increment == '1') continue;
      const bool wide = std::string_view(view) == "cut";
      const std::string file = fmt::format("{}_{}.png", view, increment);
      render = joined(std::move(render),
                      {"--picture", view, increment, std::to_string(wide ? whole_page : half_page), file});
      result.pictures.push_back({file, fmt::format("{}, {}{}", which, what, wide ? escaped(along.name) : ""), wide});
    }
  const char* display = std::getenv("DISPLAY");
  const bool drawn = (display != nullptr && *display != '\0' && run_quietly(folder.path(), render)) ||
                     run_quietly(folder.path(), joined(own_server(folder.path()), render));
  if (!drawn) return {{}, why_not(), false};
  for (ReportPicture& picture : result.pictures) picture.png = bytes_of(folder.path() / picture.png);
  return result;
}

}  // namespace trame::workflows
