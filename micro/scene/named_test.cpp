#include "micro/scene/named_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <tuple>

#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

using Names = std::vector<std::string>;

enum class Specimen : std::uint8_t { weave, patch, bundle, yarn, any };

/// Keys of a kind of test besides those of all, and what it is done on.
struct KindOfTest {
  std::string_view name;
  Names needed, allowed;
  Specimen of;
};

const std::array<KindOfTest, 9>& kinds() {  // in the order of NamedTestKind
  static const std::array<KindOfTest, 9> all = {{{"biaxial", {}, {"warp_strain", "weft_strain"}, Specimen::weave},
                                                 {"uniaxial", {"strain"}, {"direction"}, Specimen::weave},
                                                 {"shear", {}, {"strain", "angle"}, Specimen::weave},
                                                 {"bending", {"curvature"}, {"direction", "clamps"}, Specimen::patch},
                                                 {"pull_out", {"yarn", "distance"}, {"end"}, Specimen::patch},
                                                 {"yarn_tension", {"yarn", "strain"}, {}, Specimen::yarn},
                                                 {"yarn_bending", {"yarn", "curvature"}, {"clamps"}, Specimen::bundle},
                                                 {"compaction", {"strain"}, {}, Specimen::any},
                                                 {"indentation", {"radius", "depth"}, {}, Specimen::patch}}};
  return all;
}

const KindOfTest& kind_of(const NamedTest& test) { return kinds()[static_cast<std::size_t>(test.kind)]; }

NameTable yarns_of(const Scene& scene) {
  NameTable names(scene.weave ? yarn_names(*scene.weave) : Names());
  for (const BundleSpec& bundle : scene.bundles) names.add(bundle.name);
  return names;
}

/// Fails for keys that the kind of test does not know, and for those that it lacks.
void check_keys(const SceneValue& table, const KindOfTest& kind) {
  Names own = kind.needed;
  own.insert(own.end(), kind.allowed.begin(), kind.allowed.end());
  for (const std::string& key : kind.needed)
    if (!table.find(key)) table.fail_missing(key, fmt::format("what test \"{}\" needs", kind.name));
  const Names of_all = {"kind", "increments", "cycles"};
  for (const Key<NamedTest>& key : named_test_keys({}))
    if (const auto value = table.find(key.name); value && std::find(own.begin(), own.end(), key.name) == own.end() &&
                                                 std::find(of_all.begin(), of_all.end(), key.name) == of_all.end())
      value->fail(fmt::format("is none of test \"{}\"; it has {}", kind.name, allowed_names(own)));
}

/// Fails where the scene has nothing that such a test is done on.
void check_specimen(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  const Specimen of = kind_of(test).of;
  const SceneValue kind = *table.find("kind");
  if ((of == Specimen::weave || of == Specimen::patch) && !scene.weave) {
    Names others;
    for (const KindOfTest& other : kinds())
      if (other.of != Specimen::weave && other.of != Specimen::patch) others.emplace_back(other.name);
    kind.fail(fmt::format("needs a [weave]; of a bundle there are {}", allowed_names(others)));
  }
  if (of == Specimen::bundle && !bundle_of(test, scene)) table.find("yarn")->fail("must be a [[bundle]]");
  if (!test.yarn || bundle_of(test, scene)) return;
  if ((is_warp(*test.yarn) ? scene.weave->warp : scene.weave->weft).periodic)
    table.find("yarn")->fail("must be a yarn with ends, but the weave is periodic along it");
}

void check_pull_out(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  if (bundle_of(test, scene)) table.find("yarn")->fail("must be a yarn of the weave");
  const Weave& weave = *scene.weave;
  const auto& [own, across] = is_warp(*test.yarn) ? std::tie(weave.warp, weave.weft) : std::tie(weave.weft, weave.warp);
  const double most = weave.yarn_length(own, across);
  if (*test.distance > most)
    table.find("distance")->fail(fmt::format("must be at most {:g} m, the length of the yarn", most));
}

/// Ends that turn by half a turn each meet.
void check_curvature(const SceneValue& table, const NamedTest& test, double length) {
  const double most = 2 * std::numbers::pi / length;
  if (*test.curvature == 0 || std::abs(*test.curvature) > most)
    table.find("curvature")
        ->fail(fmt::format("must be other than 0 and from {:g} to {:g} per m, where {:g} m of yarn close to a ring",
                           -most, most, length));
}

/// Clamps and frames are made for yarns that stand on them.
void check_right_angle(const SceneValue& table, const Weave& weave) {
  if (weave.is_skew()) table.find("kind")->fail("needs a [weave] at right angles, without weave.angle");
}

void check_bending(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  if (scene.weave->is_periodic())
    table.find("kind")->fail("needs a [weave] with ends, which turn; a periodic one has none");
  const Weave& weave = *scene.weave;
  check_right_angle(table, weave);
  check_curvature(table, test,
                  test.along_warp.value_or(true) ? weave.yarn_length(weave.warp, weave.weft)
                                                 : weave.yarn_length(weave.weft, weave.warp));
}

void check_yarn_bending(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  const BundleSpec& bundle = *bundle_of(test, scene);
  if (bundle.points.size() != 2) table.find("yarn")->fail("must be straight, a [[bundle]] with two points");
  check_curvature(table, test, (bundle.points[1] - bundle.points[0]).norm());
}

/// A cell by the strain of its period, a patch by the angle of the frame around it.
void check_shear(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  const bool warp = scene.weave->warp.periodic, weft = scene.weave->weft.periodic;
  if (warp != weft) table.find("kind")->fail("needs a [weave] that is periodic both ways, or neither way");
  const auto expect = [&](const char* own, const char* other, const char* of) {
    if (!table.find(own)) table.fail_missing(own, fmt::format("what test \"shear\" of a {} needs", of));
    if (const auto value = table.find(other)) value->fail(fmt::format("has no effect on a {}, which has {}", of, own));
  };
  if (warp)
    expect("strain", "angle", "periodic cell");
  else
    expect("angle", "strain", "patch");
  if (!warp) check_right_angle(table, *scene.weave);
  if (test.angle == 0) table.find("angle")->fail("must be other than 0");
}

/// Above the middle of the patch a sphere of half a spacing meets a yarn, whatever stands there.
void check_indentation(const SceneValue& table, const NamedTest& test, const Scene& scene) {
  if (scene.weave->is_periodic())
    table.find("kind")->fail("needs a [weave] with ends, which hold it; a periodic one has none");
  const double least = 0.5 * std::max(scene.weave->warp.yarn_spacing, scene.weave->weft.yarn_spacing);
  if (*test.radius < least)
    table.find("radius")->fail(
        fmt::format("must be at least {:g} m, half a yarn spacing, or the sphere falls through the fabric", least));
}

NamedTest read_test_table(const SceneValue& table, const Scene& scene) {
  NamedTest test;
  read_table(table, named_test_keys(yarns_of(scene)), {}, test);
  check_keys(table, kind_of(test));
  check_specimen(table, test, scene);
  switch (test.kind) {
    case NamedTestKind::biaxial:
      if (test.warp_strain.value_or(0) == 0 && test.weft_strain.value_or(0) == 0)
        table.fail("test \"biaxial\" must have a warp_strain or a weft_strain other than 0");
      break;
    case NamedTestKind::shear: check_shear(table, test, scene); break;
    case NamedTestKind::compaction:
      if (!(*test.strain > 0 && *test.strain < 1))
        table.find("strain")->fail(
            "must be greater than 0 and less than 1: the part of the thickness that is pressed out");
      break;
    case NamedTestKind::indentation: check_indentation(table, test, scene); break;
    case NamedTestKind::bending: check_bending(table, test, scene); break;
    case NamedTestKind::yarn_bending: check_yarn_bending(table, test, scene); break;
    case NamedTestKind::pull_out: check_pull_out(table, test, scene); break;
    case NamedTestKind::uniaxial:
    case NamedTestKind::yarn_tension: break;
  }
  return test;
}

}  // namespace

std::string_view name_of(NamedTestKind kind) { return kinds()[static_cast<std::size_t>(kind)].name; }

std::vector<Key<NamedTest>> named_test_keys(const NameTable& yarns) {
  using T = NamedTest;
  NamedValues<NamedTestKind> names;
  for (std::size_t k = 0; k < kinds().size(); ++k) names.emplace_back(kinds()[k].name, static_cast<NamedTestKind>(k));
  const auto strains = quantity(ratio, between(-10, 10));
  constexpr double most_shear = std::numbers::pi / 180 * 80;
  return {
      key<T>("kind", &T::kind, choice(names), "which test; its stage has this name and comes after all others")
          .needed(),
      key<T>("warp_strain", &T::warp_strain, strains, "biaxial: of the patch along the warp").otherwise("default: 0"),
      key<T>("weft_strain", &T::weft_strain, strains, "biaxial: of the patch along the weft").otherwise("default: 0"),
      key<T>("strain", &T::strain, strains,
             "uniaxial: of the patch; shear: of a cell's weft along its warp; yarn_tension: of the yarn's length; "
             "compaction: part of the thickness by which the plates plate/upper and plate/lower close in")
          .otherwise("needed there"),
      key<T>("direction", &T::along_warp, choice<bool>({{"warp", true}, {"weft", false}}),
             "uniaxial: the family that is pulled; the ends of the other are free. bending: the family that is bent")
          .otherwise("default: \"warp\""),
      key<T>("yarn", &T::yarn, existing_name("a yarn", yarns),
             "pull_out, yarn_tension: which; other yarns are held. A bundle, of yarn_bending too, gets the bodies "
             "NAME/start and NAME/end")
          .otherwise("needed there"),
      key<T>("end", &T::end, choice<FiberEnd>({{"start", FiberEnd::start}, {"end", FiberEnd::end}}),
             "pull_out: the end that is drawn; the other one is free along the yarn")
          .otherwise("default: \"end\""),
      key<T>("distance", &T::distance, quantity(length, above(0)), "pull_out: that the end is drawn")
          .otherwise("needed there"),
      key<T>("angle", &T::angle, quantity(angle, between(-most_shear, most_shear)),
             "shear: of a patch in a picture frame; positive: warp turns towards weft")
          .otherwise("needed there"),
      key<T>("curvature", &T::curvature, quantity(per_length, any()),
             "bending, yarn_bending: over the laid out length of the yarns; positive: their ends turn up")
          .otherwise("needed there"),
      key<T>("clamps", &T::clamps, choice<TieKind>({{"sliding", TieKind::sliding}, {"clamped", TieKind::clamped}}),
             "bending, yarn_bending: fibers slide through the clamps, or are held by them and stretch")
          .otherwise("default: \"sliding\""),
      key<T>("radius", &T::radius, quantity(length, above(0)), "indentation: of the sphere, the body indenter")
          .otherwise("needed there"),
      key<T>("depth", &T::depth, quantity(length, above(0)),
             "indentation: that the sphere goes down from where it touches the middle of the patch")
          .otherwise("needed there"),
      key<T>("increments", &T::n_increments, integer(between(1, 100000)), "of a way, there or back"),
      key<T>("cycles", &T::n_cycles, integer(between(0, 1000)), "there and back; 0: there only")};
}

std::optional<NamedTest> read_test(const SceneValue& root, const Scene& scene) {
  const auto table = root.find("test");
  return table ? std::optional(read_test_table(*table, scene)) : std::nullopt;
}

const BundleSpec* bundle_of(const NamedTest& test, const Scene& scene) {
  const auto found = std::find_if(scene.bundles.begin(), scene.bundles.end(),
                                  [&](const auto& bundle) { return bundle.name == test.yarn; });
  return found == scene.bundles.end() ? nullptr : &*found;
}

}  // namespace trame::micro
