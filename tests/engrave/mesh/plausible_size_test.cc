#include "engrave/mesh/plausible_size.h"

#include <gmock/gmock.h>

namespace intaglio::mesh {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const Vec3 kSmallBlock(60, 60, 60);

SizeInBlock SizeOf(const Vec3& size_mm) {
  return {.size_mm = size_mm, .block_size_mm = kSmallBlock, .min_spacing_mm = 0.1};
}

SizeFault FaultOf(const SizeInBlock& model, const char* name = "m.stl") {
  const auto fault = FindSizeFault(model, name);
  EXPECT_TRUE(fault.has_value()) << model.size_mm.transpose();
  return fault.value_or(SizeFault{});
}

TEST(PlausibleSize, UsualSizesAreNotReported) {
  for (const Vec3& size_mm :
       {Vec3(40, 30, 20), Vec3(60, 60, 60), Vec3(12, 3, 1), Vec3(6, 6, 6)}) {
    EXPECT_FALSE(FindSizeFault(SizeOf(size_mm), "m")) << size_mm.transpose();
  }
  EXPECT_FALSE(FindSizeFault(SizeOf({60, 60, 0}), "m")) << "a flat model";
}

TEST(PlausibleSize, TwoInchesTakenForTwoMillimetresAskForInches) {
  const SizeFault fault = FaultOf(SizeOf({2, 1, 1.5}), "horse.stl");
  EXPECT_EQ(fault.warning.weight, WarningWeight::kNote);
  EXPECT_THAT(
      fault.warning.text,
      AllOf(HasSubstr("horse.stl: the model is 2 x 1 x 1.5 mm, small for"),
            HasSubstr("is the file in inches? Then give --unit 25.4, in a job "
                      "file placement.unit_mm: 25.4 (50.8 x 25.4 x 38.1 mm)"),
            HasSubstr("in centimetres? --unit 10 (20 x 10 x 15 mm)"),
            Not(HasSubstr("metres? --unit 1000")), HasSubstr("--size 54 (fit_size_mm)")));
}

TEST(PlausibleSize, AModelOfOneMillimetreIsAWarning) {
  const SizeFault small = FaultOf(SizeOf({1, 1, 1}));
  EXPECT_FALSE(small.refused);
  EXPECT_EQ(small.warning.code, WarningCode::kImplausibleSize);
  EXPECT_EQ(small.warning.weight, WarningWeight::kWarning);
  // So is one in a block that was chosen to fit it.
  SizeInBlock in_own = SizeOf({1.5, 1.5, 1.5});
  in_own.block_size_mm = Vec3(15, 15, 15);
  EXPECT_EQ(FaultOf(in_own).warning.weight, WarningWeight::kWarning);
  in_own.size_mm = Vec3(2.1, 2.1, 2.1);
  EXPECT_FALSE(FindSizeFault(in_own, "m"));
  // 40 mm in metres: 0.04 is below the spacing, so it would be a single point.
  const SizeFault metres = FaultOf(SizeOf({0.04, 0.03, 0.02}));
  EXPECT_TRUE(metres.refused);
  EXPECT_THAT(metres.warning.text, HasSubstr("metres? Then give --unit 1000"));
}

// The same model, judged against the machine before the block is chosen and against the
// chosen block afterwards, gets the same first unit and no size that the other one
// denies.
TEST(PlausibleSize, ABlockThatWasMadeForATinyModelDoesNotDecideAboutItsUnit) {
  SizeInBlock model = SizeOf({1.5, 1.5, 1.5});
  model.block_size_mm = Vec3(174, 174, 261), model.room = "the largest block of els-03";
  EXPECT_THAT(FaultOf(model).warning.text,
              AllOf(HasSubstr("in inches? Then give --unit 25.4"),
                    HasSubstr("at most 156 in the largest block of els-03")));
  model.block_size_mm = Vec3(15, 15, 15), model.room = "the block";
  EXPECT_THAT(
      FaultOf(model).warning.text,
      AllOf(HasSubstr("in inches? Then give --unit 25.4, in a job file "
                      "placement.unit_mm: 25.4 (38.1 x 38.1 x 38.1 mm, in a larger "
                      "block); in centimetres? --unit 10 (15 x 15 x 15 mm)"),
            Not(HasSubstr("--unit 1000")),
            HasSubstr("Or give it a size with --size (fit_size_mm), at most 13 in the "
                      "block of 15 x 15 x 15 mm")));
}

TEST(PlausibleSize, AModelOfSeventyMetresIsRefused) {
  SizeInBlock model = SizeOf({70'000, 40'000, 60'000});
  model.unit_mm = 1000;
  const SizeFault fault = FaultOf(model);
  EXPECT_TRUE(fault.refused);
  EXPECT_THAT(fault.warning.text,
              AllOf(HasSubstr("70 x 40 x 60 m, larger than the block of 60 x 60 x 60 mm"),
                    HasSubstr("--size 54")));
  model.clip = true;
  EXPECT_TRUE(FaultOf(model).refused);
  model.size_mm = {50'000, 30'000, 40'000};  // 50 mm, in millimetres
  EXPECT_THAT(FaultOf(model).warning.text, HasSubstr("millimetres? Then give --unit 1,"));
}

TEST(PlausibleSize, ALittleTooLargeIsForThePointsToDecide) {
  EXPECT_FALSE(FaultOf(SizeOf({61, 10, 10})).refused);
  EXPECT_TRUE(FaultOf(SizeOf({67, 10, 10})).refused);
}

TEST(PlausibleSize, ClipTakesAPartOfALargeModel) {
  SizeInBlock model = SizeOf({600, 600, 30});
  EXPECT_TRUE(FaultOf(model).refused);
  model.clip = true;
  EXPECT_FALSE(FindSizeFault(model, "m"));
}

TEST(PlausibleSize, AFittedModelHasTheSizeThatWasAskedFor) {
  SizeInBlock model = SizeOf({1, 1, 1});
  model.fitted = true;
  EXPECT_FALSE(FindSizeFault(model, "m"));
  model.size_mm = {200, 10, 40};  // fitted to a height of 40
  const SizeFault fault = FaultOf(model);
  EXPECT_TRUE(fault.refused);
  EXPECT_THAT(fault.warning.text,
              AllOf(Not(HasSubstr("--unit")), HasSubstr("--size 54")));
}

TEST(PlausibleSize, TheSizeToFitToIsHeldByTheBlock) {
  SizeInBlock model = SizeOf({10, 20, 5});
  model.block_size_mm = {4, 6, 3};
  // By y: 0.9 * 20 / (20 / 6) = 5.4; by x 0.9 * 4 / 10 * 20 = 7.2.
  EXPECT_THAT(FaultOf(model).warning.text, HasSubstr("--size 5 (fit"));
}

}  // namespace
}  // namespace intaglio::mesh
