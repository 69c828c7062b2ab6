#pragma once
/// \file
/// What a textile laboratory measures of a fabric, of one state of a weave: sett, crimp, cover, thickness, mass per
/// area. Definitions and their sources: README.md, *Fabric facts*.

#include <optional>
#include <vector>

#include "micro/fiber/fiber_mesh.h"
#include "micro/states/snapshot.h"

namespace trame::meso {

/// NaN where there is no value.
struct MeanDeviation {
  double mean = 0, deviation = 0;
};

/// Of the warp, or of the weft. A yarn counts from its first crossing to its last; what hangs over does not.
struct SystemFacts {
  Index n_yarns = 0;
  double spacing = 0;         ///< of neighbouring yarns of a layer, normal to them, m; the sett is 1/spacing
  double linear_density = 0;  ///< mass per length of a yarn's centre line, mean of the yarns, kg/m
  MeanDeviation crimp;  ///< length of the centre line over its straight length in the plan, less 1; over the yarns
  double take_up = 0;   ///< 1 − straight length over that of the centre line, mean of the yarns
  MeanDeviation width, height;  ///< extents of sections, over the stations of all yarns, m
  double cover = 0;             ///< width/spacing, at most 1
  double areal_density = 0;     ///< mass of these yarns per area of fabric, kg/m²
};

/// Areas are numbers of yarns times spacings. NaN where it is not known: masses without the densities of all materials.
struct FabricFacts {
  SystemFacts warp, weft;
  double thickness = 0;          ///< between the means of the highest and of the lowest crowns, m
  double outline_thickness = 0;  ///< from the lowest to the highest point of any fiber, free edges included, m
  double cover_factor = 0;       ///< c₁ + c₂ − c₁ c₂ of the covers of both systems
  double projected_cover = 0;    ///< share of the area between the outermost yarns over or under which there is a fiber
  double areal_density = 0;      ///< kg/m²
  double volume_fraction = 0;    ///< fibers' volume over area times `thickness`
};

/// `density`: of each fiber, kg/m³, NaN where it is not known; `weft_layers`: weft yarns above each other. Nothing
/// unless there are two yarns or more of the warp and of the weft, and each of the one crosses each of the other.
[[nodiscard]] std::optional<FabricFacts> fabric_facts(const micro::FiberMesh& mesh,
                                                      const micro::FiberConfiguration& fibers,
                                                      const std::vector<double>& density, Index weft_layers = 1);

/// Layers of weft of the scene that is saved with the states; 1 where that does not tell.
[[nodiscard]] Index weft_layers(const micro::SnapshotHeader& header);

/// Density of the material of each fiber of a weave, from the scene that is saved with the states, kg/m³. NaN where
/// that does not tell.
[[nodiscard]] std::vector<double> fiber_densities(const micro::SnapshotHeader& header);

}  // namespace trame::meso
