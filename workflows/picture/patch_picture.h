#pragma once
/// \file
/// Pictures of a patch: light, shade, scale bar and the PNG file.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "micro/states/surfaces_vtk.h"
#include "workflows/picture/patch_shapes.h"

namespace trame::workflows {

enum class View : std::uint8_t { perspective, top, cut };

struct PictureOptions {
  View view = View::perspective;
  CutPlane cut;      ///< for View::cut
  int width = 1600;  ///< pixels; the height follows from what is seen
};

/// Draws the fibers into a PNG file, and surfaces that they touch: grey; of planes, which would hide the fibers, only
/// what a cut leaves of them. Needs an X server, see display.h. The scale bar holds at the centre of the patch
/// where the view is a perspective one. Throws InputError for a cut that meets no fiber and a file that cannot be
/// written.
void write_picture(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                   const std::vector<micro::PlacedSurface>& surfaces, const PictureOptions& options,
                   const std::filesystem::path& file);

}  // namespace trame::workflows
