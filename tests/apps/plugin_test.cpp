// SPDX-License-Identifier: BSD-3-Clause
#include <octomap/octomap.h>

#include <algorithm>
#include <memory>
#include <set>

#include "run.h"

namespace {

/** MRPT's own programs, with this project's library loaded into them. */
class Plugin : public AppTest {};

TEST_F(Plugin, LoadsIntoRawlogEdit) {
  const auto r = run(std::string("rawlog-edit --plugins ") + PLUGIN +
                     " -i /usr/share/mrpt/datasets/localization_demo.rawlog --info");
  EXPECT_EQ(r.code, 0);
  EXPECT_NE(r.out.find("Actions/SensoryFrame format"), std::string::npos) << r.out;
  std::string text = r.out + r.err;
  std::transform(text.begin(), text.end(), text.begin(), ::tolower);
  EXPECT_EQ(text.find("error"), std::string::npos) << text;
}

TEST_F(Plugin, MakesObservations2mapWriteOurMapOfARealSimplemap) {
  writeFile(dir_ / "map.ini",
            "[MappingApplication]\nprobOctoMap_count = 1\n"
            "[MappingApplication_probOctoMap_00_creationOpts]\nresolution = 0.2\n");
  const auto r = run(std::string("LD_PRELOAD=") + PLUGIN +
                     " observations2map map.ini"
                     " /usr/share/mrpt/datasets/localization_demo.simplemap.gz result");
  EXPECT_EQ(r.code, 0) << r.out << r.err;
  const fs::path file = dir_ / "result_mrpt__maps__CProbOctoMap_00.ot";
  ASSERT_TRUE(fs::exists(file)) << r.out << r.err;
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(file.string()));
  const auto* map = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(map, nullptr);
  EXPECT_DOUBLE_EQ(map->getResolution(), 0.2);
  std::set<float> values;
  for (auto it = map->begin_leafs(); it != map->end_leafs(); ++it) values.insert(it->getLogOdds());
  EXPECT_GT(values.size(), 2U) << "probabilities, not just occupied and free";
}

}  // namespace
