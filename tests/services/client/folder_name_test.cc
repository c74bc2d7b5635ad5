#include "services/client/folder_name.h"

#include <gtest/gtest.h>

namespace intaglio::client {
namespace {

TEST(FolderName, HasNoBlankAndNothingThatAShellOrAFileSystemReads) {
  EXPECT_EQ(FolderNameOf("trefoil knot, by rays: no. 3"), "trefoil_knot_by_rays_no._3");
  EXPECT_EQ(FolderNameOf("a/b\\c*?\"<>|\n$(d)"), "a_b_c_d");
  EXPECT_EQ(FolderNameOf("bunny.obj"), "bunny.obj");
  EXPECT_EQ(FolderNameOf("Bj\u00f6rn \u732b"), "Bj\u00f6rn_\u732b");
}

TEST(FolderName, IsAlwaysOneOfAFolder) {
  for (const char* none : {"", " ", ":", "..", "--", "///"}) {
    EXPECT_EQ(FolderNameOf(none), "job") << none;
  }
  EXPECT_EQ(FolderNameOf("--help"), "help") << "no option";
  EXPECT_EQ(FolderNameOf("../../etc"), "etc");
}

TEST(FolderName, ALongOneIsCutBetweenCharacters) {
  std::string name = "x";
  for (int i = 0; i < 100; ++i) name += "\u00f6";
  EXPECT_EQ(FolderNameOf(name).size(), 99u) << "one byte, then two each";
}

TEST(FolderTime, HasNoColon) {
  EXPECT_EQ(FolderTimeOf("2026-11-27T05:05:21Z"), "2026-11-27T050521Z");
}

}  // namespace
}  // namespace intaglio::client
