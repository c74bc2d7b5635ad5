#include "services/job/fields/field_path.h"

#include <gmock/gmock.h>

#include "proto/job.pb.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class FieldPath : public testing::Test {
 protected:
  FieldPath() {
    job_.add_models()->set_file("a.stl");
    job_.mutable_discretization()->mutable_sections()->set_layer_distance_mm(0.2);
  }
  void Sets(const std::string& path, const std::string& text) {
    const auto set = SetField(job_, path, text);
    EXPECT_TRUE(set.has_value()) << set.error().message;
    EXPECT_TRUE(IsSet(job_, path)) << path;
  }
  std::string Refuses(const std::string& path, const std::string& text) {
    const auto set = SetField(job_, path, text);
    EXPECT_FALSE(set.has_value()) << path;
    if (set) return {};
    EXPECT_THAT(set.error().message, testing::StartsWith(path + ": "));
    return set.error().message;
  }
  JobSpec job_;
};

TEST_F(FieldPath, SetsEveryKindOfField) {
  Sets("name", "cup, of Anna");
  Sets("block.margin_mm", "5");
  Sets("block.clip", "true");
  Sets("block.size_mm", "50, 60 70.5");
  Sets("models[0].placement.move_mm.y", "-1.5e-1");
  Sets("models[0].placement.pivot", "block");
  Sets("discretization.sections.axis", "AXIS_X");
  Sets("motion.profile", "time-optimal");
  Sets("laser.channels", "1 3");
  Sets("priority", "-7");
  Sets("seed", "18446744073709551615");
  Sets("ordering.kdz", "true");
  EXPECT_EQ(job_.name(), "cup, of Anna");
  EXPECT_EQ(job_.block().margin_mm(), 5);
  EXPECT_TRUE(job_.block().clip());
  EXPECT_EQ(job_.block().size_mm().z(), 70.5);
  EXPECT_EQ(job_.models(0).placement().move_mm().y(), -0.15);
  EXPECT_EQ(job_.models(0).placement().pivot(), PIVOT_BLOCK);
  EXPECT_EQ(job_.discretization().sections().axis(), AXIS_X);
  EXPECT_EQ(job_.motion().profile(), MOTION_PROFILE_TIME_OPTIMAL);
  EXPECT_THAT(job_.laser().channels(), ElementsAre(1, 3));
  EXPECT_EQ(job_.priority(), -7);
  EXPECT_EQ(job_.seed(), 18446744073709551615u);
  EXPECT_TRUE(job_.ordering().has_kdz());
  Sets("models[0].halftone.curve", "0 0.25, 1 0.75");
  ASSERT_EQ(job_.models(0).halftone().curve_size(), 2);
  EXPECT_EQ(job_.models(0).halftone().curve(0).to(), 0.25);
  EXPECT_EQ(job_.models(0).halftone().curve(1).from(), 1);
  Sets("laser.channels", "2");
  EXPECT_THAT(job_.laser().channels(), ElementsAre(2)) << "in its place, not behind it";
}

// A table may try another method than the job file has.
TEST_F(FieldPath, OfAChoiceTheLastStays) {
  Sets("discretization.even.distance_mm", "0.3");
  EXPECT_FALSE(job_.discretization().has_sections());
  Sets("discretization.fill.vertex_distance_mm", "0.3");
  EXPECT_FALSE(IsSet(job_, "discretization.even.distance_mm"));
  EXPECT_TRUE(IsSet(job_, "discretization.fill.vertex_distance_mm"));
}

TEST_F(FieldPath, WhatDoesNotFitIsNamedWithWhatDoes) {
  EXPECT_THAT(Refuses("block.margn_mm", "5"),
              AllOf(HasSubstr("'margn_mm', did you mean margin_mm?"), HasSubstr("clip")));
  EXPECT_THAT(Refuses("block.margin_mm", "five"), HasSubstr("'five' is not a number"));
  EXPECT_THAT(Refuses("block.margin_mm", ""), HasSubstr("number"));
  EXPECT_THAT(Refuses("block.size_mm", "1 2"), HasSubstr("three numbers"));
  EXPECT_THAT(Refuses("block.clip", "yes"), HasSubstr("true or false"));
  EXPECT_THAT(Refuses("models[1].file", "b.stl"), HasSubstr("1 of 'models'"));
  EXPECT_THAT(Refuses("models.file", "b.stl"), HasSubstr("models"));
  EXPECT_THAT(Refuses("models[0]", "b.stl"), HasSubstr("file"));
  EXPECT_THAT(Refuses("models", "b.stl"), HasSubstr("models[0]"));
  EXPECT_THAT(Refuses("glass[0]", "K8"), HasSubstr("no index"));
  EXPECT_THAT(Refuses("glass.name", "K8"), HasSubstr("no fields"));
  EXPECT_THAT(Refuses("motion.profile", "fast"), HasSubstr("MOTION_PROFILE_LQ"));
  EXPECT_THAT(Refuses("laser.channels", "1 x"), HasSubstr("whole numbers"));
  EXPECT_THAT(Refuses("models[0].halftone.curve", "0 1 2"), HasSubstr("from, to"));
  EXPECT_THAT(Refuses("priority", "1.5"), HasSubstr("whole number"));
  EXPECT_THAT(Refuses("ordering.kdz", "yes"), HasSubstr("up_ratio"));
  for (const char* broken : {"", ".", "block.", ".block", "models[", "models[-1].file",
                             "models[0", "models[0]file", "block..clip", "models[x]"}) {
    EXPECT_FALSE(SetField(job_, broken, "1")) << broken;
  }
}

}  // namespace
}  // namespace intaglio
