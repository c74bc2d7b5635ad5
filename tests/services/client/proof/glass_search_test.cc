#include "services/client/proof/evidence/glass_search.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::Journal;
using formats::JournalKind;
using formats::JournalRecord;

class GlassSearchTest : public ::testing::Test {
 protected:
  /// The engraver of this power-up made a crack at each of the ticks.
  void Record(const std::string& name, std::uint32_t power_up,
              const std::vector<std::uint64_t>& ticks) const {
    auto bytes = formats::EncodeGlassHeader({Vec3(20, 20, 20), 1.5, 0.1, power_up});
    for (const std::uint64_t tick : ticks) {
      formats::AppendGlassCrack({tick, Vec3(power_up, 1, 1), 30, 0, true}, bytes);
    }
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  void Session(std::uint32_t power_up, std::uint64_t tick) {
    JournalRecord record;
    record.kind = JournalKind::kSession;
    record.point = power_up;
    record.tick = tick;
    journal_.records.push_back(record);
  }
  void Intent(std::uint64_t tick) {
    JournalRecord record;
    record.tick = tick;
    journal_.records.push_back(record);
  }
  std::vector<TickSpan> Spans() const {
    TickSpans spans;
    for (const JournalRecord& record : journal_.records) spans.Receive(record);
    return spans.Finish();
  }
  std::vector<double> Ticks() const {
    const auto glass = FindGlass(Spans(), folder_);
    EXPECT_TRUE(glass && *glass);
    return glass && *glass ? (*glass)->ticks : std::vector<double>();
  }

  fs::path folder_ = test::FreshFolder();
  Journal journal_;
};

using Expected = std::vector<double>;

TEST_F(GlassSearchTest, AJobHasTheCracksOfItsTicksAlone) {
  Record("glass.rec", 5, {90, 100, 103, 107, 110, 111, 200});
  Session(5, 100);
  Intent(103);
  Intent(110);
  // 107 belongs to no intent: a stray pulse during the job is the job's.
  EXPECT_EQ(Ticks(), (Expected{100, 103, 107, 110}));
}

TEST_F(GlassSearchTest, SessionsOfOnePowerUpAreOneSpanAndNoCrackCountsTwice) {
  Record("glass.rec", 5, {100, 120, 130, 140});
  Session(5, 95);
  Intent(100);
  Intent(130);
  Session(5, 110);
  Intent(120);
  EXPECT_EQ(Ticks(), (Expected{100, 120, 130}));
}

TEST_F(GlassSearchTest, TicksOfTheNextPowerUpFollow) {
  Record("glass-00000007.rec", 7, {50, 60, 70});
  Record("glass.rec", 4, {5, 8, 300});
  Session(7, 40);
  Intent(60);
  Session(4, 3);
  Intent(8);
  // 60 is the last of the first, so that tick 3 becomes 61.
  EXPECT_EQ(Ticks(), (Expected{50, 60, 63, 66}));
}

TEST_F(GlassSearchTest, WithoutARecordTheGlassIsNotKnown) {
  Record("glass.rec", 4, {5, 8});
  Session(9, 1);
  Intent(5);
  const auto glass = FindGlass(Spans(), folder_);
  ASSERT_TRUE(glass);
  EXPECT_FALSE(glass->has_value());
  // A power-up in which nothing was tried does not matter.
  journal_.records.clear();
  Session(9, 1);
  Session(4, 1);
  Intent(8);
  EXPECT_EQ(Ticks(), (Expected{5, 8}));
}

TEST_F(GlassSearchTest, AnEngraverDoesNotOverwriteTheRecordOfTheLast) {
  Record("glass.rec", 0xAB, {5});
  ASSERT_TRUE(KeepGlassRecord(folder_ / "glass.rec"));
  EXPECT_FALSE(fs::exists(folder_ / "glass.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "glass-000000ab.rec"));
  EXPECT_TRUE(KeepGlassRecord(folder_ / "glass.rec")) << "none is no error";
  std::ofstream(folder_ / "glass.rec") << "nonsense";
  EXPECT_TRUE(KeepGlassRecord(folder_ / "glass.rec"));
  EXPECT_TRUE(fs::exists(folder_ / "glass.rec")) << "nobody can need it";
}

}  // namespace
}  // namespace intaglio::client
