#pragma once
/// \file
/// Tests by name: [test] of a scene, a few keys that stand for a stage with its drives, and for the bodies that it
/// needs.

#include <string_view>

#include "micro/scene/keys.h"
#include "micro/scene/scene.h"

namespace trame::micro {

enum class NamedTestKind : std::uint8_t {
  biaxial,
  uniaxial,
  shear,
  bending,
  pull_out,
  yarn_tension,
  yarn_bending,
  compaction,
  indentation
};
[[nodiscard]] std::string_view name_of(NamedTestKind kind);

struct NamedTest {
  NamedTestKind kind = NamedTestKind::biaxial;
  std::optional<double> warp_strain, weft_strain, strain;
  std::optional<bool> along_warp;
  std::optional<std::string> yarn;
  std::optional<FiberEnd> end;
  std::optional<double> distance;       ///< m
  std::optional<double> curvature;      ///< 1/m
  std::optional<double> angle;          ///< rad
  std::optional<double> radius, depth;  ///< m
  std::optional<TieKind> clamps;
  Index n_increments = 10;  ///< of a way, there or back
  Index n_cycles = 0;       ///< there and back; 0: there only
};
[[nodiscard]] std::vector<Key<NamedTest>> named_test_keys(const NameTable& yarns);

/// The test of a scene, where it has one. Needs its fibers.
[[nodiscard]] std::optional<NamedTest> read_test(const SceneValue& root, const Scene& scene);

/// The bundle that a test names, where it names one; yarns of a weave are none.
[[nodiscard]] const BundleSpec* bundle_of(const NamedTest& test, const Scene& scene);

}  // namespace trame::micro
