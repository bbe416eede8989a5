// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The program map-fusion: runs one subcommand. */

#include <tbb/global_control.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "arguments.h"
#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "run_context.h"
#include "signals.h"

namespace map_fusion {

namespace {

ExitCode run(const Arguments& args) {
  static const std::map<std::string, Command> commands = {
      {"fuse", runFuse},   {"match", runMatch}, {"evaluate", runEvaluate},
      {"merge", runMerge}, {"edges", runEdges}, {"transform", runTransform},
      {"build", runBuild}, {"pack", runPack},   {"info", runInfo},
      {"view", runView},   {"join", runJoin},   {"slice", runSlice}};
  RunContext context(args);
  const bool accepted = commands.at(args.command)(context);
  context.finish();
  const ExitCode code = accepted ? kDone : kRejected;
  if (!std::cout.flush()) throw std::runtime_error("standard output: cannot be written");
  // To free maps of millions of nodes takes seconds. The system frees the whole process at once.
  std::_Exit(code);
}

}  // namespace

}  // namespace map_fusion

int main(int argc, char** argv) {
  using namespace map_fusion;
  try {
    handleSignals();
    handleLackOfMemory();
    Arguments args;
    if (const auto code = parseArguments(argc, argv, args)) return *code;
    std::unique_ptr<tbb::global_control> limit;
    if (args.threads > 0)
      limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    args.threads);
    return run(args);
  } catch (const std::bad_alloc&) {
    std::cerr << "map-fusion: out of memory\n";
  } catch (const UsageError& e) {
    std::cerr << "map-fusion: " << mrpt::fusion::messageOf(e) << "\n";
    return kUsage;
  } catch (const std::exception& e) {
    std::cerr << "map-fusion: " << mrpt::fusion::messageOf(e) << "\n";
  }
  return kFailure;
}
