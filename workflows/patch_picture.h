#pragma once
/// \file
/// Pictures of a patch: camera, light, scale bar and the PNG file.

#include <filesystem>
#include <string>
#include <vector>

#include "workflows/patch_shapes.h"

namespace trame::workflows {

enum class View : std::uint8_t { perspective, top, cut };

struct PictureOptions {
  View view = View::perspective;
  CutPlane cut;      ///< for View::cut
  int width = 1600;  ///< pixels; the height follows from what is seen
};

/// Where the camera stands and how large the picture gets. Lengths in µm.
struct Frame {
  Vec3 focal_point = Vec3::Zero();
  Vec3 backward = Vec3::UnitZ();  ///< unit, from the focal point to the camera
  Vec3 up = Vec3::UnitY();        ///< unit, normal to `backward`
  double distance = 1;            ///< from the focal point to the camera
  bool parallel = true;           ///< projection
  double pixel = 1;               ///< length that a pixel spans at the focal point
  int width = 0, height = 0;      ///< pixels
};

/// The frame that holds all points with a margin and room for the scale bar below. `backward` and `up` need not be
/// normal to each other.
[[nodiscard]] Frame fit_frame(const std::vector<Vec3>& points, const Vec3& backward, const Vec3& up, bool parallel,
                              int width);

/// Length and text of a scale bar: the longest of 1, 2, 5 × 10ⁿ µm that is not above `longest`, µm.
struct ScaleBar {
  double length = 0;  ///< µm
  std::string text;
};
[[nodiscard]] ScaleBar choose_scale_bar(double longest);

/// Draws the fibers into a PNG file. Needs an X server, see display.h. The scale bar holds at the centre of the patch
/// where the view is a perspective one. Throws InputError for a cut that meets no fiber and a file that cannot be
/// written.
void write_picture(const micro::FiberMesh& mesh, const micro::FiberConfiguration& fibers,
                   const PictureOptions& options, const std::filesystem::path& file);

}  // namespace trame::workflows
