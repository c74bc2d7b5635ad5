#include "services/client/proof/marks/mark_search.h"

#include <gtest/gtest.h>

#include <fstream>

#include "services/client/proof/evidence/glass_search.h"
#include "services/platform/link/scan_head_protocol.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::Journal;
using formats::JournalKind;
using formats::JournalRecord;

struct Lit {
  std::uint64_t tick = 0;
  std::uint32_t run = 0, mark = 0;
  bool operator==(const Lit&) const = default;
};

class MarkSearchTest : public ::testing::Test {
 protected:
  void Record(const std::string& name, std::uint32_t power_up,
              const std::vector<Lit>& lit) const {
    formats::MarkRecord record{{100, power_up}, {}, 0};
    for (const Lit& one : lit)
      record.ticks.push_back({one.tick, {1, 1}, {0.01, 0}, 0.1, one.run, one.mark});
    ASSERT_TRUE(formats::WriteMarkRecord(folder_ / name, record));
  }
  void Session(std::uint32_t power_up) {
    JournalRecord record;
    record.kind = JournalKind::kSession;
    record.point = formats::PowerUpOfText(link::HeadPowerUpText("head-7", power_up));
    journal_.records.push_back(record);
  }
  void Intent(std::uint32_t run, std::uint32_t mark) {
    JournalRecord record;
    record.run = run;
    record.point = mark;
    journal_.records.push_back(record);
  }
  std::optional<std::vector<Lit>> Found() const {
    const auto burnt = FindBurnt(journal_, MarkRecordsIn(folder_, "head-7"));
    EXPECT_TRUE(burnt);
    if (!burnt || !*burnt) return std::nullopt;
    std::vector<Lit> lit;
    for (const auto& tick : (*burnt)->ticks)
      lit.push_back({tick.tick, tick.run, tick.mark});
    return lit;
  }

  fs::path folder_ = test::FreshFolder();
  Journal journal_;
};

using Ticks = std::vector<Lit>;

TEST_F(MarkSearchTest, AJobHasTheTicksOfItsRunsAlone) {
  Record("marks.rec", 5, {{10, 1, 0}, {20, 2, 0}, {30, 2, 1}, {40, 3, 0}});
  Session(5);
  Intent(2, 0);
  Intent(2, 1);
  EXPECT_EQ(Found(), (Ticks{{20, 2, 0}, {30, 2, 1}}));
}

TEST_F(MarkSearchTest, WhatNoRunOfTheJobBurntMeanwhileBelongsToNoMark) {
  Record("marks.rec", 5, {{10, 2, 0}, {20, 9, 1}, {30, 4, 1}, {40, 9, 1}});
  Session(5);
  Intent(2, 0);
  Intent(4, 1);
  EXPECT_EQ(Found(), (Ticks{{10, 2, 0}, {20, 9, kNoMark}, {30, 4, 1}}));
}

TEST_F(MarkSearchTest, TicksOfTheNextPowerUpFollow) {
  Record("marks-00000007.rec", 7, {{50, 2, 0}, {60, 2, 0}});
  Record("marks.rec", 4, {{5, 3, 1}, {8, 3, 1}, {9, 4, 1}});
  Session(7);
  Intent(2, 0);
  Session(4);
  Intent(3, 1);
  EXPECT_EQ(Found(), (Ticks{{50, 2, 0}, {60, 2, 0}, {61, 3, 1}, {64, 3, 1}}));
}

TEST_F(MarkSearchTest, APowerUpWithoutARecordMakesTheMaterialUnknown) {
  Record("marks.rec", 4, {{5, 3, 1}});
  Session(7);
  Intent(2, 0);
  Session(4);
  Intent(3, 1);
  EXPECT_EQ(Found(), std::nullopt);
}

// The same power-up of another device.
TEST_F(MarkSearchTest, TheRecordOfAnotherHeadIsNotTaken) {
  Record("marks.rec", 5, {{10, 2, 0}});
  Session(5);
  Intent(2, 0);
  const auto burnt = FindBurnt(journal_, MarkRecordsIn(folder_, "head-8"));
  ASSERT_TRUE(burnt);
  EXPECT_FALSE(*burnt);
}

TEST_F(MarkSearchTest, OfARunOfItsOwnNothingIsLeftOut) {
  Record("marks.rec", 5, {{10, 9, 0}, {20, 2, 0}, {30, 9, 7}});
  Session(5);
  Intent(2, 0);
  const auto burnt = AllBurnt(journal_, folder_ / "marks.rec");
  ASSERT_TRUE(burnt);
  ASSERT_EQ(burnt->ticks.size(), 3u);
  EXPECT_EQ(burnt->ticks[0].mark, kNoMark);
  EXPECT_EQ(burnt->ticks[1].mark, 0u);
  EXPECT_EQ(burnt->ticks[2].mark, kNoMark);
}

// The next head begins its record anew.
TEST_F(MarkSearchTest, ARecordWithMarksIsKeptUnderItsPowerUp) {
  Record("marks.rec", 5, {});
  ASSERT_TRUE(KeepMarkRecord(folder_ / "marks.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "marks.rec"));
  Record("marks.rec", 5, {{10, 1, 0}});
  ASSERT_TRUE(KeepMarkRecord(folder_ / "marks.rec"));
  EXPECT_FALSE(fs::exists(folder_ / "marks.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "marks-00000005.rec"));
}

TEST_F(MarkSearchTest, RecordsThatNoOpenJobNeedsAreRemoved) {
  std::ofstream(folder_ / "truth.textproto") << "head { serial_number: \"head-7\" }";
  Record("marks-00000007.rec", 7, {{50, 2, 0}});
  Record("marks-00000008.rec", 8, {{50, 2, 0}});
  Record("marks.rec", 4, {{5, 3, 1}});
  RemoveMarkRecords(folder_,
                    {formats::PowerUpOfText(link::HeadPowerUpText("head-7", 8))});
  EXPECT_FALSE(fs::exists(folder_ / "marks-00000007.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "marks-00000008.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "marks.rec"));
}

}  // namespace
}  // namespace intaglio::client
