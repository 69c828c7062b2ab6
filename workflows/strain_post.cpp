/// \file
/// strain_post: strains of yarns between two states of their fibers, for ParaView and as a table.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <new>
#include <numeric>
#include <regex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "meso/analyse.h"
#include "micro/core/error.h"
#include "workflows/fiber_nodes.h"
#include "workflows/file_probe.h"
#include "workflows/state_list.h"
#include "workflows/strain_tables.h"

namespace {

namespace fs = std::filesystem;
using trame::Index;
using trame::InputError;
using trame::meso::AnalyseOptions;
using trame::meso::FiberStates;
using trame::meso::MeshKind;
using namespace trame::workflows;

struct Arguments {
  std::vector<fs::path> states;
  std::string from = "0", to = "last", mesh = "delaunay";
  AnalyseOptions analyse;
  fs::path out;
  bool list = false, every = false, overwrite = false;
};

constexpr std::pair<const char*, MeshKind> mesh_kinds[] = {{"delaunay", MeshKind::delaunay},
                                                           {"swept", MeshKind::swept}};

void define(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", TRAME_VERSION);
  app.footer(
      "Writes yarns.pvd (ParaView) and strains.csv; with --mesh both, a folder of them for each mesh. Strains are\n"
      "Green-Lagrange, from state A to state B, in the yarn frame of A: axial along the fibers, vertical along z made\n"
      "normal to it, horizontal across. Meshes belong to the first state. Layouts of files: micro/io/README.md.\n"
      "Exit codes: 0 done, 2 bad input.");
  app.add_option("states", arguments.states,
                 "State file of a run (HDF5); or fiber nodes from elsewhere: one HDF5 file, or one .vtp file per state")
      ->required();
  const std::string meaning = ": number of an increment, name of a stage (its end), or \"last\"";
  app.add_option("--from", arguments.from, "State A" + meaning)->capture_default_str();
  app.add_option("--to", arguments.to, "State B" + meaning)->capture_default_str();
  app.add_flag("--every", arguments.every, "All increments from A to B as a time series, not B alone");
  app.add_option("--yarns", arguments.analyse.yarns, "Names of yarns, with * and ? as wildcards; default: all");
  app.add_option("--mesh", arguments.mesh, "How yarns are meshed")
      ->check(CLI::IsMember({"delaunay", "swept", "both"}))
      ->type_name("delaunay|swept|both")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "Folder for the results; default: strains, beside the state file");
  app.add_option("--threads", arguments.analyse.n_threads, "Number of threads; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("--overwrite", arguments.overwrite, "Write into a folder that is not empty");
  app.add_flag("--list", arguments.list, "List the states, their loads and the yarns, and end");
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

/// States B: the last one, or all from A to it.
std::vector<Index> states_to_compare(Index a, Index b, bool every) {
  if (!every) return {b};
  if (a > b) throw InputError(fmt::format("--every: state A ({}) is after state B ({})", a, b));
  std::vector<Index> all(b - a + 1);
  std::iota(all.begin(), all.end(), a);
  return all;
}

std::vector<MeshedStrains> analyse_all(const FiberStates& states, const Arguments& arguments) {
  const bool both = arguments.mesh == "both";
  std::vector<MeshedStrains> results;
  for (const auto& [name, kind] : mesh_kinds) {
    if (!both && arguments.mesh != name) continue;
    const fs::path folder = both ? arguments.out / name : arguments.out;
    AnalyseOptions options = arguments.analyse;
    options.mesh.kind = kind;
    options.vtk_folder = folder;
    results.push_back({name, trame::meso::analyse(states, options)});
    write_strains_csv(folder / "strains.csv", states.header().mesh.yarns, results.back().analysis);
  }
  return results;
}

void run(Arguments& arguments) {
  probe(arguments.states[0].string(), [&] { (void)open_states(arguments.states)->read(0); });
  const auto opened = open_states(arguments.states);
  const FiberStates& states = *opened;
  if (states.n_increments() == 0)
    throw InputError(fmt::format("{}: holds no increment yet", arguments.states[0].string()));
  if (arguments.list) return print_states(states);
  const Index a = find_state(states, "--from", arguments.from), b = find_state(states, "--to", arguments.to);
  arguments.analyse.from = a;
  arguments.analyse.to = states_to_compare(a, b, arguments.every);
  if (arguments.out.empty()) arguments.out = fs::absolute(arguments.states[0]).parent_path() / "strains";
  check_out(arguments.out, arguments.overwrite);
  // What is wrong with the choice is said before anything is removed.
  (void)trame::meso::choose_yarns(states.header().mesh.yarns, arguments.analyse.yarns);
  for (const fs::path& folder : {arguments.out, arguments.out / "delaunay", arguments.out / "swept"})
    remove_earlier_results(folder);
  const std::vector<MeshedStrains> results = analyse_all(states, arguments);
  fmt::print("Strains from increment {} to {}:\n", a, b);
  print_strains(states.header().mesh.yarns, results, b);
  for (const MeshedStrains& result : results)
    fmt::print("Results: {} (ParaView: open, Apply, colour by E_axial)\n         {}\n", result.analysis.pvd.string(),
               (result.analysis.pvd.parent_path() / "strains.csv").string());
}

std::string too_large(const Arguments& arguments) {
  return fmt::format("{}: there is not enough memory for what it holds", arguments.states[0].string());
}

int fail(const std::string& message) {
  fmt::print(stderr, "strain_post: {}\n", message);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Strains of the yarns of a fabric between two states of its fibers.");
  Arguments arguments;
  define(app, arguments);
  try {
    app.parse(argc, argv);
    run(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    return fail(error.what());
  } catch (const fs::filesystem_error& error) {
    return fail(error.what());
  } catch (const std::bad_alloc&) {
    return fail(too_large(arguments));
  } catch (const std::length_error&) {  // the same, where the size is beyond all measure
    return fail(too_large(arguments));
  }
  return 0;
}
