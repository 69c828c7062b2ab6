#pragma once
/// \file
/// Shear bands on a cut through a yarn: regions where a strain stands out from its surroundings.

#include <cstdint>
#include <vector>

#include "meso/bands/strain_cut.h"

namespace trame::meso {

/// Lengths in fiber distances.
struct ShearBandOptions {
  double local_scale = 0.5;  ///< σ of the Gaussian weights of a local value; > 0
  double background_scale =
      3;                   ///< σ of those of its surroundings; > local_scale. Bands wider than this are lost in them
  double threshold = 0.6;  ///< contrast of a region, in deviations of the values; > 0
  double min_contrast = 0.05;  ///< smallest difference that counts, against the rms of the values; ≥ 0
  double min_area = 1;         ///< smallest region, fiber distances²; ≥ 0
  double block = 2;            ///< side of the blocks that are shuffled; > 0
  Index n_shuffles = 199;      ///< of each kind; 0: no p-values
  double significance = 0.01;  ///< largest p-value of a band that is called significant; in 0 … 1
  std::uint32_t seed = 1;
};

/// One connected region of high contrast. Lengths in fiber distances.
struct ShearBand {
  Vec2 centre = Vec2::Zero();  ///< of the contrast, from the plane's origin along its axes, m
  double angle = 0;            ///< to the horizontal, degrees in (−90, 90], see `band_direction`
  double straightness = 0;     ///< 1 for a perfect straight band; the angle of a blob means nothing
  double thickness = 0;        ///< see `band_thickness`; from 1.5 on it is resolved
  double length = 0;           ///< √12 times the deviation of the contrast along the band: that of a uniform bar
  double aspect = 0;           ///< length / thickness
  double area = 0;             ///< fiber distances²
  double mass = 0;             ///< integral of the contrast, in deviations
  double mean_excess = 0;      ///< value minus background, mean over the region; unit of the values
  double share_of_total = 0;   ///< of the cut's integral, what lies in the region: the values themselves …
  double share_of_excess = 0;  ///< … and what they are above the background
  double p_value = 0;          ///< how often chance gives a region of this mass or more; NaN without shuffles
  bool significant = false;
};

struct ShearBands {
  std::vector<ShearBand> bands = {};  ///< largest mass first
  Picture contrast = {};              ///< in deviations; NaN where there is no value
  Eigen::ArrayXX<Index> region = {};  ///< k + 1 in bands[k], 0 elsewhere
  double deviation = 0;               ///< unit of the contrast; unit of the values
};

/// Finds bands of high values (of |E_ij| or −E_ij where the sign matters) on a cut.
///
/// Contrast is the difference of a local Gaussian mean and a Gaussian linear fit of the surroundings, so that a
/// gradient over the section is no contrast, over the deviation of the values of the tetrahedra (winsorized at 1 %). A
/// region is what is connected above the threshold. Shape and shares are those of the excess over a background that is
/// fitted again without the regions. A thickness above `background_scale` belongs to a crest of a smooth field. Bands
/// that cross are one region, of low straightness.
///
/// Significance: the statistic is the mass of the cut's largest region, so that a cut counts once, however many regions
/// it has. It is taken of `n_shuffles` pictures in which the tetrahedra have exchanged their values at random (exact
/// where these are independent), and of as many that are put together from blocks from random places (tetrahedra
/// around a fiber share its displacement). p = (1 + number with at least the region's mass) / (1 + n_shuffles), the
/// larger of the two. False alarms at a level of 0.01, in 200 cuts of 40 fibers and 80 of 240: 1 % with independent
/// values, 2 to 6 % for fibers each displaced at random.
///
/// Resolution, measured on lattices of 12 × 20 fibers: for bands of 2 and 3 fiber distances, angles are right to 2° and
/// thicknesses to 15 %, with noise of up to 30 % of the band's shear in each tetrahedron as well (rms and mean over
/// cases; a single thickness to 20 %). Bands below 1.5 look 1 to 1.5 thick, the size of a mesh cell. Sections of
/// 40 fibers: across 4 layers, bands steeper than 45° are found and their thicknesses right to 15 %, their angles to
/// 5° without noise, to 20° with 30 %; flatter bands are lost. Across 6 layers bands of up to 2 are found at all
/// angles.
///
/// `values`: one per tetrahedron, NaN where there is none. The result depends on nothing else, not on threads. Throws
/// InputError for options out of range.
[[nodiscard]] ShearBands find_shear_bands(const YarnCut& cut, const std::vector<double>& values,
                                          const ShearBandOptions& options = {});

}  // namespace trame::meso
