#pragma once
/// \file
/// Tests by name: [test] of a scene, a few keys that stand for a stage with its drives, and for the bodies that it
/// needs.

#include <array>
#include <string_view>

#include "micro/scene/keys.h"
#include "micro/scene/scene.h"

namespace trame::micro {

enum class NamedTestKind : std::uint8_t { biaxial, uniaxial, shear, pull_out, yarn_tension, compaction };

/// Bodies of the planes that a compaction presses with, above and below the fabric.
inline constexpr std::array<std::string_view, 2> plate_names = {"plate/upper", "plate/lower"};

struct NamedTest {
  NamedTestKind kind = NamedTestKind::biaxial;
  std::optional<double> warp_strain, weft_strain, strain;
  std::optional<bool> along_warp;
  std::optional<std::string> yarn;
  std::optional<FiberEnd> end;
  std::optional<double> distance;  ///< m
  Index n_increments = 10;         ///< of a way, there or back
  Index n_cycles = 0;              ///< there and back; 0: there only
};
[[nodiscard]] std::vector<Key<NamedTest>> named_test_keys(const NameTable& yarns);

/// The test of a scene, where it has one. Needs its fibers.
[[nodiscard]] std::optional<NamedTest> read_test(const SceneValue& root, const Scene& scene);
/// Adds the bodies that the test needs and the scene has not. Needs the other bodies.
void add_test_bodies(const SceneValue& root, const NamedTest& test, Scene& scene);
/// Adds the stage of the test after all others; of "uniaxial" one before it, "release", that lets yarn ends go.
void add_test_stage(const SceneValue& root, const NamedTest& test, Scene& scene);

}  // namespace trame::micro
