#include "engrave/contour/files/project_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/test_folder.h"

namespace intaglio::contour {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Published(const std::string& name) {
  return intaglio::test::ContentOf(std::filesystem::path(INTAGLIO_SOURCE_DIR) /
                                   "tests/data/contours" / name);
}

std::string WithoutBlanks(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n' || c == '\r'; });
  return text;
}

std::string ErrorOf(const std::string& text, const ProjectLimits& limits = {}) {
  const auto project = ReadProject(text, "a.xml", limits);
  return project ? "no error" : project.error().message;
}

std::string WithElements(const std::string& elements) {
  return "<project><settings/><nodes>\n<node>0|1|2</node><node>1|3|4</node>\n</nodes>\n"
         "<group><elements>" +
         elements + "</elements><groups></groups></group></project>";
}

// Siwiec 2016, ch. 5.3, as printed: a group, whose nodes the source does not print.
TEST(ProjectFile, ReadsAndWritesThePublishedFragment) {
  const std::string printed = Published("project_fragment.xml");
  const std::string nodes = "<node>0|1|2</node><node>1|3|4</node>";
  const auto project = ReadProject(
      "<project><settings/><nodes>" + nodes + "</nodes>" + printed + "</project>",
      "fragment");
  ASSERT_TRUE(project) << project.error().message;
  const ProjectGroup& group = project->root;
  ASSERT_EQ(group.groups.size(), 3U);
  EXPECT_EQ(group.groups[0].elements[1],
            (ProjectElement{ProjectElementKind::kHole, 1, 0, 0}));
  EXPECT_EQ(group.groups[2].elements[0],
            (ProjectElement{ProjectElementKind::kTrack, 0.4, 0, 1}));
  EXPECT_THAT(WithoutBlanks(WriteProject(*project)), HasSubstr(WithoutBlanks(printed)));
}

TEST(ProjectFile, GivesTheBoardOfAWholeProject) {
  const auto project = ReadProject(Published("project_two_pads.xml"), "two");
  ASSERT_TRUE(project) << project.error().message;
  const Board board = BoardOf(*project);
  ASSERT_EQ(board.elements.size(), 3U);
  ASSERT_EQ(board.holes.size(), 2U);
  EXPECT_EQ(std::get<Square>(board.elements[1].shape).center_mm, Vec2(7.62, 2.54));
  EXPECT_EQ(std::get<Track>(board.elements[2].shape).width_mm, 0.4);
  EXPECT_EQ(board.holes[1].center_mm, Vec2(7.62, 2.54));
}

/// Any groups, of numbers with six decimals.
ProjectGroup RandomGroup(std::mt19937& random, int depth, std::uint32_t nodes) {
  ProjectGroup group;
  for (auto count = random() % 4; count-- > 0;) {
    const auto kind = static_cast<ProjectElementKind>("1234h"[random() % 5]);
    ProjectElement e{kind, static_cast<double>(random() % 5'000'000) / 1e6,
                     static_cast<std::uint32_t>(random() % nodes), 0};
    if (kind == ProjectElementKind::kTrack)
      e.end_node = static_cast<std::uint32_t>(random() % nodes);
    group.elements.push_back(e);
  }
  for (auto count = depth > 0 ? random() % 3 : 0; count-- > 0;)
    group.groups.push_back(RandomGroup(random, depth - 1, nodes));
  return group;
}

TEST(ProjectFile, KeepsEverythingThroughWritingAndReading) {
  std::mt19937 random(2);
  for (int k = 0; k < 50; ++k) {
    Project project;
    project.settings = {{"zoom", "1.5"}, {"name", "a < b & \"c\""}, {"empty", ""}};
    for (std::uint32_t id = 0; id < 20; ++id) {
      const double x = (static_cast<double>(random() % 2'000'000) - 1e6) / 1e4;
      project.nodes.push_back({3 * id, Vec2(x, -x / 2)});
    }
    for (ProjectNode& node : project.nodes)
      node.place_mm = (node.place_mm * 1e6).array().round() / 1e6;
    project.root = RandomGroup(random, 5, 1);
    const std::string text = WriteProject(project);
    const auto again = ReadProject(text, "again");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*again, project);
    EXPECT_EQ(WriteProject(*again), text);
  }
}

TEST(ProjectFile, NestsAThousandGroupsDeepAndNoDeeper) {
  Project project;
  ProjectGroup* group = &project.root;
  for (int depth = 1; depth < 1000; ++depth) {
    group->groups.emplace_back();
    group = &group->groups.back();
  }
  const auto deep = ReadProject(WriteProject(project), "deep");
  ASSERT_TRUE(deep) << deep.error().message;
  EXPECT_EQ(*deep, project);
  group->groups.emplace_back();
  EXPECT_THAT(ErrorOf(WriteProject(project)), HasSubstr("nest deeper than 1000"));
}

TEST(ProjectFile, RefusesWhatItWouldLose) {
  EXPECT_THAT(ErrorOf(WithElements("<element>1|1|7</element>")),
              AllOf(HasSubstr("a.xml: line 4:"), HasSubstr("node 7, which does not")));
  EXPECT_THAT(ErrorOf(WithElements("<element>4|1|0</element>")), HasSubstr("4|0.4|0|1"));
  EXPECT_THAT(ErrorOf(WithElements("<element>5|1|0</element>")),
              HasSubstr("expected an"));
  EXPECT_THAT(ErrorOf(WithElements("<element>1|x|0</element>")), HasSubstr("number"));
  EXPECT_THAT(ErrorOf(WithElements("<element>1|-1|0</element>")), HasSubstr("number"));
  EXPECT_THAT(ErrorOf(WithElements("<element>1|1e9|0</element>")), HasSubstr("number"));
  EXPECT_THAT(ErrorOf(WithElements("<pad>1|1|0</pad>")), HasSubstr("<pad> is not known"));
  EXPECT_THAT(ErrorOf("<project><nodes><node>0|1</node></nodes><group/></project>"),
              HasSubstr("expected a node"));
  EXPECT_THAT(ErrorOf("<project><nodes><node>0|1|1</node><node>0|1|1</node></nodes>"
                      "<group/></project>"),
              HasSubstr("node 0 exists already"));
  EXPECT_THAT(ErrorOf("<project></project>"), HasSubstr("one <group>"));
  EXPECT_THAT(ErrorOf("<group></group>"), HasSubstr("expected <project>"));
  EXPECT_THAT(ErrorOf("<project>"), HasSubstr("not XML"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("not XML"));
  ProjectLimits limits;
  limits.max_elements = 1;
  EXPECT_THAT(
      ErrorOf(WithElements("<element>1|1|0</element><element>1|1|0</element>"), limits),
      HasSubstr("more than 1 elements"));
  limits.max_file_bytes = 10;
  EXPECT_THAT(ErrorOf(WithElements(""), limits), HasSubstr("the limit is 10"));
}

}  // namespace
}  // namespace intaglio::contour
