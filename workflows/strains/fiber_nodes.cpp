#include "workflows/strains/fiber_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "meso/strain/strain.h"
#include "micro/core/error.h"
#include "micro/fiber/lagrange.h"
#include "workflows/strains/file_probe.h"

namespace trame::workflows {
namespace {

/// Indices of the fibers, yarn by yarn, in file order within a yarn.
std::vector<std::size_t> fibers_by_yarn(const FiberList& list) {
  std::vector<std::size_t> order(list.n_fibers());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return list.yarn[a] < list.yarn[b]; });
  return order;
}

std::vector<Vec3> slopes(const micro::FiberMesh& mesh, const std::vector<Vec3>& r) {
  std::vector<Vec3> result(r.size());
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    const Index first = mesh.first_node[f], n_nodes = mesh.n_nodes(f), n = std::min(n_nodes, 3);
    for (Index k = 0; k < n_nodes; ++k) {
      const Index begin = first + std::clamp(k - 1, 0, n_nodes - n);
      result[first + k] =
          micro::lagrange_shape(&mesh.arc_length[begin], mesh.arc_length[first + k], n).derivative(r, begin);
    }
  }
  return result;
}

}  // namespace

void check_start(const std::string& where, const std::vector<Index>& start) {
  if (start.size() < 2 || start[0] != 0)
    throw InputError(fmt::format("{}: must begin with 0 and have an entry more than there are fibers", where));
  for (std::size_t f = 0; f + 1 < start.size(); ++f)
    if (start[f + 1] < 0 || start[f + 1] - start[f] < 2)
      throw InputError(fmt::format("{}: fiber {} from node {} to before node {}; a fiber needs at least 2 nodes", where,
                                   f, start[f], start[f + 1]));
}

void check_finite(const std::string& where, const std::vector<Vec3>& positions) {
  for (std::size_t n = 0; n < positions.size(); ++n)
    if (!positions[n].allFinite())
      throw InputError(fmt::format("{} holds values that are not finite, at node {}", where, n));
}

NodeOrder::NodeOrder(const std::string& where, const FiberList& list, const std::vector<Vec3>& reference) {
  mesh_.yarns = list.yarns;
  for (micro::Yarn& yarn : mesh_.yarns) yarn.n_fibers = 0;
  for (const std::size_t f : fibers_by_yarn(list)) {
    micro::Yarn& yarn = mesh_.yarns[list.yarn[f]];
    if (yarn.n_fibers++ == 0) yarn.first_fiber = mesh_.n_fibers();
    mesh_.first_node.push_back(mesh_.first_node.back() + list.start[f + 1] - list.start[f]);
    mesh_.radius.push_back(list.radius[f]);
    mesh_.axial_stiffness.push_back(std::numeric_limits<double>::quiet_NaN());
    mesh_.yarn_of_fiber.push_back(list.yarn[f]);
    double s = 0;
    for (Index n = list.start[f]; n < list.start[f + 1]; ++n) {
      const double step = n == list.start[f] ? 0 : (reference[n] - reference[n - 1]).norm();
      if (n > list.start[f] && !(s + step > s && std::isfinite(step)))
        throw InputError(fmt::format("{}: nodes {} and {} of fiber {} coincide, or are too far apart to tell", where,
                                     n - 1 - list.start[f], n - list.start[f], f));
      s += step;
      mesh_.arc_length.push_back(s);
      source_.push_back(n);
    }
  }
}

micro::FiberConfiguration NodeOrder::configuration(const std::vector<Vec3>& positions,
                                                   const std::vector<Vec3>& tangents) const {
  micro::FiberConfiguration fibers;
  fibers.resize(source_.size());
  for (std::size_t n = 0; n < source_.size(); ++n) fibers.r[n] = positions[source_[n]];
  if (tangents.empty()) fibers.tangent = slopes(mesh_, fibers.r);
  for (std::size_t n = 0; n < source_.size(); ++n) {
    if (!tangents.empty()) fibers.tangent[n] = tangents[source_[n]];
    const Mat3 frame = meso::yarn_frame(fibers.tangent[n]);
    fibers.g1[n] = frame.row(1);
    fibers.g2[n] = frame.row(2);
  }
  return fibers;
}

std::unique_ptr<meso::FiberStates> open_states(const std::vector<std::filesystem::path>& files) {
  const auto is_vtp = [](const std::filesystem::path& file) { return file.extension() == ".vtp"; };
  if (!files.empty() && std::all_of(files.begin(), files.end(), is_vtp)) return open_vtp_nodes(files);
  if (files.size() != 1)
    throw InputError(
        fmt::format("{}: several files must all be .vtp, one for each state", files.empty() ? "" : files[1].string()));
  if (may_hold_hdf5_nodes(files[0])) return open_hdf5_nodes(files[0]);
  return std::make_unique<meso::RunStates>(files[0]);
}

void probe_states(const std::vector<std::filesystem::path>& files,
                  const std::function<std::vector<Index>(const meso::FiberStates&)>& which) {
  constexpr unsigned seconds_a_state = 60;
  const auto read_all = [&] {
    const auto states = open_states(files);
    (void)states->read(0);
    for (const Index i : which(*states)) {
      allow_seconds(seconds_a_state);
      (void)states->read(i);
    }
  };
  probe(files.empty() ? "" : files[0].string(), read_all, seconds_a_state);
}

}  // namespace trame::workflows
