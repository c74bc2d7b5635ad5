// `intaglio teach outline` of a job of marks through all processes at a virtual BJJCZ
// board, whose own record has what the guide laser drew and what the beam made.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/course/course_shop.h"
#include "tests/integration/guide_ways.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kFieldMm = 110, kPlaceMm = kFieldMm / 65536;

/// Two squares and a circle: 41 mm wide and 22 mm high, with a hull of four straight
/// edges and an arc.
constexpr char kDrawing[] =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" )"
    R"(viewBox="0 0 60 40"><rect x="5" y="3" width="10" height="10"/>)"
    R"(<rect x="8" y="17" width="8" height="8"/><circle cx="40" cy="14" r="6"/></svg>)";

/// The least rectangle around what was drawn, or made.
class Extent {
 public:
  void Add(const Vec2& at) { box_.Extend(Vec3(at.x(), at.y(), 0)); }
  Vec2 min() const { return box_.min_mm.head<2>(); }
  Vec2 max() const { return box_.max_mm.head<2>(); }

 private:
  Box3 box_;
};

class MarkOutline : public ::testing::Test {
 protected:
  void SetUp() override {
    shop_.Write("drawing.svg", kDrawing);
    shop_.Write("drawing.textproto",
                "name: \"drawing\" machine_file: \"machine.textproto\" marks { items { "
                "drawing { file: \"drawing.svg\" } } pen { speed_mm_s: 100 power_ratio: "
                "0.5 frequency_hz: 30000 } }\n");
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
  }
  std::string job() const { return shop_.folder() / "drawing.textproto"; }
  std::vector<GuideWay> Ways() const {
    return GuideWaysOf(shop_.board_record(), kFieldMm);
  }
  std::unique_ptr<Running> Drawing(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"teach", "outline", job()};
    words.insert(words.end(), more.begin(), more.end());
    return AwaitDrawing(
        [&] {
          return std::make_unique<Running>(Program("intaglio"), shop_.With(words),
                                           shop_.folder() / "outline.txt");
        },
        [&] { return Ways().size(); });
  }
  bool Rests() const {
    return GuideRests([&] { return Ways().size(); });
  }
  /// The extent of what the beam made; none: it made nothing.
  std::optional<Extent> Made() const {
    std::optional<Extent> made;
    std::ifstream record(shop_.board_record());
    for (std::string line; std::getline(record, line);) {
      std::istringstream in(line);
      std::string kind;
      Vec2 from, to;
      if (!(in >> kind >> from.x() >> from.y() >> to.x() >> to.y()) || kind != "mark")
        continue;
      if (!made) made.emplace();
      for (const Vec2& at : {from, to})
        made->Add(kPlaceMm * (at - Vec2::Constant(32768)));
    }
    return made;
  }

  CourseShop shop_{CourseShop::Machine::kBoard};
};

// The job is made behind it: what the beam marked touches the four sides of what the
// guide laser drew.
TEST_F(MarkOutline, IsAroundWhatTheBeamMarksAfterwards) {
  const auto client = Drawing();
  std::this_thread::sleep_for(1s);
  client->Signal(SIGINT);
  const Ended ended = client->WaitForEnd(20s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("41.0 x 22.0 mm"));
  EXPECT_TRUE(Rests());
  EXPECT_FALSE(Made()) << "the beam was on";
  std::vector<GuideWay> ways = Ways();
  const std::size_t drawn = ways.size();
  Extent outline;
  for (const GuideWay& way : ways) outline.Add(way.to_mm);
  // The job is at rest until it is armed, and the guide laser stays dark in it.
  ASSERT_TRUE(shop_.Submit(job()));
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const auto made = Made();
  ASSERT_TRUE(made);
  // Half a place on each side, and what 64 corners leave out of a circle.
  EXPECT_LE((made->min() - outline.min()).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LE((made->max() - outline.max()).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_EQ(Ways().size(), drawn) << "the guide laser is on in the job";
}

TEST_F(MarkOutline, OfARectangleHasFourWays) {
  const auto client = Drawing({"--rectangle"});
  client->Signal(SIGINT);
  EXPECT_EQ(client->WaitForEnd(20s).exit_code, 0) << client->Output();
  for (const GuideWay& way : Ways()) {
    const Vec2 along = (way.to_mm - way.from_mm).cwiseAbs();
    EXPECT_LE(along.minCoeff(), kPlaceMm) << "an edge is neither upright nor level";
  }
}

TEST_F(MarkOutline, EndsWithItsPersonAndWithTheMachinesState) {
  const auto nothing = [](Running&) {};
  const std::vector<OutlineEnding> endings = {
      {"client killed", [](Running& client) { client.Signal(SIGKILL); }, nothing},
      {"client hangs", [](Running& client) { client.Signal(SIGSTOP); },
       [](Running& client) { client.Signal(SIGKILL); }},
      {"door", [&](Running&) { shop_.AtPanel("door open"); },
       [&](Running&) { shop_.AtPanel("door close"); }, "door"},
      {"stop", [&](Running&) { shop_.Type({"stop"}); },
       [&](Running&) {
         shop_.Type({"stop", "--reset"});
       },
       "stop"},
      {"marker killed", [&](Running&) { EXPECT_GT(shop_.Kill("intaglio-marker"), 0); },
       nothing},
      {"job armed", [&](Running&) { EXPECT_TRUE(shop_.Submit(job())); }, nothing, "",
       true},
  };
  ExpectEachEndsIt(
      endings, [&] { return Drawing(); }, [&] { return Rests(); },
      [&] { return Made().has_value(); });
  EXPECT_TRUE(Eventually([&] { return Made().has_value(); }, 60s))
      << "the job is not made";
}

// What has no outline says so, and nothing lights.
TEST_F(MarkOutline, NothingElseOfTheFieldIsMovedOrTaught) {
  EXPECT_THAT(shop_.Teach({"move", "1", "1", "0"}), HasSubstr("cannot move it by hand"));
  EXPECT_THAT(shop_.Teach({"zero"}), HasSubstr("nothing is taught"));
  EXPECT_THAT(shop_.Teach({"status"}), HasSubstr("limits -55 to 55"));
  EXPECT_TRUE(Ways().empty());
}

}  // namespace
}  // namespace intaglio::testing
