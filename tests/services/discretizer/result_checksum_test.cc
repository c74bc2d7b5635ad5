// The expected checksums were computed by zlib.crc32 of Python over struct.pack of the
// fields as the header describes them.

#include "services/discretizer/result_checksum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <utility>
#include <vector>

namespace intaglio::discretizer {
namespace {

host::StageResult Points() {
  host::StageResult result;
  result.cloud.Add(Vec3(1.5, -2.25, 3.0), 0);
  result.cloud.Add(Vec3(0.1, 0.2, 0.3), 7);
  result.cloud.Add(Vec3(-0.0, 1e-300, 99.75), 1);
  return result;
}

host::StageResult Marks() {
  host::StageResult result;
  result.marks =
      mark::MarkSet{{{"outline", 100, 0.5, 20000, 2, 0.2, 5}, {"", 50, 1, 0, 1, 0, 0}},
                    {{1, true, 0, {{Vec2(1, 2), 0.25}, {Vec2(3, -4), 0}}},
                     {0, false, 12.5, {{Vec2(0.5, 0.5), 0}}}}};
  return result;
}

TEST(ResultChecksum, IsTheCrcOfTheFieldsInTheirOrder) {
  EXPECT_EQ(ChecksumOf(Points()), "3-ae1bc4ee");
  EXPECT_EQ(ChecksumOf(Marks()), "2-8f176b47");
  EXPECT_EQ(ChecksumOf({}), "0-00000000");
}

TEST(ResultChecksum, WhateverReachesTheNextStageChangesIt) {
  std::set<std::string> sums{ChecksumOf(Points()), ChecksumOf(Marks())};
  const auto expect_new = [&](host::StageResult result,
                              const std::function<void(host::StageResult&)>& change) {
    change(result);
    EXPECT_TRUE(sums.insert(ChecksumOf(result)).second) << sums.size();
  };
  for (int axis = 0; axis < 3; ++axis) {
    expect_new(Points(), [axis](host::StageResult& r) {
      double& value = r.cloud.points_mm[1][axis];
      value = std::nextafter(value, 1);
    });
  }
  expect_new(Points(), [](host::StageResult& r) { r.cloud.source[2] = 2; });
  expect_new(Points(), [](host::StageResult& r) { r.cloud.points_mm[2].x() = 0.0; });
  expect_new(Points(), [](host::StageResult& r) {
    std::swap(r.cloud.points_mm[0], r.cloud.points_mm[1]);
  });
  expect_new(Points(), [](host::StageResult& r) { r.cloud.Add(Vec3::Zero(), 0); });
  const std::vector<std::function<void(mark::MarkSet&)>> changes = {
      [](mark::MarkSet& m) { m.pens[0].name = "Outline"; },
      [](mark::MarkSet& m) { m.pens[0].speed_mm_s = 101; },
      [](mark::MarkSet& m) { m.pens[1].power_ratio = 0.9; },
      [](mark::MarkSet& m) { m.pens[1].frequency_hz = 1; },
      [](mark::MarkSet& m) { m.pens[1].pass_count = 3; },
      [](mark::MarkSet& m) { m.pens[1].depth_mm = 1; },
      [](mark::MarkSet& m) { m.pens[1].plunge_mm_s = 1; },
      [](mark::MarkSet& m) { m.marks[0].pen = 0; },
      [](mark::MarkSet& m) { m.marks[0].closed = false; },
      [](mark::MarkSet& m) { m.marks[0].web_mm = 1; },
      [](mark::MarkSet& m) { m.marks[0].places[1].at_mm.x() = 4; },
      [](mark::MarkSet& m) { m.marks[0].places[1].at_mm.y() = 4; },
      [](mark::MarkSet& m) { m.marks[0].places[1].bulge = 1; },
      [](mark::MarkSet& m) { m.marks[0].places[1].dark = true; },
      [](mark::MarkSet& m) { m.marks[0].places.pop_back(); },
      [](mark::MarkSet& m) { std::swap(m.marks[0], m.marks[1]); },
  };
  for (const auto& change : changes)
    expect_new(Marks(), [&](host::StageResult& r) { change(*r.marks); });
}

// They are more bytes than are summed at once.
TEST(ResultChecksum, OfManyPointsDoesNotDependOnThePieces) {
  host::StageResult many;
  for (int i = 0; i < 100'000; ++i) many.cloud.Add(Vec3(i, 2.0 * i, 0.5), 3);
  host::StageResult fewer = many;
  fewer.cloud.points_mm.pop_back();
  fewer.cloud.source.pop_back();
  EXPECT_NE(ChecksumOf(many), ChecksumOf(fewer));
  EXPECT_EQ(ChecksumOf(many), "100000-8851f117");
}

}  // namespace
}  // namespace intaglio::discretizer
