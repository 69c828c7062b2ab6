// Yarns as people describe them: linear densities, setts, twist, kinds in an order, lay; what overlaps or cannot be.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "micro/core/error.h"
#include "micro/scene/scene.h"
#include "micro/weave/flat_start.h"

namespace trame::micro {
namespace {

const std::string head = R"([material.pa66]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.39
density = "1.14 g/cm3"
[fiber_type.filament]
material = "pa66"
linear_density = "3.25 dtex"
[fiber_type.thick]
material = "pa66"
diameter = "40 um"
[yarn.A]
fiber_type = "filament"
linear_density = "78 dtex"
layers = 3
[yarn.B]
fiber_type = "thick"
fibers = 3
twist = "800 per m"
twist_direction = "S"
[yarn.C]
fiber_type = "filament"
fibers = 12
lay = "random"
volume_fraction = 0.55
[weave]
pattern = "plain"
)";
const std::string warp = R"([weave.warp]
yarns = 5
order = "A A B"
sett = "40 per cm"
margin = "200 um"
elements = 20
)";
const std::string weft = R"([weave.weft]
yarns = 3
sett = "50 per cm"
fiber_type = "filament"
fibers = 7
)";

Scene scene() { return parse_scene(head + warp + weft, "a.toml"); }

TEST(Yarns, LinearDensitiesMakeDiametersAndNumbersOfFibers) {
  const Scene s = scene();
  EXPECT_NEAR(2 * s.fiber_types[0].radius, std::sqrt(4 * 3.25e-7 / 1140 / std::numbers::pi), 1e-12);
  EXPECT_EQ(s.weave->warp.kind_of(0).n_fibers, 24);
}

TEST(Yarns, ComeInTheirOrder) {
  const YarnSystem yarns = scene().weave->warp;
  EXPECT_EQ(yarns.kinds.size(), 2u);
  EXPECT_EQ(yarns.order, (std::vector<Index>{0, 0, 1}));
  EXPECT_EQ(yarns.n_fibers(), 24 + 24 + 3 + 24 + 24);
  const Assembly assembly = assemble_scene(scene());
  for (const Index yarn : {0, 1, 3, 4}) EXPECT_EQ(assembly.mesh.yarns[yarn].n_fibers, 24);
  EXPECT_EQ(assembly.mesh.yarns[2].n_fibers, 3);
  EXPECT_EQ(assembly.type_of_fiber[assembly.mesh.yarns[2].first_fiber], 1);
}

TEST(Yarns, SettMarginAndElementsAreChosen) {
  const Weave weave = *scene().weave;
  EXPECT_DOUBLE_EQ(weave.warp.yarn_spacing, 250e-6);
  EXPECT_DOUBLE_EQ(weave.weft.yarn_spacing, 200e-6);
  EXPECT_EQ(weave.warp.margin, 200e-6);
  EXPECT_EQ(weave.weft.margin, weave.warp.yarn_spacing);
  // 4 · 250 um + 2 · 250 um at 2.5 · 19.05 um.
  EXPECT_EQ(weave.weft.n_elements, 32);
}

/// How far the last fiber of a yarn turns about the yarn's axis per length, seen against its direction.
double turns(const Assembly& assembly, Index yarn, const Vec3& along) {
  const Index fiber = assembly.mesh.yarns[yarn].first_fiber, n = assembly.mesh.yarns[yarn].n_fibers;
  const Index first = assembly.mesh.first_node[fiber + n - 1];
  const auto& r = assembly.configuration.r;
  Vec3 axis = Vec3::Zero();
  for (Index f = fiber; f < fiber + n; ++f) axis += r[assembly.mesh.first_node[f]] / n;
  Vec3 a = r[first] - axis, b = r[first + 1] - axis;
  const double length = (b - a).dot(along);
  b -= b.dot(along) * along;
  a -= a.dot(along) * along;
  return std::atan2(along.dot(a.cross(b)), a.dot(b)) / (2 * std::numbers::pi) / length;
}

TEST(Yarns, TwistIsAHelixOfItsHand) {
  // S: left-handed, as the diagonal of the letter. The warp along x and the weft along y.
  EXPECT_NEAR(turns(assemble_scene(scene()), 2, Vec3::UnitX()), -800, 1);
  const Scene both = parse_scene(head + warp + weft.substr(0, weft.find("fiber_type")) +
                                     "fiber_type = \"filament\"\nfibers = 7\ntwist = \"900 m-1\"\n"
                                     "twist_direction = \"Z\"\n",
                                 "a.toml");
  const Assembly assembly = assemble_scene(both);
  EXPECT_NEAR(turns(assembly, 6, Vec3::UnitY()), 900, 1);
  // A helix is longer than its axis.
  const FiberMesh& mesh = assembly.mesh;
  const double r = 2.1 * both.fiber_types[0].radius, length = 1.5e-3;
  EXPECT_NEAR(mesh.length(mesh.yarns[6].first_fiber + 1), length * std::hypot(1, 2 * std::numbers::pi * 900 * r), 1e-8);
}

TEST(Yarns, RandomLaysDifferFromYarnToYarn) {
  std::string c = warp;
  c.replace(c.find("A A B"), 5, "C");
  const Assembly assembly = assemble_scene(parse_scene(head + c + weft, "a.toml"));
  const auto z = [&](Index yarn) {
    return assembly.configuration.r[assembly.mesh.first_node[assembly.mesh.yarns[yarn].first_fiber]].z();
  };
  EXPECT_NE(z(0), z(1));
}

struct Mistake {
  const char *right, *wrong, *message;
};
const Mistake mistakes[] = {
    {"density = \"1.14 g/cm3\"\n", "",
     "a.toml: fiber_type.filament.linear_density = \"3.25 dtex\": needs the density of material.pa66 (line 7)"},
    {"\"3.25 dtex\"", "\"3.25 um\"",
     "a.toml: fiber_type.filament.linear_density = \"3.25 um\": \"um\" does not convert to kg m-1; must be a linear "
     "density greater than 0"},
    {"linear_density = \"3.25 dtex\"", "linear_density = \"3.25 dtex\"\ndiameter = \"19 um\"",
     "a.toml: fiber_type.filament: must have either \"diameter\" or \"linear_density\""},
    {"\"78 dtex\"", "\"1 dtex\"",
     "a.toml: yarn.A.linear_density = \"1 dtex\": 0.307692 fibers of 0.325 tex; must be 1 to 1e+06"},
    {"fibers = 3\n", "", "a.toml: yarn.B: must have either \"fibers\" or \"linear_density\""},
    {"twist_direction = \"S\"\n", "", "a.toml: yarn.B.twist_direction: missing; must be \"S\" or \"Z\""},
    {"twist = \"800 per m\"\n", "", "a.toml: yarn.B.twist_direction = \"S\": has no effect, because there is no twist"},
    {"fibers = 3", "fibers = 3\nlayers = 2",
     "a.toml: yarn.B.layers = 2: has no effect, because twist makes a yarn round"},
    {"\"800 per m\"", "\"8000 per m\"",  // 2 · 200 um + 2 · 200 um
     "a.toml: weave.warp.elements = 20: must be at least 64, or an element has more than a tenth of a turn of twist"},
    {"volume_fraction = 0.55\n", "", "a.toml: yarn.C.volume_fraction: missing; must be a number of at least 0.05"},
    {"volume_fraction = 0.55", "volume_fraction = 0.9",
     "a.toml: yarn.C.volume_fraction = 0.9: must be a number of at least 0.05 and at most 0.8"},
    {"lay = \"random\"\n", "", "a.toml: yarn.C.volume_fraction = 0.55: has no effect, because lay is \"hexagonal\""},
    {"lay = \"random\"", "lay = \"random\"\nlattice_spacing = 1.1",
     "a.toml: yarn.C.lattice_spacing = 1.1: has no effect, because lay is \"random\""},
    {"\"A A B\"", "\"A A b\"",
     "a.toml: weave.warp.order = \"A A b\": \"b\" is no [yarn.NAME]; must be of \"A\", \"B\" or \"C\""},
    {"order = \"A A B\"", "order = \"A A B\"\nfibers = 3",
     "a.toml: weave.warp.fibers = 3: has no effect, because yarns are of the kinds that order names"},
    {"order = \"A A B\"\n", "", "a.toml: weave.warp.fiber_type: missing; must be the name of a fiber type"},
    {"[yarn.C]", "[yarn.\"C D\"]", "a.toml: yarn.\"C D\": must have a name without blanks"},
    {"sett = \"40 per cm\"", "sett = \"40 per cm\"\nyarn_spacing = \"250 um\"",
     "a.toml: weave.warp: must have either \"sett\" or \"yarn_spacing\""},
    {"\"40 per cm\"", "\"40 um\"",
     "a.toml: weave.warp.sett = \"40 um\": \"um\" does not convert to m-1; must be a number "
     "per length greater than 0"},
    {"\"40 per cm\"", "\"65 per cm\"",  // rows of eight: 19.05 um (1 + 7 · 1.05)

     "a.toml: weave.warp.sett = \"65 per cm\": must be at most 6286 per m, 1 over the width of a yarn, 0.0001591 m, or "
     "neighbouring yarns overlap"},
    {"\"50 per cm\"", "\"170 per cm\"",  // round: 2.1 diameters and one more
     "a.toml: weave.weft.sett = \"170 per cm\": must be at most 1.693e+04 per m, 1 over the width of a yarn, 5.906e-05 "
     "m"},
    {"sett = \"50 per cm\"", "yarn_spacing = \"10 um\"",
     "a.toml: weave.weft.yarn_spacing = \"10 um\": must be at least the width of a yarn, 5.906e-05 m"},
};

TEST(Yarns, ThatCannotBeAreRefused) {
  for (const Mistake& mistake : mistakes) {
    std::string toml = head + warp + weft;
    const auto at = toml.find(mistake.right);
    ASSERT_NE(at, std::string::npos) << mistake.right;
    toml.replace(at, std::string_view(mistake.right).size(), mistake.wrong);
    try {
      (void)parse_scene(toml, "a.toml");
      ADD_FAILURE() << "no error for " << mistake.wrong;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string_view(error.what()).starts_with(mistake.message))
          << "expected: " << mistake.message << "\n     got: " << error.what();
    }
  }
}

TEST(Yarns, OfARandomLayThatIsNotFoundAreRefused) {
  std::string toml = head + warp + weft;
  toml.replace(toml.find("A A B"), 5, "A C");
  toml.replace(toml.find("fibers = 12"), 11, "fibers = 2");
  toml.replace(toml.find("0.55"), 4, "0.75");
  try {
    (void)parse_scene(toml, "a.toml");
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(
        std::string(error.what()),
        "a.toml: weave.warp.order = \"A C\": yarn \"C\": no random lay of 2 fibers was found that fills 0.75 of its "
        "outline; must be less (line 30)");
  }
}

}  // namespace
}  // namespace trame::micro
