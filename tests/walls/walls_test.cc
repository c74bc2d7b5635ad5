#include "tests/walls/walls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class MadeUpTree : public ::testing::Test {
 protected:
  MadeUpTree() : root_(test::FreshFolder()) { fs::remove_all(root_); }
  void Write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  fs::path root_;
};

TEST(Walls, HoldInThisTree) { EXPECT_THAT(Violations(INTAGLIO_SOURCE_DIR), IsEmpty()); }

TEST_F(MadeUpTree, GoodTreeHasNoViolation) {
  Write("engrave/sort/a.h", "#pragma once\n#include \"engrave/core/geometry.h\"\n");
  Write("services/cli/a.cc",
        "#include \"services/platform/host/process/b.h\"\n#include <thread>\n");
  EXPECT_THAT(Violations(root_), IsEmpty());
}

TEST_F(MadeUpTree, RoomsKnowWhatLiesBelowThem) {
  Write("services/drivers/grbl/marks/a.cc",
        "#include \"services/drivers/grbl/grbl_line.h\"\n"
        "#include \"services/drivers/lockstep/piece_queue.h\"\n");
  Write("services/drivers/lockstep/a.cc",
        "#include \"services/drivers/interface/motion_driver.h\"\n");
  Write("services/job/teach/a.cc", "#include \"services/job/fields/shapes.h\"\n");
  Write("services/drivers/tables.cc", "#include \"services/drivers/grbl/grbl_line.h\"\n");
  EXPECT_THAT(Violations(root_), IsEmpty());
}

TEST_F(MadeUpTree, EveryWallIsSeenWhenItIsCrossed) {
  const std::pair<const char*, const char*> crossings[] = {
      {"engrave/core/a.cc", "#include \"engrave/mesh/mesh.h\"\n"},
      {"engrave/discretize/spacing/a.cc",
       "#include \"engrave/discretize/mesh/rays.h\"\n"},
      {"engrave/discretize/mesh/a.cc",
       "#include \"engrave/discretize/picture/relief.h\"\n"},
      {"engrave/discretize/picture/a.cc", "#include \"engrave/discretize/cloud.h\"\n"},
      {"engrave/motion/a.cc", "#include \"engrave/sort/order.h\"\n"},
      {"engrave/machine/a.cc", "#include \"engrave/motion/planner.h\"\n"},
      {"engrave/optics/a.cc", "#include \"services/platform/bus/bus.h\"\n"},
      {"engrave/mesh/a.cc", "#include <spdlog/spdlog.h>\n"},
      {"engrave/mesh/b.cc", "#include <thread>\n"},
      {"engrave/mesh/c.cc", "#include <google/protobuf/message.h>\n"},
      {"materials_db/a.cc", "#include \"services/job/convert/options.h\"\n"},
      {"proto/a.cc", "#include \"engrave/core/result.h\"\n"},
      {"engrave/discretize/a.cc", "#include \"engrave/discretize/mesh/rays.h\"\n"},
      {"services/job/methods/a.cc", "#include \"services/job/convert/options.h\"\n"},
      {"services/job/a.cc", "#include \"services/history/job_names.h\"\n"},
      {"services/platform/host/process/a.cc",
       "#include \"services/job/convert/options.h\"\n"},
      {"services/platform/host/process/b.cc",
       "#include \"services/platform/host/stage/stage_task.h\"\n"},
      {"services/drivers/grbl/a.cc", "#include \"services/drivers/isel/isel_line.h\"\n"},
      {"services/drivers/lockstep/a.cc",
       "#include \"services/drivers/mark_drivers.h\"\n"},
      {"services/drivers/interface/a.cc",
       "#include \"services/drivers/lockstep/piece_queue.h\"\n"},
      {"services/job/machine/a.cc", "#include \"services/job/convert/options.h\"\n"},
      {"services/job/checks/a.cc", "#include \"services/job/plan/ordering.h\"\n"},
      {"services/job/b.cc",
       "#include \"services/platform/host/process/service_host.h\"\n"},
      {"services/client/a.cc", "#include \"services/cli/job/job_options.h\"\n"},
      {"services/sorter/c.cc", "#include \"services/client/job_client.h\"\n"},
      {"services/cli/a.cc", "#include \"services/sorter/sort_job.h\"\n"},
      {"services/cli/b.cc", "#include <CLI/App.hpp>\n"},
      {"services/console/a.cc", "#include <boost/beast.hpp>\n"},
      {"services/console/c.cc", "#include <curl/curl.h>\n"},
      {"services/console/webhooks/a.cc", "#include \"services/console/shop_desk.h\"\n"},
      {"services/console/b.cc", "#include \"services/cli/terminal/complain.h\"\n"},
      {"services/platform/web/a.cc", "#include \"services/platform/bus/bus.h\"\n"},
      {"services/sorter/a.cc", "#include <dds/dds.h>\n"},
      {"services/sorter/b.cc", "int x = dds_write(1, 2);\n"},
      {"services/virtual_engraver/a.cc", "#include \"engrave/optics/focus.h\"\n"},
      {"services/platform/host/process/a.h", "int once;\n"}};
  for (const auto& [path, text] : crossings) {
    fs::remove_all(root_);
    Write(path, text);
    EXPECT_THAT(Violations(root_), ElementsAre(HasSubstr(path))) << text;
  }
}

TEST_F(MadeUpTree, BuildFileHasOneSourceALineSortedAndShortLines) {
  Write("engrave/core/CMakeLists.txt",
        "# a.cc b.cc\nintaglio_library(a SOURCES a.cc DEPS b)\n" + std::string(100, 'x'));
  EXPECT_THAT(Violations(root_), IsEmpty());
  Write("engrave/core/CMakeLists.txt", "intaglio_library(a\n  SOURCES a.cc b.cc)\n");
  EXPECT_THAT(Violations(root_), ElementsAre(HasSubstr("two sources in a line")));
  Write("engrave/core/CMakeLists.txt",
        "intaglio_library(a\n  SOURCES\n    b.cc\n    a.cc)\n");
  EXPECT_THAT(Violations(root_), ElementsAre(HasSubstr("b.cc stands before a.cc")));
  Write("engrave/core/CMakeLists.txt", std::string(101, 'x'));
  EXPECT_THAT(Violations(root_), ElementsAre(HasSubstr("a longer line")));
}

TEST_F(MadeUpTree, LongFileIsSeen) {
  std::string text;
  for (int i = 0; i < 401; ++i) text += "int a;\n";
  Write("engrave/core/long.cc", text);
  EXPECT_THAT(Violations(root_), ElementsAre(HasSubstr("401 lines")));
}

TEST_F(MadeUpTree, FolderOfFortyFilesIsSeen) {
  for (int i = 0; i < 39; ++i) Write("engrave/core/a" + std::to_string(i) + ".cc", "");
  EXPECT_THAT(Violations(root_), IsEmpty());
  Write("engrave/core/b.h", "#pragma once\n");
  EXPECT_THAT(Violations(root_),
              ElementsAre(HasSubstr("engrave/core: has 40 sources and headers")));
}

}  // namespace
}  // namespace intaglio::walls
