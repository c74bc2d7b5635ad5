// A mill whose work zero is set anew in the pause of a job: nothing more is cut before it
// is back, also when all services were restarted meanwhile. The judge is the true way of
// the tool.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::size_t kPlates = 6;
constexpr double kPlatePitch_mm = 10;
const Vec2 kZero_mm(20, 5);

class ZeroOfAJob : public ::testing::TestWithParam<bool> {
 protected:
  void Begin() {
    std::string drawing =
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="10mm" )"
        R"(viewBox="0 0 60 10">)";
    for (std::size_t i = 0; i < kPlates; ++i)
      drawing += "<rect x=\"" + std::to_string(1 + 10 * i) +
                 "\" y=\"1\" width=\"8\" height=\"8\"/>";
    shop_.Write("plates.svg", drawing + "</svg>");
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    SetZeroAt(kZero_mm.x(), kZero_mm.y(), "xy");
    ASSERT_TRUE(shop_.Submit(
        shop_.WriteJob("plates",
                       "files: \"plates.svg\" make: COURSE_MAKE_CUT inside: true "
                       "tool_diameter_mm: 1 depth_mm: 0.5 plunge_mm_s: 10 "
                       "speed_mm_s: 10")));
    ASSERT_TRUE(Eventually(
        [&] {
          if (Cuts().size() > 4) return true;
          shop_.GoOn();
          return false;
        },
        60s))
        << shop_.shown() << shop_.Log();
    shop_.Type({"pause", "1"});
  }
  /// From the zero that is set.
  void SetZeroAt(double x_mm, double y_mm, const std::string& axes) {
    ASSERT_TRUE(Eventually(
        [&] {
          return shop_.Teach({"status"}).find("by hand: allowed") != std::string::npos;
        },
        30s))
        << shop_.Teach({"status"});
    EXPECT_THAT(shop_.Teach({"move", std::to_string(x_mm), std::to_string(y_mm), "5"}),
                HasSubstr(fmt::format("x {:.1f}", x_mm)));
    EXPECT_THAT(shop_.Teach({"zero", "--axes", axes}), HasSubstr("the work zero is set"));
  }
  std::vector<ToolStep> Cuts() const {
    std::vector<ToolStep> cuts;
    for (const ToolStep& step : shop_.Way())
      if (step.on && step.lowest_mm() < 0) cuts.push_back(step);
    return cuts;
  }
  std::string BegunJob() const {
    for (const auto& entry : fs::directory_iterator(shop_.folder() / "shop/jobs"))
      if (entry.path().filename().string().starts_with("1-"))
        return TextIn(entry.path() / "job.json");
    return "";
  }
  /// The middle of the tool is half a millimetre within each square.
  void ExpectNothingBeside() const {
    for (const ToolStep& step : Cuts()) {
      for (const Vec2& place : PlacesOn(step, 0.5)) {
        const double in_cell_mm = std::fmod(place.x() - kZero_mm.x(), kPlatePitch_mm);
        ASSERT_GT(in_cell_mm, 1.45) << place.transpose();
        ASSERT_LT(in_cell_mm, 8.55) << place.transpose();
      }
    }
  }

  CourseShop shop_{CourseShop::Machine::kMill};
};

TEST_P(ZeroOfAJob, AnotherOneRefusesTheArmUntilItIsBack) {
  ASSERT_NO_FATAL_FAILURE(Begin());
  ASSERT_NO_FATAL_FAILURE(SetZeroAt(7, 0, "x"));
  EXPECT_THAT(BegunJob(), HasSubstr("\"x\": 20"));
  const std::size_t cut = Cuts().size();
  if (GetParam()) {
    shop_.Close();
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
  }
  const auto is_refused = [&] {
    shop_.GoOn();
    return shop_.shown().find("the job was begun with 20.000, 5.000") !=
           std::string::npos;
  };
  EXPECT_TRUE(Eventually(is_refused, 30s)) << shop_.shown();
  EXPECT_EQ(Cuts().size(), cut) << "beside what is cut";
  ASSERT_NO_FATAL_FAILURE(SetZeroAt(-7, 0, "x"));
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  EXPECT_GT(Cuts().size(), cut);
  ExpectNothingBeside();
}

INSTANTIATE_TEST_SUITE_P(Of, ZeroOfAJob, ::testing::Bool(), [](const auto& one) {
  return one.param ? "all_services_restarted" : "a_pause";
});

}  // namespace
}  // namespace intaglio::testing
