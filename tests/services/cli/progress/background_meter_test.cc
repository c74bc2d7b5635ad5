#include "services/cli/progress/background_meter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(BackgroundMeter, DrawsTheLastStateOfAStageThatReports) {
  std::ostringstream out;
  {
    BackgroundMeter meter(out, false, std::chrono::seconds(0));
    meter.Begin("read");
    EXPECT_TRUE(meter.Sink("contours")(250, 1000));
  }
  EXPECT_THAT(out.str(), HasSubstr("contours   [######------------------]  25 %"));
}

TEST(BackgroundMeter, DrawsAStageThatDoesNotReport) {
  std::ostringstream out;
  {
    BackgroundMeter meter(out, true, std::chrono::seconds(0));
    meter.Begin("read");
  }
  EXPECT_THAT(out.str(), HasSubstr("read "));
  EXPECT_THAT(out.str(), HasSubstr(" s"));
  EXPECT_TRUE(out.str().ends_with('\n'));
}

TEST(BackgroundMeter, DrawsNothingOfWhatIsReadySoon) {
  std::ostringstream out;
  {
    BackgroundMeter meter(out, true, std::chrono::hours(1));
    EXPECT_TRUE(meter.Sink("contours")(1, 2));
  }
  EXPECT_THAT(out.str(), IsEmpty());
}

}  // namespace
}  // namespace intaglio::cli
