// The motion that `intaglio plan` writes, read again and checked without our code: a
// reader that has the file alone must come to the figures that were printed.

#include "services/cli/offline/plan_command.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <set>

#include "engrave/formats/point_file.h"
#include "proto/job.pb.h"
#include "proto/plan_report.pb.h"
#include "services/cli/offline/post_command.h"
#include "services/client/exit_codes.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// One row of the file, as anybody reads it.
struct Row {
  double tick = 0;
  std::array<double, 3> place_mm{}, velocity_mm_s{};
  int point = -1;
};

std::vector<Row> ReadRows(const fs::path& file) {
  std::vector<Row> rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "tick,x_mm,y_mm,z_mm,vx_mm_s,vy_mm_s,vz_mm_s,point");
  while (std::getline(in, line)) {
    Row row;
    auto& [x, y, z] = row.place_mm;
    auto& [vx, vy, vz] = row.velocity_mm_s;
    // %lf reads the shortest decimals back to the same doubles.
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%d", &row.tick, &x,
                          &y, &z, &vx, &vy, &vz, &row.point),
              8)
        << line;
    rows.push_back(row);
  }
  return rows;
}

/// The motion between two knots according to the rows, by the cubic of the documentation.
double CubicPlace(double p0, double v0, double p1, double v1, double d_s, double u) {
  const double b1 = p0 + v0 * d_s / 3, b2 = p1 - v1 * d_s / 3, w = 1 - u;
  return w * w * w * p0 + 3 * w * w * u * b1 + 3 * w * u * u * b2 + u * u * u * p1;
}

class PlanCommand : public ::testing::Test {
 protected:
  PlanCommand() {
    setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
    // A walk of small steps with a leap now and then, in a block of 30 mm.
    std::mt19937 random(7);
    std::uniform_real_distribution<double> step(-0.2, 0.2), anywhere(6, 24);
    Vec3 at(10, 10, 10);
    for (int i = 0; i < 2000; ++i) {
      at += Vec3(step(random), step(random), 0.01);
      if (i % 250 == 249) at.head<2>() = Vec2(anywhere(random), anywhere(random));
      path_mm_.push_back(at);
    }
    EXPECT_TRUE(formats::WritePly(path(), {path_mm_, {}, {}}));
  }

  fs::path path() const { return folder_ / "path.ply"; }
  fs::path csv() const { return folder_ / "segments.csv"; }

  int Type(std::vector<std::string> words) {
    command_line::Program program("intaglio", "");
    AddPathCommands(program.root());
    AddPostCommand(program.root());
    EXPECT_TRUE(program.Parse(words));
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    output_ = ::testing::internal::GetCapturedStdout();
    errors_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  PlanReport ReportOf(std::vector<std::string> words) {
    words.push_back("--json");
    Type(std::move(words));
    PlanReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(output_, &report).ok())
        << output_ << errors_;
    return report;
  }

  fs::path folder_ = test::FreshFolder();
  PointList path_mm_;
  std::string output_, errors_;
};

TEST_F(PlanCommand, RowsPassEveryPointAtItsTickAndInItsPlace) {
  for (const std::string profile : {"continuous", "mix", "cubic"}) {
    const PlanReport report =
        ReportOf({"plan", "--path", path().string(), "--frame", "machine", "--rate",
                  "100", "--profile", profile, "--csv", csv().string()});
    ASSERT_EQ(report.motions_size(), 1);
    const std::vector<Row> rows = ReadRows(csv());
    ASSERT_EQ(rows.size(), report.motions(0).segment_count() + 1);
    EXPECT_EQ(rows.front().tick, 0);
    EXPECT_EQ(rows.front().point, -1);
    int next = 0;
    double tick_of_last = 0;
    for (const Row& row : rows) {
      if (row.point < 0) continue;
      ASSERT_EQ(row.point, next) << "in the path's order, each once";
      EXPECT_EQ(row.tick, std::floor(row.tick)) << "point " << row.point;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(row.place_mm[axis], path_mm_[row.point][axis]) << row.point;
      }
      tick_of_last = row.tick;
      ++next;
    }
    EXPECT_EQ(next, 2000);
    EXPECT_EQ(report.motions(0).planner(), profile);
    EXPECT_EQ(report.motions(0).ticks(), tick_of_last);
    EXPECT_DOUBLE_EQ(report.motions(0).utilisation(), 2000 / tick_of_last);
    EXPECT_DOUBLE_EQ(report.motions(0).machining_time_s(), tick_of_last / 100);
    EXPECT_GE(report.motions(0).ticks_bound(), 2000u);
    EXPECT_LE(report.motions(0).ticks_bound(), tick_of_last);
  }
}

// The places between the rows, differentiated by differences: velocities are those of
// the rows, accelerations within the limits and of the printed mean square.
TEST_F(PlanCommand, VelocitiesAndFiguresFollowFromTheRows) {
  const PlanReport report =
      ReportOf({"plan", "--path", path().string(), "--frame", "machine", "--rate", "100",
                "--acceleration", "5000", "--csv", csv().string()});
  const std::vector<Row> rows = ReadRows(csv());
  double square = 0, total_s = 0, peak = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double d_s = (rows[i].tick - rows[i - 1].tick) / 100;
    ASSERT_GT(d_s, 0);
    std::array<double, 3> a0{}, a1{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = [&](double u) {
        return CubicPlace(rows[i - 1].place_mm[axis], rows[i - 1].velocity_mm_s[axis],
                          rows[i].place_mm[axis], rows[i].velocity_mm_s[axis], d_s, u);
      };
      // Second differences of a cubic are linear, so those about 1/4 and 3/4 give both
      // ends; h^2 of a 0.1 ms segment leaves 1e-15 / 1e-10 of rounding.
      const auto second = [&](double u) {
        return (place(u + 0.25) - 2 * place(u) + place(u - 0.25)) / (0.0625 * d_s * d_s);
      };
      const double early = second(0.25), late = second(0.75);
      a0[axis] = 1.5 * early - 0.5 * late;
      a1[axis] = 1.5 * late - 0.5 * early;
      const double limit = 5000 * (1 + 1e-6) + 1e-12 / (d_s * d_s);
      EXPECT_LE(std::abs(a0[axis]), limit) << "row " << i;
      EXPECT_LE(std::abs(a1[axis]), limit) << "row " << i;
      // One-sided differences at the end, exact for a cubic.
      const double h = 0.25;
      const double v1 = (11 * place(1) - 18 * place(1 - h) + 9 * place(1 - 2 * h) -
                         2 * place(1 - 3 * h)) /
                        (6 * h * d_s);
      EXPECT_NEAR(v1, rows[i].velocity_mm_s[axis], 1e-6 + 1e-12 / d_s);
      square +=
          d_s / 3 * (a0[axis] * a0[axis] + a0[axis] * a1[axis] + a1[axis] * a1[axis]);
    }
    total_s += d_s;
    peak = std::max(
        {peak, std::hypot(a0[0], a0[1], a0[2]), std::hypot(a1[0], a1[1], a1[2])});
  }
  const PlannedMotion& motion = report.motions(0);
  EXPECT_EQ(motion.violation_count(), 0u);
  EXPECT_NEAR(motion.rms_acceleration_mm_s2(), std::sqrt(square / total_s), 0.1);
  EXPECT_NEAR(motion.peak_acceleration_mm_s2(), peak, 1);
}

TEST_F(PlanCommand, TheGlassDecidesHowFarTheStageMovesAlongTheBeam) {
  const auto span_mm = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"plan", "--path", path().string(), "--csv",
                                      csv().string()};
    words.insert(words.end(), more.begin(), more.end());
    Type(words);
    const std::vector<Row> rows = ReadRows(csv());
    return rows.back().place_mm[2] - rows.front().place_mm[2];
  };
  const double in_glass_mm = path_mm_.back().z() - path_mm_.front().z();
  EXPECT_NEAR(span_mm({"--frame", "machine"}), in_glass_mm, 1e-12);
  // About 1 / n; the numerical aperture makes it up to 2 % less.
  EXPECT_NEAR(span_mm({}), in_glass_mm / 1.52, 0.02 * in_glass_mm);
  EXPECT_NEAR(span_mm({"--glass", "FUSED-SILICA"}), in_glass_mm / 1.46,
              0.02 * in_glass_mm);
}

// The published order goes to -16 mm in x and to -49 mm in z.
TEST_F(PlanCommand, APathOfTheStageMayHaveAnyZero) {
  for (Vec3& p : path_mm_) p -= Vec3(100, 50, 200);
  ASSERT_TRUE(formats::WritePly(path(), {path_mm_, {}, {}}));
  const PlanReport report = ReportOf(
      {"plan", "--path", path().string(), "--frame", "machine", "--rate", "100"});
  ASSERT_EQ(report.motions_size(), 1) << errors_;
  EXPECT_EQ(report.motions(0).violation_count(), 0u);
}

TEST_F(PlanCommand, ComparisonHasEveryPlannerAndTheContinuousOneIsFastest) {
  const PlanReport report = ReportOf({"plan", "--path", path().string(), "--rate", "200",
                                      "--compare", "--profile", "mix"});
  ASSERT_EQ(report.motions_size(), MotionProfile_descriptor()->value_count());
  EXPECT_EQ(report.motions(0).planner(), "mix") << "the job's own first";
  std::set<std::string> names;
  std::uint64_t continuous = 0, smallest = ~std::uint64_t{0};
  for (const PlannedMotion& motion : report.motions()) {
    names.insert(motion.planner());
    smallest = std::min(smallest, motion.ticks());
    if (motion.planner() == "continuous") continuous = motion.ticks();
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(report.motions_size()));
  EXPECT_EQ(continuous, smallest);
  Type({"plan", "--path", path().string(), "--compare"});
  for (const std::string& name : names) {
    EXPECT_THAT(output_, HasSubstr("\n" + name + " "));
  }
}

TEST_F(PlanCommand, WritesThePathAgainWithTheTickOfEachPoint) {
  const fs::path out = folder_ / "again.ply";
  Type({"plan", "--path", path().string(), "--out", out.string(), "--csv",
        csv().string()});
  const auto table = formats::ReadPly(out);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->points_mm, path_mm_);
  const auto* ticks = table->Find<double>("tick");
  ASSERT_NE(ticks, nullptr);
  for (const Row& row : ReadRows(csv())) {
    if (row.point < 0) continue;
    EXPECT_EQ(ticks->at(row.point), row.tick);
  }
}

/// The numbers behind a word of the lines of motion, e.g. 'X'.
std::vector<double> TokensOf(const fs::path& gcode, char word) {
  std::vector<double> values;
  std::ifstream in(gcode);
  for (std::string line; std::getline(in, line);) {
    const auto at = line.find(std::string(" ") + word);
    if (line.starts_with("G0") && at != std::string::npos) {
      values.push_back(std::stod(line.substr(at + 2)));
    }
  }
  return values;
}

TEST_F(PlanCommand, PostWritesTheAxesOfATableForAController) {
  const fs::path machine = folder_ / "table.textproto", out = folder_ / "axes.ngc";
  std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string origin = "\nblock_origin_mm { x: 0";
  text.replace(text.find(origin), origin.size(), "\nblock_origin_mm { x: -100");
  std::ofstream(machine) << text << "cartesian { x { moves: AXIS_MOVES_TABLE } }\n";
  Type({"post", "--path", path().string(), "--machine", machine.string(), "--out",
        out.string(), "--template", "linuxcnc"});
  const std::vector<double> x_mm = TokensOf(out, 'X'), y_mm = TokensOf(out, 'Y');
  ASSERT_EQ(x_mm.size(), path_mm_.size()) << errors_;
  for (std::size_t i = 0; i < path_mm_.size(); ++i) {
    EXPECT_NEAR(x_mm[i], 100 - path_mm_[i].x(), 6e-5) << "four decimals";
    EXPECT_NEAR(y_mm[i], path_mm_[i].y(), 6e-5);
  }
}

// The figures are those of a machine of 150 mm, not of one whose millimetres are radians.
TEST_F(PlanCommand, PlansAnArmAndARotaryTable) {
  const fs::path out = folder_ / "axes.ngc";
  const PlanReport report =
      ReportOf({"plan", "--path", path().string(), "--machine",
                INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto", "--block", "50",
                "50", "30", "--csv", csv().string()});
  ASSERT_EQ(report.motions_size(), 1) << errors_;
  EXPECT_EQ(report.motions(0).violation_count(), 0u);
  EXPECT_GT(report.motions(0).peak_speed_mm_s(), 60);
  EXPECT_LT(report.motions(0).peak_speed_mm_s(), 0.8 * 150 + 1e-3);
  std::ifstream segments(csv());
  std::string heading;
  std::getline(segments, heading);
  EXPECT_EQ(heading, "tick,arm_rad,table_rad,z_mm,varm_rad_s,vtable_rad_s,vz_mm_s,point");
  EXPECT_EQ(Type({"post", "--path", path().string(), "--machine",
                  INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto", "--block", "50",
                  "50", "30", "--out", out.string(), "--template", "linuxcnc-polar"}),
            client::kExitGood)
      << errors_;
  // Turned forwards, the words lead to the points: the block's corner is at (-25, 90).
  const std::vector<double> arm_deg = TokensOf(out, 'A'), table_deg = TokensOf(out, 'C');
  ASSERT_EQ(arm_deg.size(), path_mm_.size());
  ASSERT_EQ(table_deg.size(), path_mm_.size());
  constexpr double kDeg = 3.14159265358979 / 180;
  for (std::size_t i = 0; i < path_mm_.size(); ++i) {
    const double arm = arm_deg[i] * kDeg, table = table_deg[i] * kDeg;
    const double x_mm = 150 * std::sin(arm), y_mm = 200 - 150 * std::cos(arm);
    const Vec2 on_table_mm(x_mm * std::cos(table) + y_mm * std::sin(table),
                           y_mm * std::cos(table) - x_mm * std::sin(table));
    EXPECT_LT((on_table_mm - Vec2(-25, 90) - path_mm_[i].head<2>()).norm(), 1e-4);
  }
}

TEST_F(PlanCommand, SortPrintsTheFiguresThatPlanPrintsForItsPath) {
  const fs::path sorted = folder_ / "sorted.ply";
  const PlanReport sort = ReportOf(
      {"sort", "--cloud", path().string(), "--out", sorted.string(), "--rate", "100"});
  const PlanReport plan = ReportOf({"plan", "--path", sorted.string(), "--rate", "100"});
  EXPECT_EQ(sort.checksum(), plan.checksum());
  EXPECT_EQ(sort.shadow_violation_count(), 0u);
  EXPECT_LT(sort.motions(0).ticks(), 2 * 2000u);
  EXPECT_EQ(sort.motions(0).ticks(), plan.motions(0).ticks());
  EXPECT_EQ(sort.motions(0).mean_jerk_mm_s3(), plan.motions(0).mean_jerk_mm_s3());
}

TEST_F(PlanCommand, SortTakesACloudThatLiesInNoBlock) {
  for (Vec3& p : path_mm_) p -= Vec3(100, 50, 200);
  ASSERT_TRUE(formats::WritePly(path(), {path_mm_, {}, {}}));
  const PlanReport report = ReportOf(
      {"sort", "--cloud", path().string(), "--out", (folder_ / "sorted.xyz").string()});
  ASSERT_EQ(report.motions_size(), 1) << errors_;
  EXPECT_EQ(report.motions(0).violation_count(), 0u);
}

// A target out of the machine's reach is reported, not planned.
TEST_F(PlanCommand, ABlockThatTheStageCannotReachIsRefused) {
  EXPECT_EQ(Type({"plan", "--path", path().string(), "--block", "300", "30", "30"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("block.size_mm"));
}

TEST_F(PlanCommand, AnOrderThatFiresThroughCracksEndsWith3) {
  PointList downwards(path_mm_.rbegin(), path_mm_.rend());
  downwards.resize(3);
  downwards[1] = downwards[0] - Vec3(0, 0, 1);
  downwards[2] = downwards[0] - Vec3(0, 0, 2);
  ASSERT_TRUE(formats::WritePly(path(), {downwards, {}, {}}));
  EXPECT_EQ(Type({"plan", "--path", path().string()}), client::kExitNotGood);
  EXPECT_THAT(output_, HasSubstr("2 fired through an earlier crack"));
}

TEST_F(PlanCommand, WrongInputIsNamedWithItsRemedy) {
  const std::string there = path().string();
  const auto refused = [&](std::vector<std::string> words) {
    EXPECT_EQ(Type(std::move(words)), client::kExitWrongInput);
    EXPECT_EQ(output_, "");
    return errors_;
  };
  EXPECT_THAT(refused({"plan", "--path", (folder_ / "none.ply").string()}),
              HasSubstr("none.ply"));
  EXPECT_THAT(refused({"plan", "--path", there, "--rate", "77"}),
              HasSubstr("laser.rate_hz: 77"));
  EXPECT_THAT(refused({"plan", "--path", there, "--glass", "N-BK77"}),
              HasSubstr("N-BK7"));
  EXPECT_THAT(refused({"plan", "--path", there, "--block", "20", "20", "20"}),
              ::testing::AllOf(HasSubstr("outside the block of 20 x 20 x 20 mm"),
                               HasSubstr("--frame machine")));
  EXPECT_THAT(refused({"plan", "--path", there, "--csv", "/proc/no/place.csv"}),
              HasSubstr("/proc/no/place.csv"));
  EXPECT_THAT(refused({"plan", "--path", there, "--out", "/proc/no/place.ply"}),
              HasSubstr("/proc/no/place.ply"));
  std::ofstream(folder_ / "empty.xyz") << "# nothing\n";
  EXPECT_THAT(refused({"plan", "--path", (folder_ / "empty.xyz").string()}),
              HasSubstr("empty.xyz"));
}

}  // namespace
}  // namespace intaglio::cli
