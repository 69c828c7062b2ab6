// Weaving drafts: WIF as weaving programs write it, drafts that contradict themselves, pictures, and scenes with
// either.

#include "micro/scene/draft.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "micro/core/error.h"
#include "micro/scene/scene.h"
#include "tests/support/temporary_folder.h"

namespace trame::micro {
namespace {

/// 2/2 twill on four shafts.
const std::string twill = R"([WIF]
Version=1.1
Date=April 20, 1997
Developers=wif@mhsoft.com
[CONTENTS]
COLOR TABLE=true
WEAVING=true
THREADING=true
TIEUP=true
TREADLING=true
[WEAVING]
Rising Shed=true
Treadles=4
Shafts=4
[WARP]
Threads=8
Color=1
[WEFT]
Threads=4
[COLOR TABLE]
1=999,0,0
[THREADING]
1=1
2=2
3=3
4=4
[TIEUP]
1=1,2
2=2,3
3=3,4
4=1,4
[TREADLING]
1=1
2=2
3=3
4=4
)";
const WeavePattern twill_pattern_2_2 = {{1, 1, 0, 0}, {0, 1, 1, 0}, {0, 0, 1, 1}, {1, 0, 0, 1}};

WeavePattern whole(const Draft& draft) { return pattern_of(draft, 0, 0, draft.n_weft(), draft.n_warp()); }
WeavePattern read(const std::string& wif) { return whole(parse_draft(wif, "a.wif")); }

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(Draft, IsThreadingThroughTieUpToTreadling) { EXPECT_EQ(read(twill), twill_pattern_2_2); }

TEST(Draft, LiftplanMeansTheSame) {
  const std::string lifts = twill.substr(0, twill.find("[TIEUP]")) + "[LIFTPLAN]\n1=1,2\n2=2,3\n3=3,4\n4=4,1\n";
  EXPECT_EQ(read(lifts), twill_pattern_2_2);
  EXPECT_EQ(read(twill + "[LIFTPLAN]\n1=1,2\n2=2,3\n3=3,4\n4=4,1\n"), twill_pattern_2_2);
}

TEST(Draft, SinkingShedLiftsWhatIsNotTied) {
  WeavePattern sunk = twill_pattern_2_2;
  for (auto& row : sunk) row.flip();
  EXPECT_EQ(read(replaced(twill, "Rising Shed=true", "rising shed = no")), sunk);
}

TEST(Draft, WithoutTieUpEachTreadleHasItsShaft) {
  const std::string direct = twill.substr(0, twill.find("[TIEUP]")) + "[TREADLING]\n1=1,2\n2=2,3\n3=3,4\n4=1,4\n";
  EXPECT_EQ(read(direct), twill_pattern_2_2);
  EXPECT_EQ(read(direct + "[TIEUP]\n1=\n2=0\n"), twill_pattern_2_2);
}

TEST(Draft, ToleratesWhatProgramsWrite) {
  // Ends of lines of three kinds, comments, small letters, blanks, a byte order mark, bytes that are no UTF-8, sections
  // in any order, sections of programs' own, a claim in [CONTENTS] that does not hold, empty and superfluous lines.
  EXPECT_EQ(
      read("\xEF\xBB\xBF; made by hand\r\n[notes]\r1=gr\xfc\xdf"
           "e\n[Private Loom]\nx\n; [THREADING]\n"
           "[treadling]\n 1 = 1 ; first\n2=2\n\n3=3\n4=4\n5=0\n6=\n[TieUp]\r\n1=2,1\r\n2= 2 , 3\r\n3=3,4\r\n4=1,4,4\r\n"
           "[CONTENTS]\nTIEUP=false\n[THREADING]\n4=4\n3=3\n2=2\n1=1\n1=1\n9=0\n"),
      twill_pattern_2_2);
}

TEST(Draft, MayCountFromNought) {
  EXPECT_EQ(read("[THREADING]\n0=1\n1=2\n2=3\n3=4\n[LIFTPLAN]\n0=1,2\n1=2,3\n2=3,4\n3=1,4\n"), twill_pattern_2_2);
}

TEST(Draft, PickMayLiftNothingAndYarnsMayBeOnSeveralShafts) {
  EXPECT_EQ(read("[THREADING]\n1=1\n2=2\n3=1,2\n[LIFTPLAN]\n1=1\n3=2\n"),
            (WeavePattern{{1, 0, 1}, {0, 0, 0}, {0, 1, 1}}));
}

TEST(Draft, WindowGoesOnAndRepeats) {
  const Draft draft = parse_draft(twill, "a.wif");
  EXPECT_EQ(pattern_of(draft, 1, 2, 2, 5), (WeavePattern{{1, 0, 0, 1, 1}, {1, 1, 0, 0, 1}}));
}

std::string error_of(const std::string& wif) {
  try {
    (void)parse_draft(wif, "a.wif");
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Draft, ThatContradictsItselfIsRefusedWithSectionAndLine) {
  EXPECT_EQ(error_of(twill + "[LIFTPLAN]\n1=1,2\n2=2,4\n"),
            "a.wif: [LIFTPLAN]: weft yarn 2 has shafts 2,4, but by [TREADLING] and [TIEUP] 2,3 (line 34) (line 39)");
  EXPECT_EQ(error_of(replaced(twill, "4=4\n[TIEUP]", "4=5\n[TIEUP]")),
            "a.wif: [THREADING]: shaft 5, but [WEAVING] has shafts = 4 (line 26)");
  EXPECT_EQ(error_of(replaced(twill, "2=2,3", "2=2,7")),
            "a.wif: [TIEUP]: shaft 7, but [WEAVING] has shafts = 4 (line 29)");
  EXPECT_EQ(error_of(twill + "5=6\n"), "a.wif: [TREADLING]: treadle 6 has no line in [TIEUP] (line 37)");
  EXPECT_EQ(error_of(replaced(twill, "2=2\n", "")),
            "a.wif: [THREADING]: warp yarn 2 is on no shaft, though later ones are (line 23)");
  EXPECT_EQ(error_of(twill + "[THREADING]\n2=3\n"), "a.wif: [THREADING]: 2 = 3: line 24 says otherwise (line 38)");
}

TEST(Draft, ThatLacksWhatItNeedsIsRefused) {
  EXPECT_EQ(error_of(""),
            "a.wif: has no [THREADING] that tells the shafts of its warp yarns; must be a draft in WIF, version 1.1");
  EXPECT_EQ(error_of("[THREADING]\n1=1\n[WEFT]\nThreads=4\n"),
            "a.wif: has neither [LIFTPLAN] nor [TREADLING] that tells the shafts of its weft yarns; must be a draft in "
            "WIF, version 1.1");
  EXPECT_EQ(error_of("[THREADING]\nfirst=1\n"),
            "a.wif: [THREADING]: first = 1: must begin with a number from 1 to 100000 (line 2)");
  EXPECT_EQ(error_of("[THREADING]\n1=a\n"),
            "a.wif: [THREADING]: 1 = a: must be numbers from 1 to 100000 with commas between them (line 2)");
  EXPECT_EQ(error_of("[THREADING]\n1=1\n[LIFTPLAN]\n1=-1\n"),
            "a.wif: [LIFTPLAN]: 1 = -1: must be numbers from 1 to 100000 with commas between them (line 4)");
  EXPECT_EQ(error_of("[THREADING]\n1=1\n[LIFTPLAN]\n1=1\n[WEAVING]\nRising Shed=perhaps\n"),
            "a.wif: [WEAVING]: rising shed = perhaps: must be true or false (line 6)");
}

/// Small files that ask for much, or are told of at length.
TEST(Draft, ThatWouldFillMemoryOrScreenIsRefused) {
  const auto numbered = [](int n, const std::string& value) {
    std::string lines;
    for (int i = 1; i <= n; ++i) lines.append(std::to_string(i)).append("=").append(value).append("\n");
    return lines;
  };
  std::string all = "1";
  for (int i = 2; i <= 100'000; ++i) all.append(",").append(std::to_string(i));
  EXPECT_EQ(error_of("[THREADING]\n1=1\n[TIEUP]\n1=" + all + "\n[TREADLING]\n" + numbered(1000, "1")),
            "a.wif: [TREADLING]: more than 20000000 lifts of shafts up to this line (line 206)");
  EXPECT_EQ(error_of("[THREADING]\n1=1\n2=" + all + "\n"),
            "a.wif: [THREADING]: 100000 shafts of one warp yarn; must be at most 16 (line 3)");
  for (const std::string& wif :
       {"[THREADING]\n1=" + std::string(1'000'000, 'x') + "\n", "[THREADING]\n" + std::string(200, '\x9b') + "=1\n",
        "[THREADING]\n1=1\n[TIEUP]\n1=1\n[TREADLING]\n1=1\n[LIFTPLAN]\n1=" + all + "\n"})
    EXPECT_LT(error_of(wif).size(), 300u) << error_of(wif).substr(0, 300);
}

/// A patch of 3 weft and 5 warp yarns with these lines in its [weave].
std::string scene_with(const std::string& pattern) {
  return "[material.m]\nmodel = \"isotropic\"\nyoung_modulus = \"3 GPa\"\npoisson_ratio = 0.3\n"
         "[fiber_type.f]\nmaterial = \"m\"\ndiameter = \"20 um\"\n[weave]\n" +
         pattern +
         "\n[weave.warp]\nfiber_type = \"f\"\nyarns = 5\nfibers = 1\nelements = 5\nyarn_spacing = \"100 um\"\nmargin = "
         "\"90 "
         "um\"\n[weave.weft]\nfiber_type = \"f\"\nyarns = 3\nfibers = 1\nelements = 5\nyarn_spacing = \"100 "
         "um\"\nmargin = "
         "\"90 um\"\n";
}
WeavePattern pattern_in(const std::string& lines) { return parse_scene(scene_with(lines), "a.toml").weave->warp_above; }

TEST(PatternPicture, IsSeenFromAboveWithTheWarpRunningDown) {
  const WeavePattern expected = {{1, 0, 0, 1, 0}, {0, 1, 0, 0, 1}, {1, 0, 0, 1, 0}};
  EXPECT_EQ(pattern_in("picture = [\"X..\", \".x.\"]"), expected);
  EXPECT_EQ(pattern_in("picture = \"\"\"\n  X..\n  .X.\n\"\"\""), expected);
  EXPECT_EQ(pattern_in("matrix = [[1, 0, 0], [0, 1, 0]]"), expected);
}

TEST(PatternPicture, AndNamedPatternsBeginWhereTheyAreTold) {
  EXPECT_EQ(pattern_in("picture = [\"X..\", \".X.\"]\nfirst_warp = 3\nfirst_weft = 2"),
            (WeavePattern{{0, 0, 1, 0, 0}, {0, 1, 0, 0, 1}, {0, 0, 1, 0, 0}}));
  EXPECT_EQ(pattern_in("pattern = \"plain\"\nfirst_warp = 2")[0], (std::vector<bool>{0, 1, 0, 1, 0}));
}

std::string scene_error(const std::string& lines) {
  try {
    (void)pattern_in(lines);
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(PatternPicture, ThatIsNoneIsRefused) {
  const std::string allowed = ": must be rows of equal length of X and dots, such as [\"X.\", \".X\"] (line 9)";
  EXPECT_EQ(scene_error("picture = [\"X.\", \".X.\"]"), "a.toml: weave.picture[2] = \".X.\"" + allowed);
  EXPECT_EQ(scene_error("picture = [\"X.\", \".O\"]"), "a.toml: weave.picture[2] = \".O\"" + allowed);
  EXPECT_EQ(scene_error("picture = \"\""), "a.toml: weave.picture = \"\"" + allowed);
  EXPECT_EQ(scene_error("picture = 3"), "a.toml: weave.picture = 3" + allowed);
  EXPECT_TRUE(scene_error("picture = []").starts_with("a.toml: weave.picture = []: must be rows"));
  EXPECT_EQ(scene_error("picture = [\"X\"]\npattern = \"plain\""),
            "a.toml: weave: must have exactly one of \"pattern\", \"matrix\", \"picture\", \"pattern_file\" and "
            "\"levels\" (line 8)");
}

class SceneWithDraft : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_.path() / name) << text; }
  [[nodiscard]] std::string error(const std::string& lines) const {
    write("a.toml", scene_with(lines));
    try {
      (void)read_scene(folder_.path() / "a.toml");
      return "no error";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  test::TemporaryFolder folder_;
};

TEST_F(SceneWithDraft, FindsItBesideItselfAndKeepsItInItsText) {
  write("twill.wif", twill);
  for (const char* window : {"", "\nfirst_warp = 3\nfirst_weft = 2", "\nfirst_warp = 1001"}) {
    write("a.toml", scene_with(std::string("# ä\npattern_file  =  \"twill.wif\"  # mine") + window));
    const Scene scene = read_scene(folder_.path() / "a.toml");
    const Index from_warp = std::string(window).find("3") != std::string::npos ? 2 : 0, from_weft = from_warp / 2;
    EXPECT_EQ(scene.weave->warp_above, pattern_of(parse_draft(twill, ""), from_weft, from_warp, 3, 5));
    EXPECT_NE(scene.text.find("# twill.wif"), std::string::npos) << scene.text;
    EXPECT_NE(scene.text.find("]  # mine"), std::string::npos) << scene.text;
    EXPECT_EQ(parse_scene(scene.text, "without.toml").weave->warp_above, scene.weave->warp_above) << scene.text;
  }
  write("a.toml", replaced(scene_with(""), "[weave]\n", "[weave]\n\"pattern_file\" = '''twill.wif'''"));
  const Scene quoted = read_scene(folder_.path() / "a.toml");
  EXPECT_EQ(parse_scene(quoted.text, "without.toml").weave->warp_above, quoted.weave->warp_above) << quoted.text;
}

TEST_F(SceneWithDraft, ThatIsNotThereOrIsNoneIsRefused) {
  const std::string key = "a.toml: weave.pattern_file = \"no.wif\": ";
  EXPECT_EQ(error("pattern_file = \"no.wif\""),
            key + (folder_.path() / "no.wif").string() + ": cannot be read; must be a draft in WIF (line 9)");
  EXPECT_EQ(parse_scene(scene_with("pattern = \"plain\""), "a.toml").text, scene_with("pattern = \"plain\""));
  EXPECT_EQ(scene_error("pattern_file = \"no.wif\""),
            key + "needs a scene that is a file, in whose folder it can be looked for (line 9)");
  write("no.wif", "[THREADING]\n1=x\n");
  EXPECT_EQ(error("pattern_file = \"no.wif\""),
            key + (folder_.path() / "no.wif").string() +
                ": [THREADING]: 1 = x: must be numbers from 1 to 100000 with commas between them (line 2) (line 9)");
  std::filesystem::remove(folder_.path() / "no.wif");
  std::filesystem::create_directory(folder_.path() / "no.wif");
  EXPECT_TRUE(error("pattern_file = \"no.wif\"").ends_with("no.wif: is a folder; must be a draft in WIF (line 9)"));
  // To read a pipe is to wait for someone who writes into it.
  std::filesystem::remove(folder_.path() / "no.wif");
  ASSERT_EQ(mkfifo((folder_.path() / "no.wif").c_str(), 0600), 0);
  EXPECT_TRUE(error("pattern_file = \"no.wif\"").ends_with("no.wif: is no file; must be a draft in WIF (line 9)"));
}

}  // namespace
}  // namespace trame::micro
