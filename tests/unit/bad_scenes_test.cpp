// Scenes with one mistake each: the message names the file, the key, the value and what is allowed.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

#include "micro/core/error.h"
#include "micro/scene/scene.h"

namespace trame::micro {
namespace {

const std::string good_scene = R"(title = "good"
[material.pa66]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.39
[material.carbon]
model = "transversely_isotropic"
young_modulus_axial = "230 GPa"
young_modulus_transverse = "15 GPa"
shear_modulus_axial = "24 GPa"
poisson_ratio_axial = 0.28
poisson_ratio_transverse = 0.3
[fiber_type.filament]
material = "pa66"
diameter = "20 um"
model = "enriched"
[[fiber]]
name = "wire"
fiber_type = "filament"
points = [["0 mm", "0 mm", "1 mm"], ["1 mm", "0 mm", "1 mm"]]
elements = 9
section_axis = [0, 0, 1]
[[bundle]]
name = "strand"
fiber_type = "filament"
points = [["0 mm", "0 mm", "2 mm"], ["1 mm", "0 mm", "2 mm"]]
elements = 5
fibers = 7
lattice_spacing = 1.1
[weave]
pattern = "satin"
harnesses = 5
step = 2
[weave.warp]
fiber_type = "filament"
yarns = 4
fibers = 7
layers = 2
elements = 11
yarn_spacing = "130 um"
margin = "100 um"
[weave.weft]
fiber_type = "filament"
yarns = 3
fibers = 8
elements = 12
yarn_spacing = "140 um"
margin = "90 um"
[[body]]
name = "grip"
position = ["1 mm", "2 mm", "3 mm"]
[[body.tie]]
fibers = "wire"
end = "end"
[effects]
contact = "all"
friction = true
twist_stretch = true
[contact]
friction_coefficient = 0.3
[solver]
min_increment = 1e-3
[[stage]]
name = "separate"
separate_yarns = true
friction = true
increments = 12
proximal_start = 1e-3
proximal_end = 1e-4
[[stage]]
name = "load"
[[stage.drive]]
bodies = "side/warp/*"
dof = "x"
strain = 0.02
[[stage.drive]]
bodies = "warp/*/end"
dof = "x"
follow = "side/warp/end"
[[stage.drive]]
bodies = "grip"
dof = "rz"
displacement = "90 deg"
)";

std::string error_of(const std::string& toml) {
  try {
    const Scene scene = parse_scene(toml, "bad.toml");
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

struct Mistake {
  const char* right;    ///< text of the good scene, found once or first
  const char* wrong;    ///< instead of it
  const char* message;  ///< how the message starts
};

/// Makes each mistake alone in the good scene.
void expect_refused(std::span<const Mistake> mistakes) {
  for (const Mistake& mistake : mistakes) {
    std::string toml = good_scene;
    const auto at = toml.find(mistake.right);
    ASSERT_NE(at, std::string::npos) << mistake.right;
    toml.replace(at, std::string_view(mistake.right).size(), mistake.wrong);
    const std::string message = error_of(toml);
    EXPECT_TRUE(message.starts_with(mistake.message)) << "expected: " << mistake.message << "\n     got: " << message;
  }
}

TEST(BadScenes, TheirModelIsGood) { EXPECT_EQ(error_of(good_scene), "no error"); }

const Mistake values[] = {
    {"poisson_ratio = 0.39", "poisson_ratio = 0.5",
     "bad.toml: material.pa66.poisson_ratio = 0.5: must be a number greater than -1 and less than 0.5 (line 5)"},
    {"poisson_ratio = 0.39", "poisson_ratio = -1", "bad.toml: material.pa66.poisson_ratio = -1: must be a number"},
    {"poisson_ratio = 0.39", "poisson_ratio = nan", "bad.toml: material.pa66.poisson_ratio = nan: must be a number"},
    {"\"3 GPa\"", "3e9",
     "bad.toml: material.pa66.young_modulus = 3000000000.0: must be a modulus greater than 0 with its unit, such as "
     "\"3 GPa\""},
    {"\"3 GPa\"", "\"-3 GPa\"", "bad.toml: material.pa66.young_modulus = \"-3 GPa\": must be a modulus greater than 0"},
    {"\"3 GPa\"", "\"3 GN\"",
     "bad.toml: material.pa66.young_modulus = \"3 GN\": \"GN\" does not convert to Pa; must be a modulus"},
    {"\"3 GPa\"", "\"inf GPa\"",
     "bad.toml: material.pa66.young_modulus = \"inf GPa\": the number is not finite; must be"},
    {"transverse = 0.3", "transverse = 1", "bad.toml: material.carbon.poisson_ratio_transverse = 1: must be a number"},
    {"transverse = 0.3", "transverse = 0.99",  // 2 · 0.28² · 15/230 = 0.01023
     "bad.toml: material.carbon.poisson_ratio_transverse = 0.99: must be less than 1 - 2 poisson_ratio_axial²"},
    {"\"20 um\"", "\"0 um\"",
     "bad.toml: fiber_type.filament.diameter = \"0 um\": must be a length greater than 0 with its unit, such as \"19 "
     "um\""},
    {"\"20 um\"", "\"20\"", "bad.toml: fiber_type.filament.diameter = \"20\": the unit is missing; must be a length"},
    {"\"enriched\"", "\"enrich\"",
     "bad.toml: fiber_type.filament.model = \"enrich\": must be \"enriched\" or \"rod\"; did you mean \"enriched\"?"},
    {"\"isotropic\"", "1", "bad.toml: material.pa66.model = 1: must be \"isotropic\" or \"transversely_isotropic\""},
    {"elements = 9", "elements = 0", "bad.toml: fiber[1].elements = 0: must be an integer of at least 1"},
    {"elements = 9", "elements = 9.0", "bad.toml: fiber[1].elements = 9.0: must be an integer of at least 1"},
    {"elements = 9", "elements = 3000000000", "bad.toml: fiber[1].elements = 3000000000: must be an integer"},
    {", [\"1 mm\", \"0 mm\", \"1 mm\"]]", "]",
     "bad.toml: fiber[1].points = [[\"0 mm\", \"0 mm\", \"1 mm\"]]: must be a list of at least two points"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"0 mm\", \"0 m\", \"1 mm\"]]",
     "bad.toml: fiber[1].points = [[\"0 mm\", \"0 mm\", \"1 mm\"], [\"0 mm\", \"0 m\", \"1 mm\"]]: points 1 and 2 must "
     "not "
     "coincide"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"1 mm\", \"0 mm\"]]",
     "bad.toml: fiber[1].points[2] = [\"1 mm\", \"0 mm\"]: must be a list of 3, each a length"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"1 mm\", 0, \"1 mm\"]]",
     "bad.toml: fiber[1].points[2][2] = 0: must be a length with its unit"},
    {"[0, 0, 1]", "[3, 0, 0]", "bad.toml: fiber[1].section_axis = [3, 0, 0]: must not be zero or along the fiber"},
    {"[0, 0, 1]", "[0, 0, 0]", "bad.toml: fiber[1].section_axis = [0, 0, 0]: must not be zero or along the fiber"},
    {"lattice_spacing = 1.1", "lattice_spacing = 0.9",
     "bad.toml: bundle[1].lattice_spacing = 0.9: must be a number of at least 1"},
    {"lattice_spacing = 1.1", "layers = 8", "bad.toml: bundle[1].layers = 8: must be at most the number of fibers"},
    {"fibers = 7\nlayers", "fibers = 0\nlayers",
     "bad.toml: weave.warp.fibers = 0: must be an integer of at least 1 and at most 1000000 (line 37)"},
    {"layers = 2", "layers = 8", "bad.toml: weave.warp.layers = 8: must be at most the number of fibers"},
    {"\"130 um\"", "\"80 um\"",  // 20 um (1 + 3 · 1.05) = 83 um
     "bad.toml: weave.warp.yarn_spacing = \"80 um\": must be at least the width of a yarn, 8.3e-05 m"},
    {"\"100 um\"", "\"-1 um\"", "bad.toml: weave.warp.margin = \"-1 um\": must be a length greater than 0"},
    {"\"3 mm\"]", "\"3 mm\", \"4 mm\"]",
     "bad.toml: body[1].position = [\"1 mm\", \"2 mm\", \"3 mm\", \"4 mm\"]: must be a list of 3"},
    {"friction_coefficient = 0.3", "friction_coefficient = -0.1",
     "bad.toml: contact.friction_coefficient = -0.1: must be a number of at least 0"},
    {"friction_coefficient = 0.3", "target_penetration = 1",
     "bad.toml: contact.target_penetration = 1: must be a number greater than 0 and less than 1"},
    {"min_increment = 1e-3", "min_increment = 2",
     "bad.toml: solver.min_increment = 2: must be a number greater than 0 and at most 1"},
    {"increments = 12", "increments = -1", "bad.toml: stage[1].increments = -1: must be an integer of at least 1"},
    {"separate_yarns = true", "separate_yarns = 1", "bad.toml: stage[1].separate_yarns = 1: must be true or false"},
    {"proximal_start = 1e-3", "proximal_start = 0",
     "bad.toml: stage[1].proximal_end = 0.0001: needs a proximal_start greater than 0"},
    {"strain = 0.02", "strain = \"2 um\"",
     "bad.toml: stage[2].drive[1].strain = \"2 um\": \"um\" does not convert to 1"},
    {"\"90 deg\"", "\"90 um\"",
     "bad.toml: stage[2].drive[3].displacement = \"90 um\": \"um\" does not convert to rad; must be an angle"},
    {"displacement = \"90 deg\"", "force = \"1 N\"",
     "bad.toml: stage[2].drive[3].force = \"1 N\": \"N\" does not convert to N m; must be a moment"},
    {"dof = \"rz\"", "dof = \"w\"",
     "bad.toml: stage[2].drive[3].dof = \"w\": must be \"x\", \"y\", \"z\", \"rx\", \"ry\" or \"rz\""},
};
TEST(BadScenes, Values) { expect_refused(values); }

const Mistake keys[] = {
    {"title", "titel", "bad.toml: titel = \"good\": unknown key; did you mean \"title\"?"},
    {"[solver]", "[slover]", "bad.toml: slover: unknown key; did you mean \"solver\"?"},
    {"elements = 12", "element = 12", "bad.toml: weave.weft.element = 12: unknown key; did you mean \"elements\"?"},
    {"elements = 5\n", "", "bad.toml: bundle[1].elements: missing; must be an integer of at least 1"},
    {"model = \"isotropic\"\n", "", "bad.toml: material.pa66.model: missing; must be \"isotropic\" or"},
    {"poisson_ratio = 0.39\n", "", "bad.toml: material.pa66.poisson_ratio: missing; must be a number"},
    {"poisson_ratio = 0.39", "poisson_ratio = 0.39\nshear_modulus_axial = \"1 GPa\"",
     "bad.toml: material.pa66.shear_modulus_axial = \"1 GPa\": unknown key"},
    {"[weave.weft]", "[weave.wefts]", "bad.toml: weave.wefts: unknown key; did you mean \"weft\"?"},
    {"name = \"grip\"\n", "", "bad.toml: body[1].name: missing; must be a name"},
    {"end = \"end\"\n", "", "bad.toml: body[1].tie[1].end: missing; must be \"start\" or \"end\""},
    {"[[body]]", "[body]", "bad.toml: body: must be a list of tables, written [[body]]"},
    {"[effects]", "[[effects]]", "bad.toml: effects: must be a table, written [effects]"},
    {"[[fiber]]", "[fiber]", "bad.toml: fiber: must be a list of tables, written [[fiber]]"},
    {"strain = 0.02\n", "",
     "bad.toml: stage[2].drive[1]: must have exactly one of \"displacement\", \"force\", \"strain\","},
    {"strain = 0.02", "strain = 0.02\nforce = \"1 N\"", "bad.toml: stage[2].drive[1]: must have exactly one of"},
    {"title = \"good\"", "title = good", "bad.toml: line 1: "},
    {"title = \"good\"", "title = \"good\"\ntitle = \"again\"", "bad.toml: line 2: "},
    {"title = \"good\"", "title = 3", "bad.toml: title = 3: must be a text in quotes"},
};
TEST(BadScenes, Keys) { expect_refused(keys); }

const Mistake names[] = {
    {"material = \"pa66\"", "material = \"pa6\"",
     "bad.toml: fiber_type.filament.material = \"pa6\": must be the name of a material: \"carbon\" or \"pa66\"; did "
     "you mean "
     "\"pa66\"?"},
    {"fiber_type = \"filament\"", "fiber_type = \"filamnet\"",
     "bad.toml: fiber[1].fiber_type = \"filamnet\": must be the name of a fiber type: \"filament\"; did you mean "
     "\"filament\"?"},
    {"name = \"strand\"", "name = \"wire\"",
     "bad.toml: bundle[1].name = \"wire\": must be a name of its own, but \"wire\" is taken"},
    {"name = \"strand\"", "name = \"weft/3\"", "bad.toml: bundle[1].name = \"weft/3\": must be a name of its own"},
    {"name = \"strand\"", "name = \"st*\"", "bad.toml: bundle[1].name = \"st*\": must be a name without the wildcards"},
    {"name = \"grip\"", "name = \"side/weft/end\"",
     "bad.toml: body[1].name = \"side/weft/end\": must be a name of its own"},
    {"name = \"load\"", "name = \"last\"",
     "bad.toml: stage[2].name = \"last\": must be neither a number nor \"last\", which name saved states (line 71)"},
    {"name = \"load\"", "name = \"03\"", "bad.toml: stage[2].name = \"03\": must be neither a number nor \"last\""},
    {"name = \"load\"", "name = \"-1\"", "bad.toml: stage[2].name = \"-1\": must be neither a number nor \"last\""},
    {"name = \"load\"", "name = \"separate\"", "bad.toml: stage[2].name = \"separate\": must be a name of its own"},
    {"fibers = \"wire\"", "fibers = \"wires*\"",
     "bad.toml: body[1].tie[1].fibers = \"wires*\": must fit the name of a fiber, bundle or yarn"},
    {"fibers = \"wire\"", "fibers = \"warp/5\"",
     "bad.toml: body[1].tie[1].fibers = \"warp/5\": must fit the name of a fiber"},
    {"end = \"end\"", "end = \"end\"\n[[body.tie]]\nfibers = \"w*\"\nend = \"end\"",
     "bad.toml: body[1].tie[2].fibers = \"w*\": this end of \"wire\" must not be tied twice"},
    {"bodies = \"grip\"", "bodies = \"grips\"",
     "bad.toml: stage[2].drive[3].bodies = \"grips\": must fit the name of a body; did you mean \"grip\"?"},
    {"bodies = \"grip\"\ndof = \"rz\"", "bodies = \"*/end\"\ndof = [\"rz\", \"rz\"]",
     "bad.toml: stage[2].drive[3].bodies = \"*/end\": a dof of \"warp/1/end\" must not be driven twice in a stage"},
    {"follow = \"side/warp/end\"", "follow = \"side/warp/ends\"",
     "bad.toml: stage[2].drive[2].follow = \"side/warp/ends\": must be the name of a body: "},
    {"follow = \"side/warp/end\"", "follow = \"warp/2/end\"",
     "bad.toml: stage[2].drive[2].follow = \"warp/2/end\": \"warp/2/end\" must not follow itself"},
    {"bodies = \"grip\"\ndof = \"rz\"\ndisplacement = \"90 deg\"",
     "bodies = \"side/warp/end\"\ndof = \"y\"\nfollow = \"warp/1/end\"",
     "bad.toml: stage[2].drive[3].follow = \"warp/1/end\": \"side/warp/end\" must not follow itself"},
    {"displacement = \"90 deg\"", "strain = 0.1",
     "bad.toml: stage[2].drive[3].strain = 0.1: is for the dofs x, y and z"},
    {"displacement = \"90 deg\"", "follow = \"side/warp/end\"",
     "bad.toml: stage[2].drive[3].follow = \"side/warp/end\": is for the dofs x, y and z"},
};
TEST(BadScenes, Names) { expect_refused(names); }

/// Texts that people see go into scripts, tables, pages and terminals.
const Mistake steering_texts[] = {
    {"title = \"good\"", "title = \"x\\n!touch pwned\\n#\"",
     "bad.toml: title = \"x\\n!touch pwned\\n#\": must be a text of one line without control characters"},
    {"title = \"good\"", "title = \"\"\"two\nlines\"\"\"",
     "bad.toml: title = \"two\\nlines\": must be a text of one line"},
    {"title = \"good\"", "title = \"\\u0000\"", "bad.toml: title = \"\\x00\": must be a text of one line"},
    {"title = \"good\"", "title = \"\\u200bgood\"", "bad.toml: title = \"\\u200bgood\": must be a text of one line"},
    {"title = \"good\"", "title = \"\\u202Egood\"", "bad.toml: title = \"\\u202egood\": must be a text of one line"},
    {"name = \"wire\"", "name = \"wi\\tre\"", "bad.toml: fiber[1].name = \"wi\\tre\": must be a text of one line"},
    {"name = \"strand\"", "name = \"\\u001b[31mstrand\"",
     "bad.toml: bundle[1].name = \"\\x1b[31mstrand\": must be a text of one line"},
    {"name = \"grip\"", "name = \"grip\\u2028\"",
     "bad.toml: body[1].name = \"grip\\u2028\": must be a text of one line"},
    {"name = \"load\"", "name = \"load\\r\\n2 %\"",
     "bad.toml: stage[2].name = \"load\\x0d\\n2 %\": must be a text of one"},
    {"name = \"load\"", "name = \"load\\u0085\"",
     "bad.toml: stage[2].name = \"load\\x85\": must be a text of one line"},
    {"[material.carbon]", "[material.\"car\\nbon\"]",
     "bad.toml: material.\"car\\nbon\": must have a name of one line without control characters"},
    {"[fiber_type.filament]", "[fiber_type.\"\\u007f\"]",
     "bad.toml: fiber_type.\"\\x7f\": must have a name of one line without control characters"},
    {"[effects]", "[effects]\n\"\\u001b[2J\" = 1", "bad.toml: effects.\"\\x1b[2J\" = 1: unknown key"},
};
TEST(BadScenes, TextsThatSteerWhatShowsThem) { expect_refused(steering_texts); }

TEST(BadScenes, TextsWithoutBound) {
  const auto with = [](std::string_view right, const std::string& wrong) {
    std::string toml = good_scene;
    return error_of(toml.replace(toml.find(right), right.size(), wrong));
  };
  const std::string long_name(129, 'n');
  for (const char* what : {"wire", "strand", "grip", "load"}) {
    const std::string message = with(fmt::format("name = \"{}\"", what), fmt::format("name = \"{}\"", long_name));
    EXPECT_NE(message.find("must be a name of at most 128 bytes"), std::string::npos) << message;
  }
  EXPECT_NE(with("[material.carbon]", "[material." + long_name + "]").find("at most 128 bytes"), std::string::npos);
  EXPECT_NE(with("title = \"good\"", "title = \"" + std::string(1001, 't') + "\"").find("at most 1000 bytes"),
            std::string::npos);
  EXPECT_EQ(with("title = \"good\"", "title = \"Gewebe, 2 × 2 „Garne“ µ\""), "no error");
}

TEST(SceneName, OfAFileWithAnyBytesIsText) {
  const std::string toml =
      "[material.m]\nmodel = \"isotropic\"\nyoung_modulus = \"3 GPa\"\npoisson_ratio = 0.3\n"
      "[fiber_type.f]\nmaterial = \"m\"\ndiameter = \"19 um\"\n[[fiber]]\nname = \"a\"\n"
      "fiber_type = \"f\"\npoints = [[\"0 m\", \"0 m\", \"0 m\"], [\"1 mm\", \"0 m\", \"0 m\"]]\n"
      "elements = 2\n";
  EXPECT_EQ(parse_scene(toml, "Tr\xe4ger.toml").name, "Tr\xef\xbf\xbdger");
  EXPECT_EQ(parse_scene(toml, "Träger.toml").name, "Träger");
  EXPECT_EQ(parse_scene(toml, "a\nb.toml").name,
            "a\xef\xbf\xbd"
            "b");
}

const Mistake patterns[] = {
    {"\"satin\"\nharnesses = 5\nstep = 2", "\"herringbone\"",
     "bad.toml: weave.pattern = \"herringbone\": must be \"plain\", \"twill\" or \"satin\""},
    {"pattern = \"satin\"\nharnesses = 5\nstep = 2\n", "",
     "bad.toml: weave: must have exactly one of \"pattern\", \"matrix\""},
    {"step = 2", "matrix = [[1]]", "bad.toml: weave: must have exactly one of \"pattern\", \"matrix\""},
    {"step = 2", "step = 4", "bad.toml: weave.step = 4: a satin of 5 harnesses must have a step from 2 to 3"},
    {"harnesses = 5", "harnesses = 6", "bad.toml: weave.step = 2: a satin of 6 harnesses must have a step from 2 to 4"},
    {"harnesses = 5", "harnesses = 4",
     "bad.toml: weave.harnesses = 4: must be an integer of at least 5 and at most 1000"},
    {"step = 2", "step = 2\nrepeat = \"2/2\"",
     "bad.toml: weave.repeat = \"2/2\": has no effect, because pattern is not \"twill\""},
    {"pattern = \"satin\"", "pattern = \"plain\"",
     "bad.toml: weave.harnesses = 5: has no effect, because pattern is not \"satin\""},
    {"\"satin\"\nharnesses = 5\nstep = 2", "\"twill\"\nrepeat = \"2/\"",
     "bad.toml: weave.repeat = \"2/\": must be an even number"},
    {"\"satin\"\nharnesses = 5\nstep = 2", "\"twill\"\nrepeat = \"2/1/1\"",
     "bad.toml: weave.repeat = \"2/1/1\": must be an even"},
    {"\"satin\"\nharnesses = 5\nstep = 2", "\"twill\"\nrepeat = \"2/0\"",
     "bad.toml: weave.repeat = \"2/0\": must be an even"},
    {"pattern = \"satin\"\nharnesses = 5\nstep = 2", "matrix = [[1, 0], [1]]",
     "bad.toml: weave.matrix[2] = [1]: must be one of rows of equal length of 0 and 1"},
    {"pattern = \"satin\"\nharnesses = 5\nstep = 2", "matrix = [[1, 2]]",
     "bad.toml: weave.matrix[1][2] = 2: must be an integer of at least 0 and at most 1"},
    {"pattern = \"satin\"\nharnesses = 5\nstep = 2", "matrix = []",
     "bad.toml: weave.matrix = []: must be rows of equal length"},
};
TEST(BadScenes, Patterns) { expect_refused(patterns); }

const Mistake effects[] = {
    {"friction = true\ntwist", "friction = false\ntwist",
     "bad.toml: contact.friction_coefficient = 0.3: has no effect, because effects.friction is false"},
    {"friction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3", "friction = false",
     "bad.toml: stage[1].friction = true: has no effect, because friction is off for the scene"},
    {"contact = \"all\"", "contact = \"none\"",
     "bad.toml: effects.friction = true: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3",
     "contact = \"none\"\n[contact]\nspacing = 0.5",
     "bad.toml: contact.spacing = 0.5: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true", "contact = \"none\"\nself_contact = true",
     "bad.toml: effects.self_contact = true: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true", "contact = \"none\"\nadapt_penalty = true",
     "bad.toml: effects.adapt_penalty = true: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3\n[solver]",
     "contact = \"none\"\n[solver]\nmax_geometry_updates = 3",
     "bad.toml: solver.max_geometry_updates = 3: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3\n[solver]",
     "contact = \"none\"\n[solver]\ngeometry_tolerance = 1e-3",
     "bad.toml: solver.geometry_tolerance = 0.001: has no effect, because effects.contact is \"none\""},
    {"contact = \"all\"\nfriction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3",
     "contact = \"none\"",
     "bad.toml: stage[1].separate_yarns = true: needs contact, or yarns would pass through each other again"},
    {"friction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3",
     "adapt_penalty = false\n[contact]\ntarget_penetration = 0.02",
     "bad.toml: contact.target_penetration = 0.02: has no effect, because effects.adapt_penalty is false"},
    {"friction = true\ntwist_stretch = true\n[contact]\nfriction_coefficient = 0.3",
     "friction = false\n[contact]\nreversible_slip = 0.1",
     "bad.toml: contact.reversible_slip = 0.1: has no effect, because effects.friction is false"},
    {"friction = true\ntwist", "self_contact = 1\ntwist", "bad.toml: effects.self_contact = 1: must be true or false"},
    {"\"enriched\"", "\"rod\"",
     "bad.toml: effects.twist_stretch = true: has no effect, because no fiber is of the enriched model in any stage"},
};
TEST(BadScenes, Effects) { expect_refused(effects); }

/// A wire of another type beside the filaments.
std::string with_other_wire(const std::string& modulus, const std::string& diameter) {
  std::string toml = good_scene;
  const std::string wire = "name = \"wire\"\nfiber_type = \"filament\"";
  toml.replace(toml.find(wire), wire.size(), "name = \"wire\"\nfiber_type = \"other\"");
  return toml + "[material.other]\nmodel = \"isotropic\"\nyoung_modulus = \"" + modulus +
         "\"\npoisson_ratio = 0\n[fiber_type.other]\nmaterial = \"other\"\ndiameter = \"" + diameter + "\"\n";
}

TEST(BadScenes, StiffnessesThatDoublePrecisionCannotBear) {
  EXPECT_EQ(error_of(with_other_wire("200 GPa", "20 um")), "no error");
  EXPECT_EQ(error_of(with_other_wire("3 GPa", "200 um")), "no error");
  const auto expect_start = [](const std::string& message, const std::string& start) {
    EXPECT_TRUE(message.starts_with(start)) << message;
    EXPECT_NE(message.find("double precision bears 1e11; must be at "), std::string::npos) << message;
  };
  expect_start(error_of(with_other_wire("1e18 Pa", "20 um")),
               "bad.toml: material.other.young_modulus = \"1e18 Pa\": E A of fiber_type.other would be ");
  expect_start(error_of(with_other_wire("3 GPa", "200 m")), "bad.toml: fiber_type.other.diameter = \"200 m\": E A of");
  // A carbon fiber beside the filaments, hard along the fiber alone.
  std::string carbon = with_other_wire("3 GPa", "20 um");
  carbon.replace(carbon.find("material = \"other\""), 18, "material = \"carbon\"");
  EXPECT_EQ(error_of(carbon), "no error");
  carbon.replace(carbon.find("230 GPa"), 7, "1e20 Pa");
  expect_start(error_of(carbon), "bad.toml: material.carbon.young_modulus_axial = \"1e20 Pa\": ");
}

TEST(BadScenes, WhatNoFiberHasIsNotAskedForItsStiffness) {
  std::string toml = good_scene;
  toml.replace(toml.find("230 GPa"), 7, "1e20 Pa");  // carbon, of which no fiber is
  EXPECT_EQ(error_of(toml), "no error");
}

TEST(BadScenes, EveryContactKeyNeedsContact) {
  for (const char* line :
       {"friction_coefficient = 0.1", "reversible_slip = 0.1", "spacing = 0.4", "search_margin = 0.4",
        "target_penetration = 0.1", "regularisation = 0.2", "penalty = 0.1"}) {
    std::string toml = good_scene;
    const std::string right =
        "contact = \"all\"\nfriction = true\ntwist_stretch = true\n[contact]\n"
        "friction_coefficient = 0.3";
    toml.replace(toml.find(right), right.size(), std::string("contact = \"none\"\n[contact]\n") + line);
    EXPECT_TRUE(error_of(toml).starts_with(std::string("bad.toml: contact.") + line +
                                           ": has no effect, because effects.contact is \"none\""))
        << error_of(toml);
  }
}

const std::string bare_scene = R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.t]
material = "m"
diameter = "10 um"
model = "rod"
)";

TEST(BadScenes, NothingToSimulate) {
  EXPECT_EQ(error_of(""), "bad.toml: scene: must have at least one [[fiber]], [[bundle]] or a [weave] (line 1)");
  EXPECT_EQ(error_of(bare_scene), error_of(""));
}

TEST(BadScenes, ReferencesIntoNothing) {
  EXPECT_EQ(error_of("[fiber_type.t]\nmaterial = \"m\"\ndiameter = \"1 um\"\n"),
            "bad.toml: fiber_type.t.material = \"m\": must be the name of a material, but the scene has none (line 2)");
}

const std::string wire =
    "[[fiber]]\nname = \"w\"\nfiber_type = \"t\"\nelements = 2\n"
    "points = [[\"0 m\", \"0 m\", \"0 m\"], [\"1 mm\", \"0 m\", \"0 m\"]]\n";

TEST(BadScenes, SeparationNeedsAWeave) {
  EXPECT_EQ(error_of(bare_scene + wire + "[[stage]]\nname = \"s\"\nseparate_yarns = true\n"),
            "bad.toml: stage[1].separate_yarns = true: needs a [weave] (line 16)");
}

TEST(BadScenes, SectionAxisNeedsEnrichedFibers) {
  EXPECT_EQ(
      error_of(bare_scene + wire + "section_axis = [0, 0, 1]\n"),
      "bad.toml: fiber[1].section_axis = [0, 0, 1]: has no effect, because this fiber is of the enriched model in no "
      "stage (line 14)");
  EXPECT_EQ(
      error_of(bare_scene + wire + "section_axis = [0, 0, 1]\n[[stage]]\nname = \"s\"\nfiber_model = \"enriched\"\n"),
      "no error");
}

TEST(BadScenes, SectionAxisNeedsAnEnrichedFiberOfItsOwn) {
  const std::string beam = "[fiber_type.beam]\nmaterial = \"m\"\ndiameter = \"10 um\"\n";
  const std::string other =
      "[[fiber]]\nname = \"o\"\nfiber_type = \"beam\"\nelements = 2\nsection_axis = [0, 0, 1]\n"
      "points = [[\"0 m\", \"1 mm\", \"0 m\"], [\"1 mm\", \"1 mm\", \"0 m\"]]\n";
  EXPECT_EQ(error_of(bare_scene + beam + wire + other), "no error");
  EXPECT_EQ(
      error_of(bare_scene + beam + wire + "section_axis = [0, 0, 1]\n" + other),
      "bad.toml: fiber[1].section_axis = [0, 0, 1]: has no effect, because this fiber is of the enriched model in "
      "no stage (line 17)");
  EXPECT_TRUE(error_of(bare_scene + beam + wire + other + "[[stage]]\nname = \"s\"\nfiber_model = \"rod\"\n")
                  .starts_with("bad.toml: fiber[2].section_axis = [0, 0, 1]: has no effect"));
}

TEST(BadScenes, FrictionThatEveryStageSwitchesOff) {
  const std::string frictionless = "[[stage]]\nname = \"s\"\nfriction = false\n";
  EXPECT_EQ(error_of(bare_scene + wire + frictionless), "no error");  // nobody asked for friction
  EXPECT_EQ(error_of(bare_scene + wire + "[effects]\nfriction = true\n" + frictionless),
            "bad.toml: effects.friction = true: has no effect, because every stage has friction = false (line 15)");
  EXPECT_EQ(error_of(bare_scene + wire + "[contact]\nfriction_coefficient = 0.1\n" + frictionless),
            "bad.toml: contact.friction_coefficient = 0.1: has no effect, because every stage has friction = false "
            "(line 15)");
  EXPECT_EQ(error_of(bare_scene + wire + "[effects]\nfriction = true\n" + frictionless + "[[stage]]\nname = \"t\"\n"),
            "no error");
}

TEST(BadScenes, DrivesOfAbsentBodies) {
  EXPECT_EQ(error_of(bare_scene + wire +
                     "[[stage]]\nname = \"s\"\n[[stage.drive]]\nbodies = \"*\"\ndof = \"x\"\nstrain = 0\n"),
            "bad.toml: stage[1].drive[1].bodies = \"*\": must fit the name of a body, but the scene has none (line "
            "17)");
}

/// A body for each fiber, each following the one before.
std::string scene_of_many(int n) {
  std::string toml = bare_scene, drives = "[[stage]]\nname = \"s\"\n";
  for (int i = 0; i < n; ++i) {
    toml += fmt::format(
        "[[fiber]]\nname = \"f{0}\"\nfiber_type = \"t\"\npoints = [[\"0 m\", \"0 m\", \"{0} mm\"], [\"1 mm\", "
        "\"0 m\", \"{0} mm\"]]\nelements = 1\n[[body]]\nname = \"b{0}\"\n[[body.tie]]\nfibers = \"f{0}\"\nend = "
        "\"start\"\n",
        i);
    drives += i == 0 ? "" : fmt::format("[[stage.drive]]\nbodies = \"b{}\"\ndof = \"x\"\nfollow = \"b{}\"\n", i, i - 1);
  }
  return toml + drives;
}

TEST(BadScenes, LargeOnesTakeNoLongerThanTheyAreLarge) {
  const auto seconds = [](int n) {
    const std::string toml = scene_of_many(n);
    const std::clock_t start = std::clock();
    EXPECT_EQ(error_of(toml), "no error");
    return double(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const double few = std::min(seconds(1000), seconds(1000)), many = seconds(10'000);
  EXPECT_LT(many, 40 * few) << "10 if linear, 100 if quadratic; " << few << " s for 1000";
}

TEST(BadScenes, CirclesOfFollowers) {
  std::string toml = scene_of_many(100);
  toml += "[[stage.drive]]\nbodies = \"b0\"\ndof = \"x\"\nfollow = \"b99\"\n";
  EXPECT_TRUE(
      error_of(toml).starts_with("bad.toml: stage[1].drive[100].follow = \"b99\": \"b0\" must not follow itself"))
      << error_of(toml);
}

TEST(BadScenes, FilesThatCannotBeRead) {
  const auto error = [](const std::filesystem::path& file) -> std::string {
    try {
      return "no error in " + read_scene(file).name;
    } catch (const InputError& e) {
      return e.what();
    }
  };
  EXPECT_EQ(error("/no/such/scene.toml"), "/no/such/scene.toml: cannot be read; must be a scene in TOML");
  const auto folder = std::filesystem::temp_directory_path();
  EXPECT_EQ(error(folder), folder.string() + ": is a folder; must be a scene in TOML");
  const auto binary = folder / "trame_bad_scenes_test.toml";
  std::ofstream(binary, std::ios::binary) << std::string("\0\xff\xfe\x89HDF", 7);
  EXPECT_EQ(error(binary).substr(0, 36), "trame_bad_scenes_test.toml: line 1: ");
  std::filesystem::remove(binary);
}

/// Sizes whose squares and products double precision cannot hold, or not beside each other.
const Mistake out_of_proportion[] = {
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"1e308 um\", \"0 mm\", \"1 mm\"]]",
     "bad.toml: fiber[1].points[2][1] = \"1e308 um\": must be at most 1e+06 m"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"2 Ym\", \"0 mm\", \"1 mm\"]]",
     "bad.toml: fiber[1].points[2][1] = \"2 Ym\": must be at most 1e+06 m"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]", "[\"2 km\", \"0 mm\", \"1 mm\"]]",
     "bad.toml: fiber_type.filament.diameter = \"20 um\": E A of"},
    {"[\"1 mm\", \"2 mm\", \"3 mm\"]", "[\"-20 km\", \"2 mm\", \"3 mm\"]",
     "bad.toml: body[1].position = [\"-20 km\", \"2 mm\", \"3 mm\"]: must be at most 1000 m, 1e+08 radii"},
    {"diameter = \"20 um\"", "diameter = \"1e-300 m\"",
     "bad.toml: fiber_type.filament.diameter = \"1e-300 m\": must be at least 1e-12 m"},
    {"[[fiber]]",
     "[fiber_type.thick]\nmaterial = \"pa66\"\ndiameter = \"1 m\"\n[[fiber]]\nname = \"rope\"\n"
     "fiber_type = \"thick\"\npoints = [[\"0 m\", \"0 m\", \"5 m\"], [\"9 m\", \"0 m\", \"5 m\"]]\n"
     "elements = 3\n[[fiber]]",
     "bad.toml: fiber_type.thick.diameter = \"1 m\": E A of fiber_type.thick would be"},
    {"[\"1 mm\", \"0 mm\", \"1 mm\"]]\nelements = 9", "[\"10 um\", \"0 mm\", \"1 mm\"]]\nelements = 450000",
     "bad.toml: fiber[1].elements = 450000: elements of 2.22222e-11 m; must be at least 1e-10 m"},
    {"\"3 GPa\"", "\"1e-300 Pa\"", "bad.toml: material.pa66.young_modulus = \"1e-300 Pa\": must be at least 1e-06 Pa"},
    {"\"3 GPa\"", "\"1e300 Pa\"", "bad.toml: material.pa66.young_modulus = \"1e300 Pa\": must be at most 1e+60 Pa"},
    {"friction_coefficient = 0.3", "friction_coefficient = 1e300",
     "bad.toml: contact.friction_coefficient = 1e+300: must be at most 1e+09"},
    {"friction_coefficient = 0.3", "penalty = 1e-300", "bad.toml: contact.penalty = 1e-300: must be at least 1e-12"},
    {"lattice_spacing = 1.1", "lattice_spacing = 1e9", "bad.toml: bundle[1].lattice_spacing = 1000000000.0: must be a"},
    {"displacement = \"90 deg\"", "displacement = \"1e300 deg\"",
     "bad.toml: stage[2].drive[3].displacement = \"1e300 deg\": must be at most 1e+06 rad"},
    {"dof = \"rz\"\ndisplacement = \"90 deg\"", "dof = \"x\"\ndisplacement = \"2 km\"",
     "bad.toml: stage[2].drive[3].displacement = \"2 km\": must be at most 1000 m"},
    {"dof = \"rz\"\ndisplacement = \"90 deg\"", "dof = \"x\"\nforce = \"1 GN\"",
     "bad.toml: stage[2].drive[3].force = \"1 GN\": must be at most 300000 N"},
    {"dof = \"rz\"\ndisplacement = \"90 deg\"", "dof = \"rz\"\nforce = \"1 GN m\"",
     "bad.toml: stage[2].drive[3].force = \"1 GN m\": must be at most 3 N m"},
    {"strain = 0.02", "strain = 1e8", "bad.toml: stage[2].drive[1].strain = 100000000.0: must be at most 1000"},
};
TEST(BadScenes, SizesOutOfProportion) { expect_refused(out_of_proportion); }

/// Numbers of things, and what makes many of them: no machine runs that.
const Mistake too_many[] = {
    {"elements = 9", "elements = 2147483647",
     "bad.toml: fiber[1].elements = 2147483647: must be an integer of at least 1 and at most 1000000"},
    {"fibers = 7\nlattice_spacing", "fibers = 1000001\nlattice_spacing",
     "bad.toml: bundle[1].fibers = 1000001: must be an integer of at least 1 and at most 1000000"},
    {"fibers = 7\nlattice_spacing", "fibers = 1000000\nlayers = 9223372036854775807\nlattice_spacing",
     "bad.toml: bundle[1].layers = 9223372036854775807: must be an integer of at least 1 and at most 1000000"},
    {"elements = 5\nfibers = 7", "elements = 1000000\nfibers = 51",
     "bad.toml: bundle[1].elements = 1000000: makes 1.02e+08 of 1.02e+08 nodes; the scene must have at most 100000000"},
    {"elements = 5\nfibers = 7", "elements = 100\nfibers = 1000000",
     "bad.toml: bundle[1].fibers = 1000000: makes 2.01e+08 of 2.01e+08 nodes; the scene must have at most 100000000"},
    {"yarns = 4", "yarns = 1001",
     "bad.toml: weave.warp.yarns = 1001: must be an integer of at least 1 and at most 1000"},
    {"step = 2", "step = 2147483647",
     "bad.toml: weave.step = 2147483647: must be an integer of at least 2 and at most 1000"},
    {"increments = 12", "increments = 2147483647",
     "bad.toml: stage[1].increments = 2147483647: must be an integer of at least 1 and at most 100000"},
    {"increments = 12", "save_every = 100001",
     "bad.toml: stage[1].save_every = 100001: must be an integer of at least 1 and at most 100000"},
    {"min_increment", "max_newton_iterations = 2147483647\nmin_increment",
     "bad.toml: solver.max_newton_iterations = 2147483647: must be an integer of at least 1 and at most 10000"},
    {"min_increment", "max_geometry_updates = 10001\nmin_increment",
     "bad.toml: solver.max_geometry_updates = 10001: must be an integer of at least 1 and at most 10000"},
    {"friction_coefficient = 0.3", "spacing = 1e-6",
     "bad.toml: contact.spacing = 1e-06: must be a number of at least 0.01 and at most 1000"},
    {"friction_coefficient = 0.3", "search_margin = 1e6",
     "bad.toml: contact.search_margin = 1000000.0: must be a number greater than 0 and at most 1000"},
};
TEST(BadScenes, TooMany) { expect_refused(too_many); }

TEST(BadScenes, IncrementsOfAllStages) {
  std::string toml = bare_scene + wire;
  for (int i = 1; i <= 11; ++i) toml += fmt::format("[[stage]]\nname = \"s{}\"\nincrements = 100000\n", i);
  EXPECT_TRUE(
      error_of(toml).starts_with("bad.toml: stage[11]: 1100000 increments up to this stage; must be at most 1000000"))
      << error_of(toml);
  const std::string message =
      error_of(good_scene + "[test]\nkind = \"biaxial\"\nwarp_strain = 0.1\nincrements = 100000\ncycles = 10\n");
  EXPECT_TRUE(message.starts_with("bad.toml: test: 20000")) << message;
  EXPECT_NE(message.find(" increments up to this stage; must be at most 1000000"), std::string::npos) << message;
}

TEST(BadScenes, ModuliOutOfProportionCountWhereFibersHaveThem) {
  std::string toml = good_scene;
  toml.replace(toml.find("\"230 GPa\""), 9, "\"1e21 Pa\"");
  toml.replace(toml.find("\"15 GPa\""), 8, "\"1 kPa\"");
  EXPECT_EQ(error_of(toml), "no error") << "no fiber is of carbon";
  toml.replace(toml.find("material = \"pa66\""), 17, "material = \"carbon\"");
  EXPECT_TRUE(
      error_of(toml).starts_with("bad.toml: material.carbon.young_modulus_axial = \"1e21 Pa\": E A of "
                                 "fiber_type.filament would be "))
      << error_of(toml);
}

TEST(BadScenes, UnknownKeysAreToldAtOnce) {
  std::string toml = good_scene;
  using Change = std::pair<std::string_view, const char*>;
  for (const auto& [right, wrong] : {Change{"title =", "titel ="}, Change{"diameter =", "diametre ="},
                                     Change{"friction_coefficient", "friction"}, Change{"min_increment", "min_step"}})
    toml.replace(toml.find(right), right.size(), wrong);
  std::string message = error_of(toml);
  std::size_t at = 0;
  for (const char* part :
       {"titel = \"good\": unknown key", "fiber_type.filament.diametre = \"20 um\": unknown key",
        "did you mean \"diameter\"?", "fiber_type.filament: must have either \"diameter\" or \"linear_density\""}) {
    EXPECT_NE(message.find(part, at), std::string::npos) << part << "\nin: " << message;
    at = std::min(message.size(), message.find(part, at));
  }
  message = error_of(toml.replace(toml.find("diametre"), 8, "diameter"));
  for (const char* part : {"titel", "contact.friction = 0.3: unknown key", "solver.min_step = 0.001: unknown key"})
    EXPECT_NE(message.find(part), std::string::npos) << part << "\nin: " << message;
  EXPECT_EQ(std::ranges::count(message, '\n'), 2) << message;
}

TEST(BadScenes, ThousandsOfUnknownKeysAreCounted) {
  std::string toml = good_scene;
  for (int i = 0; i < 1000; ++i) toml += fmt::format("[x{}]\n", i);
  const std::string message = error_of(toml);
  EXPECT_EQ(std::ranges::count(message, '\n'), 30) << message;
  EXPECT_TRUE(message.ends_with("bad.toml: and 970 more unknown keys")) << message;
}

TEST(BadScenes, NumbersInQuotes) {
  std::string toml = good_scene;
  toml.replace(toml.find("coefficient = 0.3"), 17, "coefficient = \"0.25\"");
  EXPECT_TRUE(error_of(toml).starts_with(
      "bad.toml: contact.friction_coefficient = \"0.25\": must be a plain number, not a text: without quotes"))
      << error_of(toml);
}

TEST(BadScenes, NamesThatFitNothingAreToldWhichThereAre) {
  std::string toml = good_scene;
  toml.replace(toml.find("bodies = \"grip\""), 15, "bodies = [\"grip\", \"clamp/*\"]");
  const std::string message = error_of(toml);
  for (const char* part : {"clamp/*", "must fit the name of a body: ", "\"warp/1/start\"", "\"grip\"", "in all"})
    EXPECT_NE(message.find(part), std::string::npos) << part << "\nin: " << message;
}

TEST(BadScenes, KeysWithoutBottom) {
  const auto nested = [](int n) {
    std::string key = "a";
    for (int i = 1; i < n; ++i) key += ".a";
    return key;
  };
  const std::string texts = "x = \"\"\"\n\"\"\"\n", literals = "x = '''it's \"''' # \"\n";
  for (const std::string& toml :
       {fmt::format("{} = 1\n", nested(30'000)), fmt::format("[{}]\n", nested(30'000)),
        fmt::format("[[{}]]\n", nested(30'000)), fmt::format("x = {{ {} = 1 }}\n", nested(30'000)),
        fmt::format("{}{} = 1\n", texts, nested(17)), fmt::format("{}{} = 1\n", literals, nested(17))})
    EXPECT_NE(error_of(toml).find("a key of more than 16 parts"), std::string::npos) << toml.substr(0, 60);
  EXPECT_NE(error_of(texts + nested(17) + " = 1\n").find("line 3: a key"), std::string::npos);
  const std::string dots(100, '.');
  EXPECT_EQ(error_of("# " + dots + "\n" + good_scene), "no error");
  std::string toml = good_scene;
  EXPECT_EQ(error_of(toml.replace(toml.find("\"good\""), 6, "\"" + dots + " \\\" " + dots + "\"")), "no error");
  EXPECT_EQ(error_of("title = 'x" + dots + "' # ' \"" + toml.substr(toml.find('\n'))), "no error");
  EXPECT_NE(error_of("x = " + std::string(100'000, '[')), "no error");
}

TEST(BadScenes, ControlCharacters) {
  EXPECT_EQ(error_of(std::string("\n[\0x]\n", 6)), "bad.toml: line 2: a control character, \"\\x00\"");
  EXPECT_EQ(error_of("# \x1b[2J\n" + good_scene), "bad.toml: line 1: a control character, \"\\x1b\"");
}

/// A scene is read in seconds, whatever its size.
TEST(BadScenes, ListsAndTextsWithoutBound) {
  std::string toml = good_scene;
  std::string points = "[[\"0 mm\", \"0 mm\", \"1 mm\"]";
  for (int i = 1; i <= 1000; ++i) points += fmt::format(", [\"{} um\", \"0 mm\", \"1 mm\"]", i);
  const std::string two = "[[\"0 mm\", \"0 mm\", \"1 mm\"], [\"1 mm\", \"0 mm\", \"1 mm\"]]";
  const std::string message = error_of(toml.replace(toml.find(two), two.size(), points + "]"));
  EXPECT_NE(message.find("must be a list of at least two points, and at most 1000 (line"), std::string::npos)
      << message;
  toml = good_scene;
  const std::string unit = "2 lg(re " + std::string(2000, '(') + "m" + std::string(2001, ')');
  const std::string long_unit = error_of(toml.replace(toml.find("20 um"), 5, unit));
  EXPECT_NE(long_unit.find("...: longer than 1000 bytes; must be a length"), std::string::npos) << long_unit;
  std::string many = "[effects]\ncontact = \"none\"\n" + bare_scene;
  for (int i = 0; i < 3000; ++i)
    many += fmt::format(
        "[[fiber]]\nname = \"{0}\"\nfiber_type = \"t\"\nelements = 1\npoints = [[\"0 m\", \"{0} mm\", \"0 m\"], "
        "[\"1 mm\", \"{0} mm\", \"0 m\"]]\n",
        i);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(error_of(many), "no error");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

TEST(BadScenes, FilesWithoutBound) {
  EXPECT_NE(error_of(std::string(16'000'001, '#')).find("16000001 bytes; a scene has at most 16000000"),
            std::string::npos);
}

}  // namespace
}  // namespace trame::micro
