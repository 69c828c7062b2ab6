#include "meso/bands/shear_bands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "meso/bands/band_shape.h"
#include "meso/bands/contrast.h"
#include "micro/core/error.h"

namespace trame::meso {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void check(const ShearBandOptions& options) {
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) throw InputError(fmt::format("shear bands: {} = {}; must be {}", name, value, range));
  };
  require(options.local_scale > 0, "local_scale", options.local_scale, "> 0");
  require(options.background_scale > options.local_scale, "background_scale", options.background_scale,
          "> local_scale");
  require(options.threshold > 0, "threshold", options.threshold, "> 0");
  require(options.min_contrast >= 0, "min_contrast", options.min_contrast, ">= 0");
  require(options.min_area >= 0, "min_area", options.min_area, ">= 0");
  require(options.block > 0, "block", options.block, "> 0");
  require(options.n_shuffles >= 0, "n_shuffles", options.n_shuffles, ">= 0");
  require(options.significance >= 0 && options.significance <= 1, "significance", options.significance, "in 0 ... 1");
}

/// The tetrahedra that a picture shows, and their values.
struct ShownTets {
  Eigen::ArrayXX<Index> slot;  ///< in `values`, of each pixel
  std::vector<double> values = {};

  ShownTets(const YarnCut& cut, const Picture& picture, const Mask& mask) : slot(cut.tet) {
    std::map<Index, Index> slots;
    for (Eigen::Index i = 0; i < slot.size(); ++i) {
      if (!mask(i)) continue;
      const auto [at, is_new] = slots.try_emplace(cut.tet(i), static_cast<Index>(values.size()));
      if (is_new) values.push_back(picture(i));
      slot(i) = at->second;
    }
  }

  [[nodiscard]] Picture picture(const Mask& mask) const {
    Picture result = Picture::Constant(mask.rows(), mask.cols(), nan);
    for (Eigen::Index i = 0; i < mask.size(); ++i)
      if (mask(i)) result(i) = values[slot(i)];
    return result;
  }
};

struct Regions {
  Picture contrast;
  Eigen::ArrayXX<Index> label;     ///< k + 1 in region k
  std::vector<double> mass, area;  ///< largest mass first
};

/// Contrast and regions of any picture on the same mask. Their scale is that of the tetrahedra's values, however large
/// each is on the cut, so that exchanging values does not change it.
class RegionFinder {
 public:
  RegionFinder(const std::vector<double>& values, const Mask& mask, double pixels_per_distance,
               const ShearBandOptions& options)
      : mask_(mask), options_(options), scale_(robust_scale(values)),
        deviation_(std::max(scale_.deviation, options.min_contrast * scale_.rms / options.threshold)),
        pixel_area_(1 / (pixels_per_distance * pixels_per_distance)),
        local_(mask, options.local_scale * pixels_per_distance, SmoothOrder::mean),
        background_(mask, options.background_scale * pixels_per_distance, SmoothOrder::linear) {}

  [[nodiscard]] double deviation() const { return deviation_; }

  [[nodiscard]] Regions operator()(const Picture& values) const {
    Regions regions;
    const Picture moved = mask_.select(values.max(scale_.low).min(scale_.high), 0.0);
    const double unit = deviation_ > 0 ? deviation_ : 1;  // all values 0
    regions.contrast = mask_.select((local_(moved) - background_(moved)) / unit, nan);
    const Index n = label_regions(regions.contrast >= options_.threshold, regions.label);
    regions.mass.assign(n, 0);
    regions.area.assign(n, 0);
    for (Eigen::Index i = 0; i < mask_.size(); ++i) {
      if (regions.label(i) == 0) continue;
      regions.mass[regions.label(i) - 1] += regions.contrast(i) * pixel_area_;
      regions.area[regions.label(i) - 1] += pixel_area_;
    }
    sort(regions);
    return regions;
  }

 private:
  /// By mass; drops those that are too small.
  void sort(Regions& regions) const {
    std::vector<Index> order(regions.mass.size()), label(regions.mass.size() + 1, 0);
    std::iota(order.begin(), order.end(), 0);
    std::erase_if(order, [&](Index k) { return regions.area[k] < options_.min_area; });
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return regions.mass[a] > regions.mass[b]; });
    std::vector<double> mass, area;
    for (const Index k : order) {
      mass.push_back(regions.mass[k]);
      area.push_back(regions.area[k]);
      label[k + 1] = static_cast<Index>(mass.size());
    }
    regions.mass = std::move(mass);
    regions.area = std::move(area);
    regions.label = regions.label.unaryExpr([&](Index k) { return label[k]; }).eval();
  }

  Mask mask_;
  ShearBandOptions options_;
  RobustScale scale_;
  double deviation_, pixel_area_;
  GaussianSmoother local_, background_;
};

/// Values minus a fit to what is around the regions; 0 outside the mask.
Picture excess_over_background(const Picture& values, const Mask& mask, const Mask& in_region,
                               double pixels_per_distance, const ShearBandOptions& options) {
  // The feet of the bands, a mesh cell wide, are no background either.
  Mask around = mask && !dilated(in_region, pixels_per_distance);
  if (!around.any()) around = mask && !in_region;
  const GaussianSmoother fit(around, options.background_scale * pixels_per_distance, SmoothOrder::linear);
  return mask.select(values - fit(values), 0.0);
}

struct Measured {
  Picture values = {}, excess = {};
  Mask mask = {}, in_region = {};
  double pixels_per_distance = 0;
};

/// Pixels of a region and of 1.5 fiber distances around it, without other regions.
std::vector<BandPixel> pixels_around(const YarnCut& cut, const Measured& picture, const Mask& own) {
  const Mask domain = picture.mask && dilated(own, 1.5 * picture.pixels_per_distance) && (own || !picture.in_region);
  std::vector<BandPixel> pixels;
  for (Index c = 0; c < cut.n_columns(); ++c)
    for (Index r = 0; r < cut.n_rows(); ++r)
      if (domain(r, c)) pixels.push_back({cut.centre(r, c) / cut.fiber_distance, picture.excess(r, c)});
  return pixels;
}

/// Everything but mass, area and p-value.
ShearBand measure(const YarnCut& cut, const Measured& picture, const Picture& contrast, const Mask& own) {
  ShearBand band;
  double weight = 0;
  Vec2 first = Vec2::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (Index c = 0; c < cut.n_columns(); ++c)
    for (Index r = 0; r < cut.n_rows(); ++r) {
      if (!own(r, c)) continue;
      const Vec2 x = cut.centre(r, c) / cut.fiber_distance;
      weight += contrast(r, c);
      first += contrast(r, c) * x;
      second += contrast(r, c) * x * x.transpose();
    }
  const Vec2 centre = first / weight;
  band.centre = centre * cut.fiber_distance;
  const std::vector<BandPixel> pixels = pixels_around(cut, picture, own);
  const BandDirection direction = band_direction(pixels);
  band.angle = direction.angle;
  band.straightness = direction.straightness;
  band.thickness = band_thickness(pixels, band.angle);
  const double a = band.angle * std::numbers::pi / 180;
  const Vec2 along(std::cos(a), std::sin(a));
  band.length = std::sqrt(12 * along.dot((second / weight - centre * centre.transpose()) * along));
  band.aspect = band.length / band.thickness;
  const double total = picture.mask.select(picture.values, 0.0).sum(), excess = own.select(picture.excess, 0.0).sum();
  band.mean_excess = excess / double(own.count());
  band.share_of_total = own.select(picture.values, 0.0).sum() / total;
  band.share_of_excess = excess / total;
  return band;
}

/// Largest mass of a region in each shuffled picture.
struct ByChance {
  std::vector<double> tets, blocks;

  [[nodiscard]] static double p_value(const std::vector<double>& masses, double mass) {
    if (masses.empty()) return nan;
    const auto n_larger = std::count_if(masses.begin(), masses.end(), [&](double m) { return m >= mass; });
    return double(1 + n_larger) / double(1 + masses.size());
  }
};

ByChance shuffle(const RegionFinder& find, ShownTets tets, const Measured& picture, const ShearBandOptions& options) {
  const auto side = std::max<Index>(1, static_cast<Index>(std::lround(options.block * picture.pixels_per_distance)));
  std::mt19937 random(options.seed);
  const auto largest = [](const Regions& regions) { return regions.mass.empty() ? 0 : regions.mass.front(); };
  ByChance result;
  for (Index k = 0; k < options.n_shuffles; ++k) {
    std::shuffle(tets.values.begin(), tets.values.end(), random);
    result.tets.push_back(largest(find(tets.picture(picture.mask))));
    result.blocks.push_back(largest(find(shuffled_blocks(picture.values, picture.mask, side, random))));
  }
  return result;
}

}  // namespace

ShearBands find_shear_bands(const YarnCut& cut, const std::vector<double>& values, const ShearBandOptions& options) {
  check(options);
  Measured picture{.values = sample(cut, values), .pixels_per_distance = cut.fiber_distance / cut.pixel};
  picture.mask = picture.values.isFinite();
  ShearBands result{.contrast = Picture::Constant(cut.n_rows(), cut.n_columns(), nan)};
  result.region.setZero(cut.n_rows(), cut.n_columns());
  if (!picture.mask.any()) return result;
  const ShownTets tets(cut, picture.values, picture.mask);
  const RegionFinder find(tets.values, picture.mask, picture.pixels_per_distance, options);
  Regions regions = find(picture.values);
  result.contrast = regions.contrast;
  result.region = regions.label;
  result.deviation = find.deviation();
  if (regions.mass.empty()) return result;
  picture.in_region = regions.label > 0;
  picture.excess =
      excess_over_background(picture.values, picture.mask, picture.in_region, picture.pixels_per_distance, options);
  const ByChance by_chance = shuffle(find, tets, picture, options);
  for (std::size_t k = 0; k < regions.mass.size(); ++k) {
    ShearBand band = measure(cut, picture, regions.contrast, regions.label == static_cast<Index>(k + 1));
    band.mass = regions.mass[k];
    band.area = regions.area[k];
    band.p_value =
        std::max(ByChance::p_value(by_chance.tets, band.mass), ByChance::p_value(by_chance.blocks, band.mass));
    band.significant = band.p_value <= options.significance;
    result.bands.push_back(band);
  }
  return result;
}

}  // namespace trame::meso
