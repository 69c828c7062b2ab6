// Programs in surroundings that a user does not choose: closed streams, full disks, other runs, signals, odd names.

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

namespace trame::test {
namespace {

namespace fs = std::filesystem;

Outcome run_in_shell(const fs::path& folder, const std::string& command) {
  return run(folder, {"sh", "-c", "exec " + command});
}

/// A small scene that runs in a second.
const std::string simulate = std::string(TRAME_SIMULATE_FIBERS) + " cantilever --threads 1 --out o ";

TEST(ClosedStreams, DoNotReachIntoTheResults) {
  for (const std::string closed : {">&-", "2>&-", "<&-", "<&- >&- 2>&-"}) {
    const TemporaryFolder folder;
    EXPECT_EQ(run_in_shell(folder.path(), simulate + closed).exit_code, 0) << closed;
    const Outcome list = run(folder.path(), {TRAME_STRAIN_POST, "o/states.h5", "--list"});
    EXPECT_EQ(list.exit_code, 0) << closed << ": " << list.err;
  }
}

TEST(ClosedStreams, DoNotReachIntoTheResultsOfStrainPost) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_in_shell(folder.path(), simulate).exit_code, 0);
  const std::string strain_post = std::string(TRAME_STRAIN_POST) + " o/states.h5 --no-report --out ";
  ASSERT_EQ(run_in_shell(folder.path(), strain_post + "open").exit_code, 0);
  ASSERT_EQ(run_in_shell(folder.path(), strain_post + "closed <&- >&- 2>&-").exit_code, 0);
  for (const auto& entry : fs::directory_iterator(folder / "open"))
    EXPECT_EQ(read_text(folder / "closed" / entry.path().filename()), read_text(entry.path())) << entry.path();
}

TEST(FullStandardOutput, DoesNotEndARun) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_in_shell(folder.path(), simulate + ">/dev/full").exit_code, 0);
  EXPECT_EQ(run(folder.path(), {TRAME_STRAIN_POST, "o/states.h5", "--list"}).exit_code, 0);
}

TEST(FullStandardOutput, OfAListIsToldInOneSentence) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_in_shell(folder.path(), simulate).exit_code, 0);
  for (const std::string list : {std::string(TRAME_STRAIN_POST) + " o/states.h5 --list",
                                 std::string(TRAME_SIMULATE_FIBERS) + " --print-schema"}) {
    const Outcome outcome = run_in_shell(folder.path(), list + " >/dev/full");
    EXPECT_EQ(outcome.exit_code, 3) << list;
    EXPECT_NE(outcome.err.find("No space left"), std::string::npos) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

/// As `| head -1` does.
TEST(ReaderOfStandardOutput, MayGoAway) {
  const TemporaryFolder folder;
  const auto unread = [&](const std::string& command) {
    return run(folder.path(), {"bash", "-c", command + " | true; exit ${PIPESTATUS[0]}"}).exit_code;
  };
  EXPECT_EQ(unread(simulate), 0);
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "o/summary.json")).at("status"), "done");
  EXPECT_EQ(unread(std::string(TRAME_STRAIN_POST) + " o/states.h5 --list"), 0);
  EXPECT_EQ(unread(std::string(TRAME_SIMULATE_FIBERS) + " --print-schema"), 0);
  EXPECT_EQ(unread(std::string(TRAME_STRAIN_POST) + " o/states.h5 --no-report"), 0);
  EXPECT_TRUE(fs::exists(folder / "o/strains/continuum.csv"));
}

/// Limits of a shell stand in for a full disk.
TEST(FullDisk, EndsARunWithWholeFilesAndOneSentence) {
  for (const int kilobytes : {40, 120, 700, 1500}) {
    const TemporaryFolder folder;
    const Outcome outcome = run(folder.path(), {"bash", "-c",
                                                "ulimit -f " + std::to_string(kilobytes) + "; exec " +
                                                    TRAME_SIMULATE_FIBERS + " plain_small --threads 1 --out o"});
    EXPECT_EQ(outcome.exit_code, 3) << kilobytes << outcome.err;
    EXPECT_EQ((outcome.out + outcome.err).find("HDF5-DIAG"), std::string::npos);
    EXPECT_LE(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_NE((outcome.out + outcome.err).find("cannot grow any further"), std::string::npos) << outcome.out;
    if (!fs::exists(folder / "o/states.h5")) continue;
    EXPECT_EQ(run(folder.path(), {TRAME_STRAIN_POST, "o/states.h5", "--list"}).exit_code, 0) << kilobytes;
    const auto summary = nlohmann::json::parse(read_text(folder / "o/summary.json"));
    EXPECT_EQ(summary.at("status"), "cannot_write");
    const std::string pvd = read_text(folder / "o/vtk/fibers.pvd");
    for (const auto& entry : fs::directory_iterator(folder / "o/vtk")) {
      EXPECT_NE(entry.path().extension(), ".part");
      EXPECT_NE(read_text(entry.path()).find("</VTKFile>"), std::string::npos) << entry.path();
      if (entry.path().extension() == ".vtp")
        EXPECT_NE(pvd.find(entry.path().filename().string()), std::string::npos) << "each whole file is listed";
    }
  }
}

TEST(OutputsThatFail, AreToldAndTheOthersWritten) {
  const TemporaryFolder folder;
  Process process(folder.path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--threads", "1", "--out", "o"});
  ASSERT_TRUE(process.wait_for_output("increment 1 ", 300));
  write_text(folder / "o/vtk", "in the way");
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.exit_code, 3);
  const auto summary = nlohmann::json::parse(read_text(folder / "o/summary.json"));
  EXPECT_EQ(summary.at("status"), "done");
  ASSERT_EQ(summary.at("failed_outputs").size(), 1U);
  EXPECT_NE(summary.at("failed_outputs")[0].get<std::string>().find("vtk/fibers.pvd"), std::string::npos);
  EXPECT_NE(outcome.out.find("Not written: vtk/fibers.pvd"), std::string::npos) << outcome.out;
  EXPECT_TRUE(fs::exists(folder / "o/curves.csv"));
}

TEST(OneWriter, AFolderInUseIsRefused) {
  const TemporaryFolder folder;
  Process first(folder.path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--threads", "1", "--out", "o"});
  ASSERT_TRUE(first.wait_for_output("increment 1 ", 300));
  fs::create_directory(folder / "second");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{TRAME_SIMULATE_FIBERS, "cantilever", "--out", "../o", "--overwrite"},
        {TRAME_SIMULATE_FIBERS, "cantilever", "--out", "../o"},
        {TRAME_STRAIN_POST, "../o/states.h5", "--out", "../o", "--overwrite"}}) {
    const Outcome outcome = run(folder / "second", command);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("is writing into it"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(run(folder / "second", {TRAME_STRAIN_POST, "../o/states.h5", "--list"}).exit_code, 0)
      << "reading is for everyone";
  EXPECT_EQ(first.wait().exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "o/summary.json")).at("scene"), "plain_small");
  EXPECT_FALSE(fs::exists(folder / "o/.trame.lock"));
}

TEST(OneWriter, AKilledRunGivesItsFolderUp) {
  for (const std::string preload : {"", TRAME_NO_FLOCK}) {
    const TemporaryFolder folder;
    Process first(folder.path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--threads", "1", "--out", "o", "--overwrite"},
                  {"LD_PRELOAD=" + preload});
    ASSERT_TRUE(first.wait_for_output("increment 1 ", 300));
    first.send(SIGKILL);
    (void)first.wait();
    EXPECT_TRUE(fs::exists(folder / "o/.trame.lock"));
    EXPECT_EQ(run(folder.path(), {TRAME_SIMULATE_FIBERS, "cantilever", "--out", "o", "--overwrite"},
                  {"LD_PRELOAD=" + preload})
                  .exit_code,
              0);
  }
}

TEST(FileSystemsWithoutLocks, DoAsWell) {
  for (const int error : {EROFS, ENOLCK, EOPNOTSUPP, ENOSYS, 524}) {
    const TemporaryFolder folder;
    const std::vector<std::string> without = {std::string("LD_PRELOAD=") + TRAME_NO_FLOCK,
                                              "FLOCK_ERRNO=" + std::to_string(error)};
    const Outcome outcome =
        run(folder.path(), {TRAME_SIMULATE_FIBERS, "cantilever", "--threads", "1", "--out", "o"}, without);
    EXPECT_EQ(outcome.exit_code, 0) << error << outcome.err;
    EXPECT_EQ(run(folder.path(), {TRAME_STRAIN_POST, "o/states.h5", "--list"}, without).exit_code, 0) << error;
  }
}

TEST(FileSystemsWithoutLocks, StillHaveOneWriterAFolder) {
  const TemporaryFolder folder;
  const std::vector<std::string> without = {std::string("LD_PRELOAD=") + TRAME_NO_FLOCK};
  Process first(folder.path(), {TRAME_SIMULATE_FIBERS, "plain_small", "--threads", "1", "--out", "o"}, without);
  ASSERT_TRUE(first.wait_for_output("increment 1 ", 300));
  fs::create_directory(folder / "second");
  EXPECT_EQ(
      run(folder / "second", {TRAME_SIMULATE_FIBERS, "cantilever", "--out", "../o", "--overwrite"}, without).exit_code,
      2);
  EXPECT_EQ(first.wait().exit_code, 0);
}

TEST(Signals, OfAClosedTerminalAndOfABatchSystemSaveTheRun) {
  for (const int signal : {SIGHUP, SIGTERM, SIGINT, SIGXCPU}) {
    const TemporaryFolder folder;
    Process process(folder.path(), {TRAME_RUN_WORKFLOW, "plain_small", "--threads", "1", "--out", "o"});
    ASSERT_TRUE(process.wait_for_output("increment 2 ", 300));
    process.send(signal);
    const Outcome outcome = process.wait();
    EXPECT_EQ(outcome.exit_code, 0) << signal << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(read_text(folder / "o/summary.json")).at("status"), "interrupted") << signal;
    EXPECT_TRUE(fs::exists(folder / "o/curves.csv"));
    EXPECT_FALSE(fs::exists(folder / "o/report.html")) << "the user wants an end";
    EXPECT_NE(outcome.out.find("strain_post o/states.h5"), std::string::npos) << outcome.out;
  }
}

TEST(Signals, ThatNohupIgnoresAreIgnored) {
  const TemporaryFolder folder;
  Process process(folder.path(), {"sh", "-c", "trap '' HUP; exec " + simulate});
  ASSERT_TRUE(process.wait_for_output("increment 1 ", 300));
  process.send(SIGHUP);
  EXPECT_EQ(process.wait().exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "o/summary.json")).at("status"), "done");
}

TEST(Names, OfFilesNeedNotBeText) {
  const TemporaryFolder folder;
  const std::string scene = "Tr\xe4ger\n.toml";
  fs::copy_file(fs::path(TRAME_DATA_DIR) / "scenes/cantilever.toml", folder / scene);
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "./" + scene, "--threads", "1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(read_text(folder / "results/Tr\xef\xbf\xbdger\xef\xbf\xbd/summary.json"));
  EXPECT_EQ(summary.at("scene"), "Tr\xef\xbf\xbdger\xef\xbf\xbd");
  EXPECT_TRUE(fs::exists(folder / "results/Tr\xef\xbf\xbdger\xef\xbf\xbd/report.html"));
}

TEST(TemporaryFiles, DoNotNeedTMPDIR) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run(folder.path(), {TRAME_RUN_WORKFLOW, "cantilever", "--threads", "1", "--out", "o"}, {"TMPDIR=/nonexistent"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const std::string report = read_text(folder / "o/report.html");
  const bool draws = std::system("xvfb-run --help > /dev/null 2>&1 && xauth version > /dev/null 2>&1") == 0;
  EXPECT_TRUE(!draws || report.find("data:image/png") != std::string::npos) << outcome.out;
}

/// `broken`: position in the middle of the file, where the states are.
void damage(const fs::path& file, std::uint64_t seed) {
  std::string bytes = read_text(file);
  for (int k = 0; k < 40; ++k) {
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    bytes[seed / 65536 % bytes.size()] ^= static_cast<char>(1 << (seed >> 60) % 8);
  }
  write_text(file, bytes);
}

TEST(DamagedStates, DoNotBringDownAnyProgram) {
  const TemporaryFolder folder;
  write_text(folder / "two.toml", read_text(fs::path(TRAME_DATA_DIR) / "scenes/cantilever.toml") +
                                      "[[stage]]\nname = \"hold\"\nincrements = 1\n");
  ASSERT_EQ(run(folder.path(), {TRAME_SIMULATE_FIBERS, "two.toml", "--out", "o"}).exit_code, 0);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    fs::copy_file(folder / "o/states.h5", folder / "bad.h5", fs::copy_options::overwrite_existing);
    damage(folder / "bad.h5", seed);
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{TRAME_SIMULATE_FIBERS, "two.toml", "--start-from", "bad.h5", "--after", "push",
                                   "--out", "on", "--overwrite"},
          {TRAME_RENDER_PATCH, "bad.h5", "--out", "picture.png"},
          {TRAME_STRAIN_POST, "bad.h5", "--list"}}) {
      const int code = run(folder.path(), command).exit_code;
      EXPECT_TRUE(code == 0 || code == 2) << command[0] << " " << seed << ": " << code;
    }
  }
}

TEST(Memory, ThatIsNotThereIsNotTaken) {
  const TemporaryFolder folder;
  std::string scene = read_text(fs::path(TRAME_DATA_DIR) / "scenes/single_yarn.toml");
  scene.replace(scene.find("elements = 36"), 13, "elements = 40000");
  scene.replace(scene.find("\nfibers = 2"), 11, "\nfibers = 1000");
  write_text(folder / "long.toml", scene);
  const Outcome outcome = run(folder.path(), {TRAME_SIMULATE_FIBERS, "long.toml", "--check"});
  EXPECT_EQ(outcome.exit_code, 2);
  for (const char* part :
       {"long: bundle[1].fibers and elements: 8e+07 of 8e+07 nodes", "at least 160 GB", "take fewer"})
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
}

TEST(Memory, WithinALimitOfTheShellEndsClearly) {
  for (const int megabytes : {200, 400, 700, 1000}) {
    const TemporaryFolder folder;
    const Outcome outcome =
        run(folder.path(), {"bash", "-c",
                            "ulimit -v " + std::to_string(1024 * megabytes) + "; exec timeout -s KILL 100 " +
                                TRAME_SIMULATE_FIBERS + " plain_small --threads 1 --out o"});
    EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 2 || outcome.exit_code == 3)
        << megabytes << " MB: " << outcome.exit_code << outcome.err;
  }
}

/// Four bundles of nine fibers, stretched.
void write_table(const fs::path& file, double stretch) {
  std::ofstream table(file);
  table << "x,y,z,fiber,yarn\n";
  for (int fiber = 0; fiber < 36; ++fiber)
    for (int node = 0; node < 5; ++node)
      table << 1e-4 * node * stretch << ',' << 2e-5 * (fiber / 3) + 1e-3 * (fiber / 9) << ',' << 2e-5 * (fiber % 3)
            << ',' << fiber << ',' << fiber / 9 << '\n';
}

TEST(Stack, OfAShellIsEnoughOrIsTold) {
  const TemporaryFolder folder;
  write_table(folder / "a.csv", 1);
  write_table(folder / "b.csv", 1.01);
  const auto limited = [&](const std::string& limit, const std::string& command) {
    return run(folder.path(), {"bash", "-c", "ulimit " + limit + "; exec " + command});
  };
  const std::string simulate = std::string(TRAME_SIMULATE_FIBERS) + " cantilever --check",
                    strains =
                        std::string(TRAME_STRAIN_POST) + " a.csv b.csv --threads 2 --no-report --overwrite --out o";
  for (const std::string& program : {simulate, strains}) {
    const Outcome outcome = limited("-s 128", program);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("ulimit -s 128: so little stack does not do; must be at least 512"), std::string::npos)
        << outcome.err;
  }
  // Threads would have 128 kB too, in which triangulations do not fit.
  for (const char* limit : {"-s 512", "-Ss 128"}) {
    const Outcome outcome = limited(limit, strains);
    EXPECT_EQ(outcome.exit_code, 0) << limit << ": " << outcome.err;
  }
}

TEST(Units, WithoutTheirDatabaseAreNoFaultOfTheScene) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run(folder.path(), {TRAME_SIMULATE_FIBERS, "cantilever", "--check"}, {"UDUNITS2_XML_PATH=/nonexistent"});
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_EQ(outcome.err.find("simulate_fibers: the unit database of UDUNITS"), 0U) << outcome.err;
}

TEST(Threads, OfTheEnvironmentAreBounded) {
  const TemporaryFolder folder;
  const Outcome outcome = run(folder.path(), {TRAME_SIMULATE_FIBERS, "cantilever"}, {"OMP_NUM_THREADS=100000"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("OMP_NUM_THREADS = 100000: must be at most 1024"), std::string::npos) << outcome.err;
}

TEST(Scene, OfAPathThatLeadsNowhereIsNotThere) {
  const TemporaryFolder folder;
  fs::create_symlink("loop.toml", folder / "loop.toml");
  for (const std::string& scene : {std::string("loop.toml"), std::string(5000, 'x'), std::string(300, 'x') + ".toml"}) {
    const Outcome outcome = run(folder.path(), {TRAME_SIMULATE_FIBERS, scene});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("there is no file"), std::string::npos) << outcome.err;
  }
}

TEST(Scene, ThatIsAFolderIsCalledSo) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "scenes");
  for (const std::string scene : {"scenes", "./scenes", "scenes/"}) {
    const Outcome outcome = run(folder.path(), {TRAME_SIMULATE_FIBERS, scene});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("is a folder"), std::string::npos) << outcome.err;
  }
}

/// Fields of a line of a CSV table.
std::ptrdiff_t count_fields(const std::string& line) {
  bool quoted = false;
  return 1 + std::ranges::count_if(line, [&](char c) {
           quoted = quoted != (c == '"');
           return c == ',' && !quoted;
         });
}

TEST(AwkwardNames, BreakNoTable) {
  const TemporaryFolder folder;
  std::string scene = R"(title = "Bundles <b>with</b> \"awkward\" names & more"
[material.m]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.3
[fiber_type.f]
material = "m"
diameter = "20 um"
)";
  for (const auto& [name, y] : {std::pair{"left, \\\"upper\\\"", 0}, {"<i>right</i>; 'lower'\\\\", 200}})
    scene += "[[bundle]]\nname = \"" + std::string(name) + "\"\nfiber_type = \"f\"\npoints = [[\"0 um\", \"" +
             std::to_string(y) + " um\", \"0 um\"], [\"300 um\", \"" + std::to_string(y) +
             " um\", \"0 um\"]]\nelements = 6\nfibers = 7\n";
  scene += R"([[body]]
name = "end, \"one\""
[[body.tie]]
fibers = "*"
end = "start"
[[body]]
name = "end <two> & more"
position = ["300 um", "0 um", "0 um"]
[[body.tie]]
fibers = "*"
end = "end"
[effects]
contact = "none"
[[stage]]
name = "pull, \"hard\" `touch pwned`"
increments = 2
[[stage.drive]]
bodies = "end <two> & more"
dof = "x"
displacement = "3 um"
)";
  write_text(folder / "names.toml", scene);
  const Outcome outcome = run(folder.path(), {TRAME_RUN_WORKFLOW, "names.toml", "--threads", "1", "--out", "o"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Outcome strains =
      run(folder.path(), {TRAME_STRAIN_POST, "o/states.h5", "--every", "--mesh", "both", "--no-report", "--out", "s"});
  ASSERT_EQ(strains.exit_code, 0) << strains.err;
  int n_tables = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "s")) {
    if (entry.path().extension() != ".csv") continue;
    ++n_tables;
    std::istringstream lines(read_text(entry.path()));
    std::string header;
    std::getline(lines, header);
    for (std::string line; std::getline(lines, line);)
      EXPECT_EQ(count_fields(line), count_fields(header)) << entry.path() << "\n" << line;
  }
  EXPECT_GE(n_tables, 6);
  EXPECT_EQ(read_text(folder / "o/report.html").find("<i>right"), std::string::npos);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) EXPECT_NE(entry.path().filename(), "pwned");
}

}  // namespace
}  // namespace trame::test
