#pragma once
/// \file
/// What a test by name becomes: bodies, stages, and the curve that it is done for.

#include "micro/scene/named_test.h"

namespace trame::micro {

/// Adds the bodies that the test needs and the scene has not. Needs the other bodies.
void add_test_bodies(const SceneValue& root, const NamedTest& test, Scene& scene);
/// Adds the stage of the test after all others, where yarn ends are let go one before it, "release"; and its curve.
void add_test_stage(const SceneValue& root, const NamedTest& test, Scene& scene);

}  // namespace trame::micro
