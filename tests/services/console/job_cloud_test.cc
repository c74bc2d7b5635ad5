#include "services/console/job_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "engrave/formats/journal_file.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

using ::testing::HasSubstr;

template <typename Value>
Value At(const std::string& bytes, std::size_t offset) {
  Value value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(JobCloud, HasEveryPointAtItsPlaceAndInTheOrder) {
  PointList path;
  for (int i = 0; i < 100; ++i) path.push_back({0.5 * i, 25.0, 30.0 - 0.1 * i});
  const auto packed = PackPlan(path, {50, 50, 30});
  ASSERT_TRUE(packed);
  ASSERT_EQ(packed->size(), 24u + 12 * 100);
  EXPECT_EQ(packed->substr(0, 8), "INTPLAN1");
  EXPECT_EQ(At<std::uint32_t>(*packed, 8), 100u);
  EXPECT_EQ(At<float>(*packed, 20), 30.0f);
  std::vector<bool> seen(100);
  double first_half = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    const auto place = At<std::uint32_t>(*packed, 24 + 800 + 4 * i);
    ASSERT_LT(place, 100u);
    EXPECT_FALSE(seen[place]);
    seen[place] = true;
    if (i < 50) first_half += place;
    const Vec3 point = path[place];
    for (int axis = 0; axis < 3; ++axis) {
      const double size = axis == 2 ? 30 : 50;
      // Half of a step of the packed numbers, and a rounding of doubles.
      EXPECT_NEAR(At<std::uint16_t>(*packed, 24 + 8 * i + 2 * axis) * size / 65535,
                  point[axis], 0.5 * size / 65535 + 1e-9);
    }
  }
  // A fair sample: the mean of 50 of 0..99 strays by 2.9 from 49.5, five of that.
  EXPECT_NEAR(first_half / 50, 49.5, 15);
}

/// A journal whose last record is cut.
std::string JournalOf(const std::vector<formats::JournalRecord>& records) {
  std::string bytes;
  const auto append = [&](const auto& encoded) {
    bytes.append(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  };
  append(formats::EncodeJournalHeader({.point_count = 10, .epoch = 1}));
  for (const auto& record : records) append(formats::EncodeJournalRecord(record));
  return bytes + "torn";
}

TEST(JobCloud, ReadsTheJournalPieceByPiece) {
  using formats::JournalKind;
  using formats::PointOutcome;
  const auto folder = test::FreshFolder();
  std::ofstream(folder / "journal.bin", std::ios::binary) << JournalOf(
      {{.kind = JournalKind::kIntent, .point = 3},
       {.kind = JournalKind::kOutcome, .outcome = PointOutcome::kMade, .point = 3},
       {.kind = JournalKind::kOutcome, .outcome = PointOutcome::kMissed, .point = 4}});
  const auto all = ReadMade(folder, 0);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->size(), 12u);
  EXPECT_EQ(At<std::uint32_t>(*all, 0), 3u);
  EXPECT_EQ(At<std::uint32_t>(*all, 4), 3u | 1u << 29);
  EXPECT_EQ(At<std::uint32_t>(*all, 8), 4u | 2u << 29);
  const auto rest = ReadMade(folder, 2);
  ASSERT_TRUE(rest);
  ASSERT_EQ(rest->size(), 8u);
  EXPECT_EQ(At<std::uint32_t>(*rest, 0), 3u);
  const auto nothing = ReadMade(folder, 3);
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->size(), 4u);
  EXPECT_EQ(At<std::uint32_t>(*nothing, 0), 3u);
}

TEST(JobCloud, NamesWhatIsNotThere) {
  const auto plan = ReadPlan(test::FreshFolder());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(plan.error().message, HasSubstr("path.ply"));
  EXPECT_FALSE(ReadMade(test::FreshFolder("none"), 0));
}

}  // namespace
}  // namespace intaglio::console
