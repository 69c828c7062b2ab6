#pragma once
/// \file
/// Strains of yarns for ParaView: `yarns.pvd`, a time series of `yarns_NNNN.vtu` with the tetrahedra of all yarns at
/// their positions in the state B. Strains are from A to B, in the yarn frame of A, without unit; NaN where flagged.
///
/// | array | on | meaning |
/// | --- | --- | --- |
/// | E_axial, E_horizontal, E_vertical | cells | normal strains |
/// | E_axial_horizontal, E_axial_vertical, E_horizontal_vertical | cells | shear strains (tensor components) |
/// | E_I, E_II, E_III | cells | principal strains, largest first |
/// | gamma_max | cells | E_I − E_III |
/// | det_F | cells | ratio of volumes |
/// | all of these | points | the same, recovered: see `nodal_strain` |
/// | flagged | cells | 1: inverted in A or B; 2: collapsed; neither has a strain |
/// | flagged | points | 1: no tetrahedron around it has a strain |
/// | shear_zone | cells | number of the zone of high gamma_max, largest first; 0: none |
/// | shear_contrast | cells | gamma_max above its surroundings, in standard deviations |
/// | D2_min | points | non-affine motion D²_min / d², see `non_affine_residual`; NaN with too few neighbours |
/// | yarn, family | cells | index; 0: warp, 1: weft, 2: neither |
/// | copy | cells | (i, j) of the copy, where the weave is periodic: `cell_copies` |
/// | displacement | points | from A to B, m |
/// | load, stage_time, from | field | stage of B, 0…1 within it, increment number of A |
///
/// The time of the series is the increment number of B.

#include <filesystem>
#include <memory>
#include <vector>

#include "meso/comparison.h"
#include "micro/states/cell_copies.h"

namespace trame::meso {

class YarnsVtkWriter {
 public:
  /// Throws InputError where there cannot be so many copies, or `folder` cannot be made. `header` and `meshes` must
  /// outlive the writer.
  YarnsVtkWriter(const micro::SnapshotHeader& header, const std::vector<YarnMesh>& meshes, Index from,
                 const micro::Increment& state_a, const std::filesystem::path& folder,
                 const micro::Copies& copies = micro::one_cell);
  ~YarnsVtkWriter();
  YarnsVtkWriter(const YarnsVtkWriter&) = delete;
  YarnsVtkWriter& operator=(const YarnsVtkWriter&) = delete;

  /// Writes state B = `index` with the fields of each mesh. Throws InputError where it cannot be written.
  void append(Index index, const micro::Increment& state_b, const std::vector<YarnFields>& yarns);
  [[nodiscard]] std::filesystem::path pvd() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trame::meso
