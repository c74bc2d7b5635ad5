// Programs with planned feeds, played by a virtual controller of the grbl family whose
// motion moves axes of second order, integrated here step by step.

#include "services/cli/contour/planned_feeds.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engrave/post/mill_program.h"
#include "services/job/files/job_file.h"
#include "services/virtual_engraver/mill/virtual_grbl.h"
#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/post/supplied_templates.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

constexpr double kSpeed = 60, kTolerance_mm = 0.1;
constexpr double kFrequency_hz = 35, kDamping = 0.3;
constexpr double kStep_us = 100;

/// A table whose axes ring at 35 Hz.
MachineSpec Table() {
  auto machine = ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  EXPECT_TRUE(machine) << (machine ? "" : machine.error().message);
  machine->set_name("table");
  machine->set_position_tolerance_um(1e3 * kTolerance_mm);
  auto& drive = *machine->mutable_second_order();
  drive.set_natural_frequency_hz(kFrequency_hz);
  drive.set_damping_ratio(kDamping);
  return *machine;
}

/// A gear, then a slot with round ends.
std::vector<post::ToolPath> GearAndSlot() {
  constexpr int kTeeth = 24;
  std::vector<Vec2> places;
  for (int i = 0; i < kTeeth; ++i) {
    for (const auto& [radius_mm, share] :
         {std::pair{17.0, 0.0}, {17.0, 0.3}, {20.0, 0.4}, {20.0, 0.9}}) {
      const double angle = 2 * std::numbers::pi * (i + share) / kTeeth;
      places.emplace_back(radius_mm * std::cos(angle), radius_mm * std::sin(angle));
    }
  }
  contour::Edges gear;
  for (std::size_t i = 0; i < places.size(); ++i)
    gear.push_back(contour::MakeLine(places[i], places[(i + 1) % places.size()]));
  const double half = std::numbers::pi / 2;
  const contour::Edges slot = {
      contour::MakeLine({-8, -2}, {8, -2}), contour::MakeArc({8, 0}, 2, -half, 2 * half),
      contour::MakeLine({8, 2}, {-8, 2}), contour::MakeArc({-8, 0}, 2, half, 2 * half)};
  return {post::PathOf(gear, "gear"), post::PathOf(slot, "slot")};
}

std::string ProgramOf(const std::vector<post::ToolPath>& paths, double speed_mm_s) {
  post::Cutting cutting;
  cutting.speed_mm_s = speed_mm_s;
  cutting.depths_mm = {0};
  cutting.power_ratio = 0.5;
  const auto texts =
      post::MillPrograms(post::fixture::SuppliedMill("grbl-laser"), paths, cutting);
  EXPECT_TRUE(texts) << (texts ? "" : texts.error().message);
  return texts ? texts->front() : "";
}

/// What the axes made of a program, while the laser was on.
struct Played {
  std::vector<Vec2> places_mm;
  double lit_s = 0;
};

class Player {
 public:
  Player(double acceleration_mm_s2, double junction_deviation_mm)
      : controller_(OptionsOf(acceleration_mm_s2, junction_deviation_mm)) {
    controller_.Advance(1e5);
    (void)controller_.Read();
  }

  Played Play(const std::string& program) {
    std::size_t begin = 0;
    while (begin < program.size()) {
      const std::size_t end = program.find('\n', begin);
      // The virtual controller begins in the modal state of the first line.
      const std::string line = program.substr(begin, end - begin);
      if (line[0] != ';' && line != "M2" && !line.starts_with("G21")) Send(line);
      begin = end + 1;
    }
    // The axes come to rest behind the last line.
    for (int i = 0; i < 20'000; ++i) Step();
    EXPECT_TRUE(controller_.motion().is_empty());
    for (const grbl::Flash& flash : controller_.motion().flashes())
      played_.lit_s += 1e-6 * (flash.off_us - flash.on_us);
    return played_;
  }

 private:
  static grbl::VirtualGrblOptions OptionsOf(double acceleration_mm_s2,
                                            double junction_deviation_mm) {
    grbl::VirtualGrblOptions options = grbl::GrblHal();
    options.motion.steps_per_mm = 2000;
    options.motion.max_speed_mm_s = 200;
    options.motion.acceleration_mm_s2 = acceleration_mm_s2;
    options.motion.junction_deviation_mm = junction_deviation_mm;
    return options;
  }

  void Send(const std::string& line) {
    controller_.Write(line + "\n");
    std::string answer;
    for (int i = 0; i < 1'000'000 && answer.find("ok") == std::string::npos; ++i) {
      Step();
      answer += controller_.Read();
      ASSERT_EQ(answer.find("error"), std::string::npos) << line << ": " << answer;
    }
    ASSERT_NE(answer.find("ok"), std::string::npos) << line;
  }

  /// x'' + 2 d w x' + w^2 x = w^2 command, by steps of 10 us.
  void Step() {
    constexpr double kW = 2 * std::numbers::pi * kFrequency_hz;
    const Vec2 before_mm = command_mm_;
    controller_.Advance(kStep_us);
    command_mm_ = controller_.WorkPosition_mm().head<2>();
    constexpr int kParts = 10;
    constexpr double kPart_s = 1e-6 * kStep_us / kParts;
    for (int k = 1; k <= kParts; ++k) {
      const Vec2 command = before_mm + (command_mm_ - before_mm) * k / kParts;
      speed_mm_s_ +=
          kPart_s * (kW * kW * (command - place_mm_) - 2 * kDamping * kW * speed_mm_s_);
      place_mm_ += kPart_s * speed_mm_s_;
    }
    // A way at work lasts until the axes are at rest behind it.
    const bool lit = controller_.motion().lit();
    if (lit || (works_ && (place_mm_ - command_mm_).norm() > 1e-3))
      played_.places_mm.push_back(place_mm_);
    works_ = lit || (works_ && command_mm_ == before_mm);
  }

  grbl::VirtualGrbl controller_;
  Vec2 command_mm_ = Vec2::Zero(), place_mm_ = Vec2::Zero(), speed_mm_s_ = Vec2::Zero();
  bool works_ = false;
  Played played_;
};

double DistanceTo(const std::vector<contour::Edges>& drawn, const Vec2& place_mm) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const contour::Edges& edges : drawn) {
    for (const contour::Edge& edge : edges)
      smallest = std::min(smallest, contour::DistanceTo(edge, place_mm));
  }
  return smallest;
}

/// The greater of: how far the axes were from what is drawn, and corners from the axes.
double ErrorOf(const std::vector<post::ToolPath>& paths, const Played& played) {
  std::vector<contour::Edges> drawn;
  for (const post::ToolPath& path : paths) drawn.push_back(post::EdgesOf(path));
  double worst = 0;
  for (const Vec2& place_mm : played.places_mm)
    worst = std::max(worst, DistanceTo(drawn, place_mm));
  for (const contour::Edges& edges : drawn) {
    for (const contour::Edge& edge : edges) {
      double missed = std::numeric_limits<double>::infinity();
      for (const Vec2& place_mm : played.places_mm)
        missed = std::min(missed, (place_mm - edge.end_mm).norm());
      worst = std::max(worst, missed);
    }
  }
  return worst;
}

// With one feed the best that a person can find: acceleration and junction deviation by
// trial, until nothing is outside any more. (With 56 pairs that are tried 5.92 s.)
TEST(PlannedFeeds, KeepTheToleranceOnAControllerOfTheFamilyAndSaveTime) {
  const auto paths = GearAndSlot();
  const auto feeds = PlanFeeds(paths, kSpeed, Table());
  ASSERT_TRUE(feeds) << feeds.error().message;
  const Played planned = Player(feeds->acceleration_mm_s2, feeds->junction_deviation_mm)
                             .Play(ProgramOf(feeds->paths, kSpeed));
  const double error_mm = ErrorOf(paths, planned);
  EXPECT_LE(error_mm, kTolerance_mm);
  EXPECT_NEAR(error_mm, feeds->worst_mm, 0.05 * kTolerance_mm);
  EXPECT_NEAR(planned.lit_s, feeds->work_s, 0.02 * feeds->work_s);

  double one_feed_s = std::numeric_limits<double>::infinity();
  for (const double acceleration_mm_s2 : {3500.0, 2500.0}) {
    for (const double deviation_mm : {0.01, 0.02, 0.04, 0.08}) {
      const Played played =
          Player(acceleration_mm_s2, deviation_mm).Play(ProgramOf(paths, kSpeed));
      if (ErrorOf(paths, played) <= kTolerance_mm)
        one_feed_s = std::min(one_feed_s, played.lit_s);
    }
  }
  EXPECT_LT(planned.lit_s, 0.95 * one_feed_s);
  // As the axes allow, and none watches their ringing.
  const Played unplanned = Player(7000, 0.08).Play(ProgramOf(paths, kSpeed));
  EXPECT_GT(ErrorOf(paths, unplanned), 1.5 * kTolerance_mm);
}

/// What the contours of a program take, and the greatest error; each is played alone, as
/// each begins and ends at rest.
Played PlayEach(const std::vector<post::ToolPath>& paths, const PlannedFeeds& feeds,
                double speed_mm_s, double& worst_mm) {
  Played all;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Played one = Player(feeds.acceleration_mm_s2, feeds.junction_deviation_mm)
                           .Play(ProgramOf({feeds.paths[i]}, speed_mm_s));
    all.lit_s += one.lit_s;
    worst_mm = std::max(worst_mm, ErrorOf({paths[i]}, one));
  }
  return all;
}

struct CutContent {
  const char* name;
  double length_m;
  std::uint64_t seed;
  course::ProgramMix mix;
};

class CutPrograms : public testing::TestWithParam<CutContent> {};

// The programs of docs/measurements.md, with the times that are stated there.
TEST_P(CutPrograms, KeepTheToleranceInThePlannedTime) {
  constexpr double kFast = 100;
  const auto program =
      course::CutProgram(GetParam().length_m, kFast, GetParam().seed, GetParam().mix);
  std::vector<post::ToolPath> paths;
  for (const course::Path& path : program) {
    contour::Edges edges;
    for (const course::Segment& segment : path.segments())
      edges.push_back(contour::MakeLine(segment.begin_mm, segment.end_mm));
    paths.push_back(post::PathOf(edges, fmt::format("contour {}", paths.size() + 1)));
  }
  MachineSpec table = Table();
  for (AxisLimits* axis : {table.mutable_x(), table.mutable_y()})
    axis->set_max_speed_mm_s(kFast);
  const auto feeds = PlanFeeds(paths, kFast, table);
  ASSERT_TRUE(feeds) << feeds.error().message;
  double worst_mm = 0;
  const Played played = PlayEach(paths, *feeds, kFast, worst_mm);
  EXPECT_LE(worst_mm, kTolerance_mm);
  EXPECT_NEAR(played.lit_s, feeds->work_s, 0.02 * feeds->work_s);
  const double stopping_s = course::StoppingDurationS(program, feeds->acceleration_mm_s2);
  EXPECT_LT(played.lit_s, stopping_s);
  fmt::print("{}, {:.2f} m: {:.1f} s, {:.1f} s with stops at {:.0f} mm/s^2, {:.1f} um\n",
             GetParam().name, 1e-3 * course::LengthMm(program), played.lit_s, stopping_s,
             feeds->acceleration_mm_s2, 1e3 * worst_mm);
}

INSTANTIATE_TEST_SUITE_P(Of, CutPrograms,
                         testing::Values(CutContent{"all", 32, 2026, {}},
                                         CutContent{"all_anew", 32, 7, {}},
                                         CutContent{"rectangles", 8, 2026, {1, 0, 0, 0}},
                                         CutContent{"gears", 8, 2026, {0, 1, 0, 0}},
                                         CutContent{"curves", 8, 2026, {0, 0, 1, 0}},
                                         CutContent{"zigzag", 8, 2026, {0, 0, 0, 1}}),
                         [](const auto& test) { return std::string(test.param.name); });

// The same ways: no place of a move is beside what is drawn, and the lengths agree.
TEST(PlannedFeeds, DivideTheSameWays) {
  const auto paths = GearAndSlot();
  const auto feeds = PlanFeeds(paths, kSpeed, Table());
  ASSERT_TRUE(feeds) << feeds.error().message;
  ASSERT_EQ(feeds->paths.size(), paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const contour::Edges before = post::EdgesOf(paths[i]);
    const contour::Edges now = post::EdgesOf(feeds->paths[i]);
    EXPECT_NEAR(contour::LengthOf(now), contour::LengthOf(before), 1e-6);
    for (const contour::Edge& edge : now) {
      EXPECT_LT(DistanceTo({before}, edge.end_mm), 1e-9);
      EXPECT_LT(DistanceTo({before}, contour::PointAt(edge, edge.length_mm / 2)), 1e-9);
    }
    for (const contour::Edge& edge : before) {
      const bool met = std::ranges::any_of(now, [&](const contour::Edge& part) {
        return (part.end_mm - edge.end_mm).norm() < 1e-9;
      });
      EXPECT_TRUE(met) << paths[i].name;
    }
    for (const post::WorkMove& move : feeds->paths[i].moves) {
      ASSERT_TRUE(move.speed_mm_s.has_value());
      EXPECT_LE(*move.speed_mm_s, kSpeed);
    }
  }
}

TEST(PlannedFeeds, KeepTabsAndRefuseWhatNoFeedKeeps) {
  auto paths = GearAndSlot();
  paths[0].moves[5].tab = true;
  const auto feeds = PlanFeeds(paths, kSpeed, Table());
  ASSERT_TRUE(feeds) << feeds.error().message;
  double tab_mm = 0;
  const contour::Edges edges = post::EdgesOf(feeds->paths[0]);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (feeds->paths[0].moves[i].tab) tab_mm += edges[i].length_mm;
  EXPECT_NEAR(tab_mm, post::EdgesOf(paths[0])[5].length_mm, 1e-9);

  MachineSpec turning = Table();
  turning.clear_x();
  EXPECT_FALSE(PlanFeeds(paths, kSpeed, turning));
}

}  // namespace
}  // namespace intaglio::cli
