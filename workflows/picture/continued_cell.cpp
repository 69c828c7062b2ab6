#include "workflows/picture/continued_cell.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace trame::workflows {
namespace {

using micro::CopyNumber;
using micro::FiberConfiguration;
using micro::FiberMesh;
using micro::Periods;
using micro::YarnFamily;

/// The period that yarns come back by: 0, 1, or -1 for ends.
int own_period(YarnFamily family, const Periods& periods) {
  const int own = family == YarnFamily::warp ? 0 : family == YarnFamily::weft ? 1 : -1;
  return own >= 0 && periods[own] ? own : -1;
}

/// A cell and the copies that it is drawn with.
struct Original {
  const FiberMesh& mesh;
  const FiberConfiguration& fibers;
};

/// Appends `n_periods` periods of a fiber, from the one displaced by `by` on; the last node of each is the first one of
/// the next.
void append_fiber(ContinuedCell& to, const Original& from, Index fiber, Index n_periods, const Vec3& by,
                  const Vec3& period) {
  const Index first = from.mesh.first_node[fiber], last = from.mesh.first_node[fiber + 1] - 1;
  for (Index k = 0; k < n_periods; ++k)
    for (Index n = first + (k > 0 ? 1 : 0); n <= last; ++n) {
      to.fibers.r.push_back(from.fibers.r[n] + by + k * period);
      to.fibers.g1.push_back(from.fibers.g1[n]);
      to.fibers.g2.push_back(from.fibers.g2[n]);
      to.fibers.tangent.push_back(from.fibers.tangent[n]);
      to.mesh.arc_length.push_back(from.mesh.arc_length[n] + k * from.mesh.length(fiber));
    }
  to.mesh.first_node.push_back(static_cast<Index>(to.mesh.arc_length.size()));
  to.mesh.radius.push_back(from.mesh.radius[fiber]);
  to.mesh.axial_stiffness.push_back(from.mesh.axial_stiffness[fiber]);
  to.mesh.yarn_of_fiber.push_back(static_cast<Index>(to.mesh.yarns.size()));
}

/// Mean coordinates, in that basis, of where the fibers of a family start.
Vec3 mean_start(const Original& cell, YarnFamily family, const Mat3& to_basis) {
  Vec3 sum = Vec3::Zero();
  Index n_fibers = 0;
  for (Index f = 0; f < cell.mesh.n_fibers(); ++f)
    if (cell.mesh.yarns[cell.mesh.yarn_of_fiber[f]].family == family) {
      sum += to_basis * cell.fibers.r[cell.mesh.first_node[f]];
      ++n_fibers;
    }
  return sum / std::max(n_fibers, Index(1));
}

/// Lowest and highest coordinate of the fibers along `axis` of that basis, with their radii where it is an edge's.
std::array<double, 2> reach(const Original& cell, int axis, const Mat3& to_basis) {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (Index f = 0; f < cell.mesh.n_fibers(); ++f)
    for (Index n = cell.mesh.first_node[f]; n < cell.mesh.first_node[f + 1]; ++n) {
      const double x = (to_basis * cell.fibers.r[n])[axis];
      low = std::min(low, x - cell.mesh.radius[f]);
      high = std::max(high, x + cell.mesh.radius[f]);
    }
  return {low, high};
}

/// The period vectors, what lies across to one that is missing, and up.
Mat3 basis_of(const Periods& periods) {
  Mat3 basis = Mat3::Identity();
  for (int p = 0; p < 2; ++p)
    if (periods[p]) basis.col(p) = *periods[p];
  if (!periods[0]) basis.col(0) = periods[1]->cross(Vec3::UnitZ()).normalized();
  if (!periods[1]) basis.col(1) = Vec3::UnitZ().cross(*periods[0]).normalized();
  return basis;
}

}  // namespace

ContinuedCell continued_cell(const FiberMesh& mesh, const FiberConfiguration& fibers, const Periods& periods,
                             const micro::Copies& copies) {
  ContinuedCell cell;
  for (const CopyNumber& copy : micro::copy_numbers(copies))
    for (const micro::Yarn& yarn : mesh.yarns) {
      const int own = own_period(yarn.family, periods);
      if (own >= 0 && copy[own] != micro::copy_range(copies[own])[0]) continue;  // goes on from the copy before
      const Vec3 by = micro::displacement_of(copy, periods), period = own >= 0 ? *periods[own] : Vec3(Vec3::Zero());
      const auto first_fiber = static_cast<Index>(cell.mesh.radius.size());
      for (Index f = yarn.first_fiber; f < yarn.first_fiber + yarn.n_fibers; ++f)
        append_fiber(cell, {mesh, fibers}, f, own >= 0 ? copies[own] : 1, by, period);
      cell.mesh.yarns.push_back({yarn.name, yarn.family, first_fiber, yarn.n_fibers});
    }
  return cell;
}

std::optional<std::array<Vec3, 4>> cell_outline(const FiberMesh& mesh, const FiberConfiguration& fibers,
                                                const Periods& periods) {
  if (!periods[0] && !periods[1]) return std::nullopt;
  const Original cell{mesh, fibers};
  const Mat3 basis = basis_of(periods), to_basis = basis.inverse();
  std::array<double, 2> low{}, high{};
  for (int p = 0; p < 2; ++p) {
    const double start = mean_start(cell, p == 0 ? YarnFamily::warp : YarnFamily::weft, to_basis)[p];
    const auto [edge_low, edge_high] = reach(cell, p, to_basis);
    low[p] = periods[p] ? start : edge_low;
    high[p] = periods[p] ? start + 1 : edge_high;
  }
  const auto corner = [&](double u, double v) { return Vec3(basis * Vec3(u, v, 0)); };
  return std::array<Vec3, 4>{corner(low[0], low[1]), corner(high[0], low[1]), corner(high[0], high[1]),
                             corner(low[0], high[1])};
}

}  // namespace trame::workflows
