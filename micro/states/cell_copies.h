#pragma once
/// \file
/// Copies of a periodic cell, side by side: copy (i, j) is the cell displaced by i times its period along the warp and
/// j times the one along the weft. Along a period, n copies are those from −⌊(n − 1)/2⌋ to ⌊n/2⌋: (0, 0) is the cell
/// itself, the first of two, the middle one of three.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "micro/states/snapshot.h"

namespace trame::micro {

/// Period vectors along the warp and along the weft, m; none along a system of yarns with ends.
using Periods = std::array<std::optional<Vec3>, 2>;
/// How many copies there are along each period.
using Copies = std::array<Index, 2>;
/// (i, j) of a copy.
using CopyNumber = std::array<Index, 2>;

constexpr Copies one_cell = {1, 1};

/// The period vectors of a state; none of fibers that do not come back by them.
[[nodiscard]] Periods periods_of(const SnapshotHeader& header, const Increment& increment);
/// Of `periods`, which there are.
[[nodiscard]] std::array<bool, 2> is_periodic(const Periods& periods);

/// "2x3": two copies along the warp, three along the weft. Throws InputError that names the option --copies.
[[nodiscard]] Copies parse_copies(const std::string& text);
/// Throws InputError where there are to be copies along a system that has no period.
void check_copies(const Copies& copies, const std::array<bool, 2>& is_periodic);
/// As many as show how a cell goes on: two by two, or three of a strip; one where nothing is periodic.
[[nodiscard]] Copies copies_to_show(const std::array<bool, 2>& is_periodic);

/// First and last number along a period of which there are n copies.
[[nodiscard]] std::array<Index, 2> copy_range(Index n);
/// Every copy, those along the warp's period first.
[[nodiscard]] std::vector<CopyNumber> copy_numbers(const Copies& copies);
/// By how much a copy is displaced, m.
[[nodiscard]] Vec3 displacement_of(const CopyNumber& copy, const Periods& periods);

}  // namespace trame::micro
