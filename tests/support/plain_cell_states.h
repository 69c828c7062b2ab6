#pragma once
/// \file
/// States of a periodic plain weave of single fibers, without a run, for tests of what draws and writes copies of it.

#include <cmath>
#include <string>

#include "micro/states/cell_copies.h"

namespace trame::micro::test {

/// Two warp fibers that come back by `warp`, two weft fibers that come back by `weft`, about the origin; where a
/// period is missing, fibers have ends there as far apart as in the square cell.
struct PlainCell {
  Periods periods = {Vec3(400e-6, 0, 0), Vec3(0, 400e-6, 0)};
  double radius = 20e-6, amplitude = 25e-6;  ///< of the waves, m
  Index n_elements = 8;

  [[nodiscard]] Vec3 vector(int p) const { return periods[p] ? *periods[p] : Vec3(400e-6 * Vec3::Unit(p)); }

  [[nodiscard]] SnapshotHeader header() const {
    SnapshotHeader header;
    for (int f = 0; f < 4; ++f) {
      const bool is_warp = f < 2;
      header.mesh.yarns.push_back({(is_warp ? "warp/" : "weft/") + std::to_string(f % 2 + 1),
                                   is_warp ? YarnFamily::warp : YarnFamily::weft, f, 1});
      header.mesh.first_node.push_back(header.mesh.first_node.back() + 2 * n_elements + 1);
      header.mesh.radius.push_back(radius);
      header.mesh.axial_stiffness.push_back(1.0);
      header.mesh.yarn_of_fiber.push_back(f);
      for (Index n = 0; n <= 2 * n_elements; ++n) header.mesh.arc_length.push_back(400e-6 * n / (2 * n_elements));
    }
    if (periods[0]) header.body_names.emplace_back("cell/warp");
    if (periods[1]) header.body_names.emplace_back("cell/weft");
    return header;
  }

  [[nodiscard]] Increment state() const {
    Increment increment;
    increment.stage = "load";
    for (int f = 0; f < 4; ++f) {
      const int along = f / 2, across = 1 - along;
      const double turn = M_PI * (f % 2 + along);
      for (Index n = 0; n <= 2 * n_elements; ++n) {
        const double t = double(n) / (2 * n_elements), slope = -2 * M_PI * amplitude * std::sin(2 * M_PI * t + turn);
        increment.fibers.r.push_back((t - 0.5) * vector(along) + (0.5 * (f % 2) - 0.25) * vector(across) +
                                     amplitude * std::cos(2 * M_PI * t + turn) * Vec3::UnitZ());
        increment.fibers.tangent.push_back((vector(along) + slope * Vec3::UnitZ()) / 400e-6);
        increment.fibers.g1.emplace_back(Vec3::Unit(across));
        increment.fibers.g2.emplace_back(Vec3::UnitZ());
      }
    }
    for (const auto& period : periods)
      if (period) increment.bodies.position.push_back(*period);
    const std::size_t n_bodies = increment.bodies.position.size();
    increment.bodies.rotation.assign(n_bodies, Mat3::Identity());
    for (auto* vectors :
         {&increment.bodies.force, &increment.bodies.moment, &increment.bodies.motion, &increment.bodies.turn})
      vectors->assign(n_bodies, Vec3::Zero());
    return increment;
  }
};

/// One period is not normal to the other.
inline PlainCell sheared_cell() { return {.periods = {Vec3(420e-6, 0, 0), Vec3(130e-6, 390e-6, 0)}}; }
/// Periodic along the warp alone.
inline PlainCell strip() { return {.periods = {Vec3(400e-6, 0, 0), std::nullopt}}; }

}  // namespace trame::micro::test
