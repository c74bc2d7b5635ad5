#include "services/cli/recordings/recording_report.h"

#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

// The last time that a recording can have: 2^64 - 1 ns.
TEST(RecordingReport, TimesBeyondTheSystemClockAreThoseOfTheFile) {
  const auto reader = recording::McapReader::Open(std::filesystem::path(
      INTAGLIO_SOURCE_DIR "/tests/data/recordings/others/last_time_stamp.mcap"));
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(InfoOf(*reader).end_utc(), "2554-07-21T23:34:33.709Z");
}

}  // namespace
}  // namespace intaglio::cli
