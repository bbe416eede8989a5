// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.h"
#include "fusion_base/error_text.h"

namespace {

constexpr int kMany = 10000;

constexpr const char* kPoseHelp =
    "\"[x y z yaw pitch roll]\" (m, deg), or a file with a 4x4 row-major matrix";

/** The options that several subcommands share. */
class CommandLine {
 public:
  CommandLine(CLI::App& app, Arguments& args, unsigned& threads)
      : app_(app), args_(args), threads_(threads) {}

  CLI::App* add(const std::string& name, const std::string& what, const std::string& example) {
    auto* sub = app_.add_subcommand(name, what);
    sub->footer("Example:\n  " + example);
    sub->add_option(
           "--config", args_.config,
           "settings: [ProbabilisticMapMatching] and, for recordings, MRPT map definitions")
        ->type_name("FILE.ini");
    sub->add_option("--section", args_.section, "section of --config that defines the map to build")
        ->capture_default_str();
    sub->add_option("--json", args_.json, "write every figure of the run to FILE")
        ->type_name("FILE");
    sub->add_option("--threads", threads_, "number of threads; the result does not depend on it")
        ->check(CLI::PositiveNumber);
    auto* quiet = sub->add_flag("-q,--quiet", args_.quiet, "no summary and no progress");
    sub->add_flag("-v,--verbose", args_.verbose, "say what each iteration does")->excludes(quiet);
    return sub;
  }
  /** So many maps; the pose of the second in the first one's frame is sought. */
  void inputs(CLI::App* sub, const std::string& names, int least, int most) {
    sub->add_option(names, args_.maps,
                    "maps: .ot, .bt, MRPT-serialized, or a recording to build one from")
        ->required()
        ->expected(least, most);
  }
  void output(CLI::App* sub, const std::string& what) {
    sub->add_option("-o,--output", args_.output, what)->required()->type_name("FILE");
  }
  void init(CLI::App* sub) {
    auto* guess =
        sub->add_option("--init", args_.init,
                        "initial guess of B's pose in A's frame: " + std::string(kPoseHelp) +
                            "; without it, B is looked for everywhere and at any heading")
            ->type_name("POSE");
    sub->add_option(
           "--init-sigma", args_.init_sigma,
           "standard deviations of the guess's position (m) and heading (deg): B is looked "
           "for within three of them (default: as configured)")
        ->type_name("M DEG")
        ->expected(2)
        ->check(CLI::NonNegativeNumber)
        ->needs(guess);
    sub->add_flag("--full-6dof", args_.full_6dof,
                  "the maps have no common vertical: look for B at any roll and pitch, too")
        ->excludes(guess);
    sub->add_option("--pose-out", args_.pose_out,
                    "write the estimated pose to FILE, as a 4x4 matrix")
        ->type_name("FILE");
  }
  void pose(CLI::App* sub, const std::string& what) {
    sub->add_option("--pose,--init", args_.pose, what + ": " + kPoseHelp)
        ->required()
        ->type_name("POSE");
  }
  void picture(CLI::App* sub) {
    sub->add_option("--picture", args_.picture, "draw both maps from above")->type_name("FILE.png");
    sub->add_option("--scene", args_.scene,
                    "write both maps, edges, matched pairs and the fused map for SceneViewer3D")
        ->type_name("FILE.3Dscene");
  }
  void policy(CLI::App* sub) {
    sub->add_option("--policy", args_.policy, "value of voxels that both maps know")
        ->check(CLI::IsMember({"relative_entropy", "average", "stitch", "bayes"}));
  }

 private:
  CLI::App& app_;
  Arguments& args_;
  unsigned& threads_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Matches, evaluates and merges 3-D occupancy maps.");
  app.require_subcommand(1);
  app.set_version_flag("--version", "map-fusion " MAP_FUSION_VERSION);
  app.footer(
      "Exit codes: 0 done (and a match, if any, accepted); 1 failure: bad input, I/O; 2 wrong "
      "usage;\n"
      "3 the match was rejected. 'map-fusion COMMAND --help' tells more.");
  Arguments args;
  unsigned threads = 0;
  CommandLine line(app, args, threads);

  auto* fuse =
      line.add("fuse",
               "Find B's pose in A and, if it can be trusted, merge both maps; or all maps\n"
               "given, or in a rawlog of several robots' maps, as far as they can be trusted",
               "map-fusion fuse a.ot b.ot --init \"[4 1 0 30 0 0]\" -o fused.ot");
  line.inputs(fuse, "A B...", 1, kMany);
  line.output(fuse, "the fused map (.ot, .bt, or MRPT-serialized), in A's frame");
  line.init(fuse);
  line.policy(fuse);
  line.picture(fuse);
  fuse->add_flag("--force", args.force, "merge even if the match is rejected");

  auto* match = line.add("match", "Find B's pose in A and say whether it can be trusted",
                         "map-fusion match a.ot b.ot --init guess.txt --pose-out T_a_b.txt");
  line.inputs(match, "A B", 2, 2);
  line.init(match);
  line.picture(match);

  auto* evaluate = line.add("evaluate", "Say whether a given pose of B in A can be trusted",
                            "map-fusion evaluate a.ot b.ot --pose T_a_b.txt");
  line.inputs(evaluate, "A B", 2, 2);
  line.pose(evaluate, "pose of B in A's frame");
  line.picture(evaluate);

  auto* merge = line.add("merge", "Merge both maps at a given pose of B in A",
                         "map-fusion merge a.ot b.ot --pose T_a_b.txt --policy bayes -o fused.ot");
  line.inputs(merge, "A B", 2, 2);
  line.pose(merge, "pose of B in A's frame");
  line.output(merge, "the fused map (.ot, .bt, or MRPT-serialized), in A's frame");
  line.policy(merge);
  line.picture(merge);

  auto* edges = line.add("edges", "Extract the structural edge voxels of a map as a point cloud",
                         "map-fusion edges a.ot -o edges.ply");
  line.inputs(edges, "MAP", 1, 1);
  line.output(edges,
              "*.ply: a point cloud, nx ny nz is the direction of the edge; else a CEdgeVoxelMap "
              "to match with");

  auto* transform = line.add("transform", "Move a map to another frame, on that frame's grid",
                             "map-fusion transform b.ot --pose \"[1 2 0 90 0 0]\" -o moved.ot");
  line.inputs(transform, "MAP", 1, 1);
  line.pose(transform, "pose of the map's frame in the new frame");
  line.output(transform, "the moved map (.ot, .bt, or MRPT-serialized)");
  transform->add_option("--resolution", args.resolution, "voxel size, m (default: the map's)")
      ->check(CLI::PositiveNumber);

  auto* build = line.add("build", "Build a map from a recording: a .rawlog or a .simplemap",
                         "map-fusion build run.rawlog --config map.ini -o run.ot");
  line.inputs(build, "MAP", 1, 1);
  line.output(build, "the map: .ot or .bt, else MRPT-serialized (compressed if *.gz)");

  auto* pack = line.add("pack", "Record maps of several robots in one rawlog, compressed",
                        "map-fusion pack robot1.ot robot2.ot -o mission.rawlog");
  line.inputs(pack, "MAPS", 1, kMany);
  line.output(pack, "a rawlog with one CObservationLocalMap for each robot, named as its file");
  pack->add_flag("--edges-only", args.edges_only,
                 "their structural edges only: a fraction of the bytes");

  auto* info = line.add("info", "Show what a map holds", "map-fusion info a.ot");
  line.inputs(info, "MAP", 1, 1);

  try {
    app.parse(argc, argv);
    if (args.maps.size() != 2 && !(args.init + args.pose_out + args.picture + args.scene).empty())
      throw CLI::ValidationError(
          "--init, --pose-out, --picture and --scene are for two maps, A and B");
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kUsage;
  }
  args.command = app.get_subcommands().front()->get_name();

  std::unique_ptr<tbb::global_control> limit;
  if (threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  threads);
  try {
    return run(args);
  } catch (const std::bad_alloc&) {
    std::cerr << "map-fusion: out of memory\n";
  } catch (const std::exception& e) {
    std::cerr << "map-fusion: " << mrpt::fusion::messageOf(e) << "\n";
  }
  return kFailure;
}
