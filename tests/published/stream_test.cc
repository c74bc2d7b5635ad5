#include "tests/published/stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engrave/course/cut_program.h"

namespace intaglio::course {
namespace {

PlanOptions StreamOptions() {
  PlanOptions options;
  options.compensate = true;
  options.acceleration_mm_s2 = 6000;
  options.motor_mm_s2 = 11000;
  options.kernel_s = 0.022;
  return options;
}

struct Streamed {
  SpeedLaw law;
  bool holds = false;
  TrackingOptions tracking;
};

Streamed Stream(const Path& path, const PlanOptions& options) {
  CourseStream stream =
      CourseStream::Make(path.node_mm(0), MeasuredMachine(), options, 100).value();
  Streamed streamed;
  for (const Segment& segment : path.segments()) {
    const std::size_t before = streamed.law.phases.size();
    EXPECT_TRUE(stream.Append({segment.end_mm, segment.feed_mm_s}, streamed.law.phases));
    // The delay is bounded: what is not final yet is at most one window and this piece.
    EXPECT_LE(stream.pending_mm(), stream.max_pending_mm() + segment.length_mm);
    EXPECT_GE(streamed.law.phases.size(), before);
  }
  stream.Finish(streamed.law.phases);
  EXPECT_EQ(stream.pending_mm(), 0);
  streamed.law.duration_s = stream.duration_s();
  streamed.law.length_mm = path.length_mm();
  streamed.law.node_speed_mm_s = stream.node_speed_mm_s();
  streamed.holds = stream.holds();
  streamed.tracking = stream.tracking();
  return streamed;
}

/// Each phase begins where the one before ends.
void ExpectContinuous(const SpeedLaw& law) {
  ASSERT_FALSE(law.phases.empty());
  for (std::size_t i = 1; i < law.phases.size(); ++i) {
    const Phase& p = law.phases[i - 1];
    const double t = law.phases[i].begin_s - p.begin_s;
    ASSERT_GE(t, 0);
    ASSERT_NEAR(p.s_mm + t * (p.v_mm_s + t * p.a_mm_s2 / 2), law.phases[i].s_mm, 1e-6);
    ASSERT_NEAR(p.v_mm_s + t * p.a_mm_s2, law.phases[i].v_mm_s, 1e-4);
  }
}

// A stream passes no corner with a swing.
void ExpectAsGoodAsWhole(const PlanOptions& options, std::uint64_t seed) {
  PlanOptions of_whole = options;
  of_whole.swing = false;
  double streamed_s = 0, whole_s = 0;
  for (const Path& path : CutProgram(2, 100, seed)) {
    const Streamed streamed = Stream(path, options);
    EXPECT_TRUE(streamed.holds);
    ASSERT_EQ(streamed.law.node_speed_mm_s.size(), path.node_count());
    ExpectContinuous(streamed.law);
    // The law that came out piece by piece, followed as a whole.
    const Tracking tracking(MeasuredMachine(), streamed.tracking);
    const Tracked tracked =
        tracking.Follow(path, streamed.law, MeasuredMachine(), Exactness::kAxes, true);
    const ContourError error =
        MeasureContour(path, tracked.actual_mm, tracked.commanded_s_mm,
                       tracking.WindowFor(100, options.tolerance_mm));
    // Windows begin as if the axes had come straight for ever: what is left of that after
    // the memory is below a thousandth.
    EXPECT_LE(error.worst_mm(), options.tolerance_mm * 1.002);
    if (options.motor_mm_s2) {
      EXPECT_LE(*std::ranges::max_element(tracked.motor_mm_s2),
                *options.motor_mm_s2 * 1.01);
    }
    streamed_s += streamed.law.duration_s;
    whole_s += PlanCourse(path, MeasuredMachine(), of_whole).value().law.duration_s;
  }
  EXPECT_LE(streamed_s, whole_s * 1.03);
}

TEST(CourseStream, IsAsGoodAsThePlanOfTheWhole) { ExpectAsGoodAsWhole({}, 90); }

TEST(CourseStream, CompensatedIsAsGoodAsThePlanOfTheWhole) {
  ExpectAsGoodAsWhole(StreamOptions(), 91);
}

TEST(CourseStream, NeedsAKernelBeforehand) {
  PlanOptions options = StreamOptions();
  options.kernel_s.reset();
  EXPECT_EQ(CourseStream::Make(Vec2(0, 0), MeasuredMachine(), options, 100).error().code,
            ErrorCode::kMissing);
}

TEST(CourseStream, RefusesAPieceAndGoesOn) {
  CourseStream stream =
      CourseStream::Make(Vec2(0, 0), MeasuredMachine(), {}, 100).value();
  std::vector<Phase> phases;
  EXPECT_FALSE(stream.Append({Vec2(0, 0), 50}, phases));
  EXPECT_EQ(stream.Append({Vec2(5, 0), 200}, phases).error().message,
            "feed_mm_s 200 is above 100, the greatest of this stream");
  EXPECT_TRUE(stream.Append({Vec2(5, 0), 50}, phases));
  stream.Finish(phases);
  EXPECT_NEAR(stream.duration_s(), 5.0 / 50 + 50.0 / 2000, 1e-9);
}

}  // namespace
}  // namespace intaglio::course
