#pragma once
/// \file
/// Pictures of a patch: light, shade, scale bar and the PNG file.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "micro/states/cell_copies.h"
#include "micro/states/surfaces_vtk.h"
#include "workflows/picture/patch_shapes.h"

namespace trame::workflows {

enum class View : std::uint8_t { perspective, top, cut };

struct PictureOptions {
  View view = View::perspective;
  CutPlane cut;      ///< for View::cut
  int width = 1600;  ///< pixels; the height follows from what is seen
};

/// What is drawn of a state.
struct Patch {
  micro::FiberMesh mesh;
  micro::FiberConfiguration fibers;
  std::vector<micro::PlacedSurface> surfaces;
  /// Corners of the periodic cell that was simulated, m: see `cell_outline`.
  std::optional<std::array<Vec3, 4>> cell;
};

/// A state with copies of its cell, as many as show how it goes on where `copies` is empty. Throws InputError where
/// there cannot be so many.
[[nodiscard]] Patch patch_of(const micro::SnapshotHeader& header, const micro::Increment& state,
                             const std::optional<micro::Copies>& copies);

/// Draws the fibers into a PNG file, and surfaces that they touch: grey; of planes, which would hide the fibers, only
/// what a cut leaves of them. A thin line around the periodic cell lies over them, in a cut around what the plane meets
/// of the cell. Needs an X server, see display.h. The scale bar holds at the centre of the patch where the view is a
/// perspective one. Throws InputError for a cut that meets no fiber and a file that cannot be written.
void write_picture(const Patch& patch, const PictureOptions& options, const std::filesystem::path& file);

}  // namespace trame::workflows
