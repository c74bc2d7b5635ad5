#include "services/console/plan_packer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <set>

#include "tests/services/console/packed_plan.h"

namespace intaglio::console {
namespace {

std::uint32_t StartOf(const std::string& plan, std::size_t cell) {
  return At<std::uint32_t>(plan, 24 + 4 * cell);
}

std::array<std::uint16_t, 4> PointAt(const std::string& plan, std::size_t i) {
  return At<std::array<std::uint16_t, 4>>(plan, 2076 + 8 * i);
}

std::uint32_t PlaceAt(const std::string& plan, std::size_t count, std::size_t i) {
  return At<std::uint32_t>(plan, 2076 + 8 * count + 4 * i);
}

TEST(PlanPacker, HasEveryPointOnceInItsCellAndAtItsPlace) {
  PointList path;
  for (int i = 0; i < 1000; ++i)
    path.push_back({0.05 * i, std::fmod(7.7 * i, 50.0), 30.0 - 0.03 * i});
  const auto packed = PackPlan(path, {50, 50, 30});
  ASSERT_TRUE(packed);
  ASSERT_EQ(packed->size(), 2076u + 12 * 1000);
  EXPECT_EQ(packed->substr(0, 8), "INTPLAN2");
  EXPECT_EQ(At<std::uint32_t>(*packed, 8), 1000u);
  EXPECT_EQ(At<float>(*packed, 20), 30.0f);
  EXPECT_EQ(StartOf(*packed, 0), 0u);
  EXPECT_EQ(StartOf(*packed, 512), 1000u);
  std::set<std::uint32_t> places;
  for (std::size_t cell = 0; cell < 512; ++cell) {
    for (std::size_t i = StartOf(*packed, cell); i < StartOf(*packed, cell + 1); ++i) {
      const auto point = PointAt(*packed, i);
      EXPECT_EQ(cell, point[0] / 8192u * 64 + point[1] / 8192u * 8 + point[2] / 8192u);
      const std::uint32_t place = PlaceAt(*packed, 1000, i);
      ASSERT_LT(place, 1000u);
      places.insert(place);
      EXPECT_NEAR(point[3] / 65535.0, place / 1000.0, 0.5 / 65535 + 1e-9);
      for (int axis = 0; axis < 3; ++axis) {
        const double size = axis == 2 ? 30 : 50;
        // Half of a step of the packed numbers, and a rounding of doubles.
        EXPECT_NEAR(point[static_cast<std::size_t>(axis)] * size / 65535,
                    path[place][axis], 0.5 * size / 65535 + 1e-9);
      }
    }
  }
  EXPECT_EQ(places.size(), 1000u);
}

// The points of a cell lie in eight boxes of it, and come in their order: a prefix of the
// cell has to have its share of each box and of the order's first half. A number that is
// binomially distributed strays by less than five standard deviations (1 in 10^6).
TEST(PlanPacker, EveryPrefixOfACellIsAFairSample) {
  std::mt19937 random(7);
  const auto next = [&] { return random() / 4294967296.0; };
  PointList path;
  // Box by box, as a path that is engraved: without a random order the first prefix of a
  // cell would have the points of one box.
  for (int box = 0; box < 8; ++box) {
    for (int i = 0; i < 6000; ++i) {
      path.push_back({(box % 2 + next()) * 3.125, (box / 2 % 2 + next()) * 3.125,
                      (box / 4 + next()) * 3.125});
    }
  }
  const auto packed = PackPlan(path, {50, 50, 50});
  ASSERT_TRUE(packed);
  ASSERT_GT(StartOf(*packed, 1), 47900u) << "all but those on the border of the cell";
  for (const std::size_t prefix : {500, 1000, 4000, 12000, 24000}) {
    std::array<int, 8> in_box{};
    int early = 0;
    for (std::size_t i = 0; i < prefix; ++i) {
      const std::uint32_t place = PlaceAt(*packed, path.size(), i);
      ++in_box[place / 6000];
      early += place < path.size() / 2;
    }
    const double count = static_cast<double>(prefix);
    for (const int found : in_box)
      EXPECT_NEAR(found, count / 8, 5 * std::sqrt(count * 7 / 64)) << prefix;
    EXPECT_NEAR(early, count / 2, 5 * std::sqrt(count / 4)) << prefix;
  }
}

TEST(PlanPacker, PacksPointsOfOneCellAndOnTheBorder) {
  const auto packed = PackPlan({{50, 50, 30}, {0, 0, 0}, {50, 0, 30}}, {50, 50, 30});
  ASSERT_TRUE(packed);
  EXPECT_EQ(StartOf(*packed, 1), 1u);
  EXPECT_EQ(StartOf(*packed, 511), 2u);
  const auto none = PackPlan({}, {50, 50, 30});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->size(), 2076u);
}

TEST(PlanPacker, RefusesOtherPointsThanThoseThatItCounted) {
  auto packer = PlanPacker::Begin(2, {50, 50, 30});
  ASSERT_TRUE(packer);
  packer->Count({{1, 1, 1}, {1, 1, 1}});
  EXPECT_TRUE(packer->Place({{1, 1, 1}}));
  EXPECT_FALSE(packer->Place({{49, 1, 1}}));
  auto short_one = PlanPacker::Begin(2, {50, 50, 30});
  short_one->Count({{1, 1, 1}, {1, 1, 1}});
  EXPECT_TRUE(short_one->Place({{1, 1, 1}}));
  EXPECT_FALSE(short_one->Finish());
  const auto many = PlanPacker::Begin(std::uint64_t{1} << 29, {50, 50, 30});
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().code, ErrorCode::kTooLarge);
}

// Programs of others read these bytes: they change only together with the magic.
TEST(PlanPacker, IsTheGoldenBytes) {
  PointList path;
  for (int i = 0; i < 40; ++i)
    path.push_back({1.25 * i, 50.0 - 0.3 * i, i % 2 == 0 ? 2.5 : 2.6});
  const auto packed = PackPlan(path, {50, 50, 30});
  ASSERT_TRUE(packed);
  std::string hex;
  for (std::size_t i = 0; i < packed->size(); ++i) {
    hex += fmt::format("{:02x}", static_cast<unsigned char>((*packed)[i]));
    if (i % 32 == 31 || i + 1 == packed->size()) hex += '\n';
  }
  std::ifstream file(INTAGLIO_SOURCE_DIR "/tests/data/console_plan.golden");
  const std::string golden((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(golden, hex);
}

}  // namespace
}  // namespace intaglio::console
