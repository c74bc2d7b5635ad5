#include "services/console/submit/job_choices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "materials_db/material_store.h"
#include "services/platform/command_line/supplied_files.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

class JobChoicesTest : public testing::Test {
 protected:
  JobChoicesTest() {
    setenv(command_line::kSuppliedVariable, INTAGLIO_SOURCE_DIR "/deploy", 1);
    fs::copy_file(supplied_ / "polar.textproto", folder_ / "own.textproto");
    std::ofstream(folder_ / "damaged.textproto") << "x {";
  }
  ~JobChoicesTest() override { unsetenv(command_line::kSuppliedVariable); }

  const fs::path supplied_ = fs::canonical(INTAGLIO_SOURCE_DIR "/deploy/machines");
  const fs::path folder_ = test::FreshFolder();
  const std::string materials_ = (folder_ / "materials.db").string();
};

TEST_F(JobChoicesTest, HaveTheMachinesOfTheShopFirstAndEachOnce) {
  const auto choices = ListJobChoices({{"one", supplied_ / "galvo-glass.textproto"},
                                       {"two", folder_ / "own.textproto"},
                                       {"three", supplied_ / "galvo-glass.textproto"},
                                       {"four", folder_ / "damaged.textproto"},
                                       {"five", ""}},
                                      materials_);
  ASSERT_TRUE(choices) << choices.error().message;
  std::map<std::string, const MachineChoice*> by_file;
  for (int i = 0; i < choices->machines_size(); ++i) {
    const MachineChoice& machine = choices->machines(i);
    EXPECT_EQ(machine.cells().empty(), i >= 2) << machine.machine_file();
    EXPECT_TRUE(by_file.emplace(machine.machine_file(), &machine).second);
  }
  const MachineChoice& head = *by_file.at("galvo-glass");
  EXPECT_THAT(head.cells(), ElementsAre("one", "three"));
  EXPECT_EQ(head.makes(), "points");
  EXPECT_EQ(head.kinematics(), "head_over_block");
  EXPECT_EQ(head.travel_mm().x(), 70);
  EXPECT_EQ(head.max_rate_hz(), 4000);
  const MachineChoice& own = *by_file.at(folder_ / "own.textproto");
  EXPECT_EQ(own.kinematics(), "polar");
  EXPECT_FALSE(by_file.contains("polar")) << "the shop has one of this name";
  EXPECT_EQ(by_file.at("mill")->makes(), "courses");
  EXPECT_EQ(by_file.at("galvo-web")->makes(), "marks");
  EXPECT_EQ(by_file.at("els-03")->makes(), "points");
}

TEST_F(JobChoicesTest, HaveTheGlassesWithTheirLight) {
  auto store = materials_db::MaterialStore::Open(materials_);
  ASSERT_TRUE(store);
  auto dark = store->Find("N-BK7").value();
  dark.name = "dark";
  dark.transmittance = {{0.532, 0.9, 10}};
  ASSERT_TRUE(store->Add(dark));
  const auto choices = ListJobChoices({}, materials_);
  ASSERT_TRUE(choices) << choices.error().message;
  std::map<std::string, const GlassChoice*> glasses;
  for (const GlassChoice& glass : choices->glasses()) glasses[glass.name()] = &glass;
  ASSERT_TRUE(glasses.contains("N-BK7"));
  EXPECT_NEAR(glasses["N-BK7"]->index(), 1.519473, 1e-6) << "SCHOTT's Sellmeier formula";
  // 0.994 at 500 nm and 0.996 at 546 nm, of 25 mm each; four times as long a way.
  EXPECT_NEAR(glasses["N-BK7"]->transmitted_ratio(), 0.9817, 1e-4);
  EXPECT_EQ(glasses["fused-silica"]->transmitted_ratio(), 0) << "it is not in the base";
  EXPECT_NEAR(glasses["dark"]->transmitted_ratio(), 0.348678, 1e-6) << "0.9^10";
}

}  // namespace
}  // namespace intaglio::console
