#pragma once
/// \file
/// The curve that a test by name is done for, from a table of all that is driven.

#include <optional>

#include "workflows/curves/branches.h"

namespace trame::workflows {

/// Nothing where the table lacks a column of it.
[[nodiscard]] std::optional<Curve> measured(const micro::TestCurve& test, const CurvesTable& table);

/// Adds motion and reaction of a curve of the table as its last columns: "plates.motion_m", "plates.reaction_Pa".
void add_columns(const Curve& curve, CurvesTable& table);

}  // namespace trame::workflows
