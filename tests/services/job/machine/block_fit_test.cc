#include "services/job/machine/block_fit.h"

#include <gmock/gmock.h>

namespace intaglio {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(BlockFit, OneOfTheSameHeightThatIsNotTooSmallFits) {
  const Vec3 job_mm(50, 50, 30);
  for (const Vec3& in_machine_mm :
       {job_mm, Vec3(100, 50, 30), Vec3(60, 70, 30), Vec3(50.0005, 49.9995, 29.9995)}) {
    EXPECT_EQ(BlockMisfit(job_mm, in_machine_mm, "els-03"), "")
        << in_machine_mm.transpose();
  }
}

TEST(BlockFit, AnyOtherIsNamedBesideTheJobsWithTheRemedy) {
  const Vec3 job_mm(50, 50, 30.5);
  for (const Vec3& in_machine_mm : {Vec3(100, 100, 100), Vec3(50, 50, 30),
                                    Vec3(49.9, 50, 30.5), Vec3(50, 20, 30.5)}) {
    EXPECT_THAT(
        BlockMisfit(job_mm, in_machine_mm, "els-03-2"),
        AllOf(HasSubstr("a block of 50 x 50 x 30.5 mm"),
              HasSubstr("`intaglio mount --machine els-03-2 --block 50 50 30.5`")))
        << in_machine_mm.transpose();
  }
  EXPECT_THAT(BlockMisfit(job_mm, Vec3(100, 100, 99.5), "els-03"),
              HasSubstr("the one in the machine has 100 x 100 x 99.5 mm"));
}

}  // namespace
}  // namespace intaglio
