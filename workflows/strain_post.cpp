/// \file
/// strain_post: strains of yarns between two saved states of a run, for ParaView and as a table.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <vector>

#include "meso/analyse.h"
#include "micro/core/error.h"
#include "micro/io/snapshot.h"
#include "workflows/saved_state.h"

namespace {

namespace fs = std::filesystem;
using trame::Index;
using trame::InputError;
using trame::meso::AnalyseOptions;
using trame::meso::Analysis;
using trame::meso::MeshKind;
using trame::meso::MeshStatus;
using trame::micro::Increment;
using trame::micro::SnapshotReader;
using trame::workflows::find_state;

struct Arguments {
  fs::path states;
  std::string from = "0", to = "last", mesh = "delaunay";
  AnalyseOptions analyse;
  fs::path out;
  bool list = false, every = false, overwrite = false;
};

void define(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", TRAME_VERSION);
  app.footer(
      "Writes yarns.pvd (ParaView) and strains.csv. Strains are Green-Lagrange, from state A to state B, in the yarn "
      "frame of A:\n"
      "axial along the fibers, vertical along z made normal to it, horizontal across.\n"
      "Exit codes: 0 done, 2 bad input.");
  app.add_option("states", arguments.states, "State file of a run (HDF5)")->required();
  const std::string meaning = ": number of an increment, name of a stage (its end), or \"last\"";
  app.add_option("--from", arguments.from, "State A" + meaning)->capture_default_str();
  app.add_option("--to", arguments.to, "State B" + meaning)->capture_default_str();
  app.add_flag("--every", arguments.every, "All increments from A to B as a time series, not B alone");
  app.add_option("--yarns", arguments.analyse.yarns, "Names of yarns, with * and ? as wildcards; default: all");
  app.add_option("--mesh", arguments.mesh, "How yarns are meshed")
      ->check(CLI::IsMember({"delaunay", "swept"}))
      ->type_name("delaunay|swept")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "Folder for the results; default: strains, beside the state file");
  app.add_option("--threads", arguments.analyse.n_threads, "Number of threads; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("--overwrite", arguments.overwrite, "Write into a folder that is not empty");
  app.add_flag("--list", arguments.list, "List the saved states and the yarns, and end");
}

void list(const SnapshotReader& states) {
  fmt::print("{:>9}  {:<20} {:>6}  {:>8}\n", "increment", "stage", "time", "contacts");
  for (Index i = 0; i < states.n_increments(); ++i) {
    const Increment increment = states.read(i);
    fmt::print("{:>9}  {:<20} {:>6.3f}  {:>8}\n", i, increment.stage, increment.stage_time,
               increment.contacts.gap.size());
  }
  fmt::print("\n{:<16} {:>6}\n", "yarn", "fibers");
  for (const auto& yarn : states.header().mesh.yarns) fmt::print("{:<16} {:>6}\n", yarn.name, yarn.n_fibers);
}

/// Throws where results may not go to `out`; leaves it as it is.
void check_out(const fs::path& out, bool overwrite) {
  if (!fs::exists(out)) return;
  if (!fs::is_directory(out)) throw InputError(fmt::format("--out {}: not a folder", out.string()));
  if (!fs::is_empty(out) && !overwrite)
    throw InputError(
        fmt::format("--out {}: the folder is not empty; choose another one, or --overwrite", out.string()));
}

void remove_earlier_results(const fs::path& out) {
  if (!fs::exists(out)) return;
  const std::regex ours(R"(yarns(\.pvd|_[0-9]+\.vtu)|strains\.csv)");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(out))
    if (std::regex_match(entry.path().filename().string(), ours)) files.push_back(entry.path());
  for (const fs::path& file : files) fs::remove(file);
}

void write_csv(const fs::path& file, const SnapshotReader& states, const Analysis& analysis) {
  std::ofstream out(file);
  out << "increment,yarn,n_tets,n_flagged";
  for (const char* name : {"E_axial", "E_horizontal", "E_vertical", "gamma_max", "det_F"})
    out << fmt::format(",{0}_mean,{0}_deviation,{0}_min,{0}_max", name);
  out << '\n';
  for (const auto& row : analysis.strains) {
    out << fmt::format("{},{},{},{}", row.increment, states.header().mesh.yarns[row.yarn].name, row.n_tets,
                       row.n_flagged);
    for (const auto& s : {row.axial, row.horizontal, row.vertical, row.gamma_max, row.det_F})
      out << fmt::format(",{:.9g},{:.9g},{:.9g},{:.9g}", s.mean, s.deviation, s.min, s.max);
    out << '\n';
  }
  if (!out.flush()) throw InputError(fmt::format("{}: cannot be written", file.string()));
}

void print_table(const SnapshotReader& states, const Analysis& analysis, Index last) {
  const auto& yarns = states.header().mesh.yarns;
  for (const auto& mesh : analysis.meshes) {
    if (mesh.status != MeshStatus::ok) fmt::print("{}: no mesh: {}\n", yarns[mesh.yarn].name, text(mesh.status));
    if (mesh.quality.n_slivers + mesh.quality.n_unused_fibers > 0)
      fmt::print("{}: {} slivers left in the mesh, {} fibers unused\n", yarns[mesh.yarn].name, mesh.quality.n_slivers,
                 mesh.quality.n_unused_fibers);
  }
  fmt::print("{:<12} {:>8} {:>8}  {:>34}  {:>10} {:>10} {:>10}\n", "yarn", "tets", "flagged",
             "E_axial mean (min … max)", "E_horiz.", "E_vert.", "gamma_max");
  for (const auto& row : analysis.strains)
    if (row.increment == last)
      fmt::print("{:<12} {:>8} {:>8}  {:>10.3e} ({:>9.2e} … {:>9.2e})  {:>10.3e} {:>10.3e} {:>10.3e}\n",
                 yarns[row.yarn].name, row.n_tets, row.n_flagged, row.axial.mean, row.axial.min, row.axial.max,
                 row.horizontal.mean, row.vertical.mean, row.gamma_max.mean);
}

void run(Arguments& arguments) {
  const SnapshotReader states(arguments.states);
  if (states.n_increments() == 0)
    throw InputError(fmt::format("{}: holds no increment yet", arguments.states.string()));
  if (arguments.list) return list(states);
  const Index a = find_state(states, "--from", arguments.from), b = find_state(states, "--to", arguments.to);
  arguments.analyse.mesh.kind = arguments.mesh == "swept" ? MeshKind::swept : MeshKind::delaunay;
  arguments.analyse.from = a;
  arguments.analyse.to = {b};
  if (arguments.every) {
    if (a > b) throw InputError(fmt::format("--every: state A ({}) is after state B ({})", a, b));
    arguments.analyse.to.clear();
    for (Index i = a; i <= b; ++i) arguments.analyse.to.push_back(i);
  }
  if (arguments.out.empty()) arguments.out = fs::absolute(arguments.states).parent_path() / "strains";
  check_out(arguments.out, arguments.overwrite);
  (void)trame::meso::choose_yarns(states.header().mesh.yarns,
                                  arguments.analyse.yarns);  // throws before anything is removed
  remove_earlier_results(arguments.out);
  arguments.analyse.vtk_folder = arguments.out;
  const Analysis analysis = trame::meso::analyse(states, arguments.analyse);
  write_csv(arguments.out / "strains.csv", states, analysis);
  fmt::print("Strains from increment {} to {}:\n", a, b);
  print_table(states, analysis, b);
  fmt::print("Results: {} (ParaView: open, Apply, colour by E_axial)\n         {}\n", analysis.pvd.string(),
             (arguments.out / "strains.csv").string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Strains of the yarns of a fabric between two saved states.");
  Arguments arguments;
  define(app, arguments);
  try {
    app.parse(argc, argv);
    run(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    fmt::print(stderr, "strain_post: {}\n", error.what());
    return 2;
  }
  return 0;
}
