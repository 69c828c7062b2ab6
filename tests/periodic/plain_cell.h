#pragma once
/// \file
/// A plain weave as a cell, of yarns of a few fibers.

#include <fmt/format.h>

#include <string>

#include "micro/scene/scene.h"

namespace trame::micro::test {

struct CellText {
  Index warps = 2, wefts = 2, fibers = 3;
  std::string periodic = "true", pattern = "pattern = \"plain\"";
  std::string of_warp = {};  ///< more keys
  std::string more = {};     ///< more tables
};

inline std::string plain_cell(const CellText& cell = {}) {
  const auto yarns = [&](Index n, const std::string& more) {
    return fmt::format("fiber_type = \"f\"\nyarns = {}\nfibers = {}\nyarn_spacing = \"130 um\"\n{}\n", n, cell.fibers,
                       more);
  };
  return fmt::format(R"([material.m]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.39
[fiber_type.f]
material = "m"
diameter = "20 um"
[weave]
{}
periodic = {}
[weave.warp]
{}[weave.weft]
{}[contact]
friction_coefficient = 0.2
{}
)",
                     cell.pattern, cell.periodic, yarns(cell.warps, cell.of_warp), yarns(cell.wefts, ""), cell.more);
}

}  // namespace trame::micro::test
