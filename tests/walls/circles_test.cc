#include "tests/walls/circles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class FolderCircles : public ::testing::Test {
 protected:
  FolderCircles() : root_(test::FreshFolder()) { fs::remove_all(root_); }
  void Include(const std::string& file, const std::string& included) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file, std::ios::app) << "#include \"" << included << "\"\n";
  }
  fs::path root_;
};

TEST(Circles, ThereAreNoneInThisTree) {
  EXPECT_THAT(FoldersInCircles(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST_F(FolderCircles, OneDirectionIsNone) {
  Include("engrave/sort/order.cc", "engrave/sort/beam/cone.h");
  Include("engrave/sort/order.cc", "engrave/sort/travel.h");
  Include("engrave/sort/beam/cone.h", "engrave/core/geometry.h");
  EXPECT_THAT(FoldersInCircles(root_), IsEmpty());
}

TEST_F(FolderCircles, AWayBackIsFoundThroughOtherFolders) {
  Include("engrave/sort/order.cc", "engrave/sort/beam/cone.h");
  Include("engrave/sort/beam/cone.h", "engrave/motion/planner.h");
  Include("engrave/motion/planner.h", "engrave/sort/travel.h");
  Include("services/cli/main.cc", "engrave/sort/order.h");
  EXPECT_THAT(
      FoldersInCircles(root_),
      ElementsAre("engrave/motion/planner.h: includes engrave/sort/travel.h, but "
                  "engrave/sort leads back to engrave/motion",
                  "engrave/sort/order.cc: includes engrave/sort/beam/cone.h, but "
                  "engrave/sort/beam leads back to engrave/sort",
                  "engrave/sort/beam/cone.h: includes engrave/motion/planner.h, but "
                  "engrave/motion leads back to engrave/sort/beam"));
}

}  // namespace
}  // namespace intaglio::walls
