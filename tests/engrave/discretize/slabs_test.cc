#include "engrave/discretize/slabs.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"

namespace intaglio::discretize {
namespace {

const HeightRange kHeights{1, 61};

TEST(Slabs, SeamsAreApartByMoreThanTheReach) {
  const Slabs slabs(kHeights, 0.1);
  ASSERT_GT(slabs.count(), 10u);
  for (std::size_t k = 1; k < slabs.count(); ++k) {
    const HeightRange seam = slabs.Seam(k);
    EXPECT_GE(seam.high_mm - seam.low_mm, 0.1);
    EXPECT_EQ(seam.low_mm, slabs.Whole(k).low_mm);
    EXPECT_EQ(seam.high_mm, slabs.Between(k).low_mm);
    EXPECT_EQ(slabs.Between(k - 1).high_mm, seam.low_mm);
    EXPECT_GE(slabs.Between(k - 1).high_mm - slabs.Between(k - 1).low_mm, 1);
  }
}

TEST(Slabs, TheyHoldEveryHeightOnce) {
  const Slabs slabs(kHeights, 0.3);
  for (double z = -5; z < 70; z += 0.01) {
    int holders = 0;
    for (std::size_t k = 0; k < slabs.count(); ++k) {
      holders += slabs.Seam(k).Contains(z) + slabs.Between(k).Contains(z);
    }
    ASSERT_EQ(holders, 1) << z;
  }
}

TEST(Slabs, WithALeadTheFillingReachesNoPointAboveTheSeam) {
  const Slabs slabs(kHeights, 0.1, 0.4);
  EXPECT_EQ(slabs.Lead(0).low_mm, slabs.Lead(0).high_mm);
  for (std::size_t k = 0; k + 1 < slabs.count(); ++k) {
    const HeightRange lead = slabs.Lead(k + 1), seam = slabs.Seam(k + 1);
    EXPECT_EQ(lead.high_mm, seam.low_mm);
    EXPECT_NEAR(lead.high_mm - lead.low_mm, 0.4, 1e-9);
    EXPECT_GT(lead.low_mm, slabs.Between(k).low_mm);
    EXPECT_EQ(slabs.Filling(k).low_mm, seam.low_mm);
    EXPECT_GE(slabs.Filling(k).high_mm - seam.low_mm, 0.1);
    EXPECT_GE(slabs.Between(k + 1).low_mm - slabs.Filling(k).high_mm, 0.1);
  }
  const std::size_t last = slabs.count() - 1;
  EXPECT_EQ(slabs.Filling(last).low_mm, slabs.Filling(last).high_mm);
  EXPECT_THROW(Slabs(kHeights, 0.1, 4), PreconditionError);
}

TEST(Slabs, ALowObjectAndNoObjectAreOneSlab) {
  EXPECT_EQ(Slabs({0, 3}, 0.1).count(), 1u);
  EXPECT_EQ(Slabs({1, -1}, 0.1).count(), 1u);
  EXPECT_THROW(Slabs(kHeights, 0), PreconditionError);
}

TEST(Slabs, PartsShareOutTheSlabs) {
  for (const std::size_t slabs : {1u, 5u, 19u, 64u}) {
    for (const std::size_t parts : {1u, 2u, 7u, 32u}) {
      std::size_t next = 0;
      for (std::size_t i = 0; i < parts; ++i) {
        const Part part{i, parts};
        EXPECT_EQ(part.Begin(slabs), next);
        EXPECT_LE(part.End(slabs) - next, slabs / parts + 1);
        next = part.End(slabs);
      }
      EXPECT_EQ(next, slabs);
    }
  }
}

}  // namespace
}  // namespace intaglio::discretize
