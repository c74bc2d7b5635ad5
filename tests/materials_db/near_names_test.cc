#include "materials_db/near_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::materials_db {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<std::string> kNames = {"F2",    "fused-silica", "H-K9L",    "N-K5",
                                         "N-BK7", "N-BK10",       "soda-lime"};

TEST(NearNames, FindsWhatWasMeant) {
  EXPECT_THAT(NearNames("BK7", kNames), ElementsAre("N-BK7"));
  EXPECT_THAT(NearNames("nbk7", kNames), ElementsAre("N-BK7", "N-BK10", "N-K5"));
  EXPECT_THAT(NearNames("fused silica", kNames), ElementsAre("fused-silica"));
  EXPECT_THAT(NearNames("sodalime glass", kNames), ElementsAre("soda-lime"));
  EXPECT_THAT(NearNames("H-K9", kNames), ElementsAre("H-K9L"));
  EXPECT_THAT(NearNames("fsued silcia", kNames), ElementsAre("fused-silica"))
      << "letters that changed places count once";
}

TEST(NearNames, IsSilentWhenNothingIsNear) {
  EXPECT_THAT(NearNames("diamond", kNames), IsEmpty());
  EXPECT_THAT(NearNames("", kNames), IsEmpty());
}

TEST(NearNames, GivesTheNearestFirstAndNoMoreThanAsked) {
  EXPECT_THAT(NearNames("N-BK8", kNames, 1), ElementsAre("N-BK7"));
}

}  // namespace
}  // namespace intaglio::materials_db
