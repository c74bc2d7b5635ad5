// Synthetic machines with known errors. The oracle moves a drive with play and lag along
// the rows and knows nothing of the fit: axes that are longer than they count, inclined,
// and a measurement that is turned and shifted.

#include "engrave/calibrate/machine_fit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace intaglio::calibrate {
namespace {

using testing::HasSubstr;

struct Truth {
  double x_scale = 1, y_scale = 1, squareness_rad = 0;
  Vec2 backlash_mm = Vec2::Zero(), lag_s = Vec2::Zero();
  double noise_mm = 0.003;
  double rotation_rad = 0;
  Vec2 offset_mm = Vec2::Zero();
};

/// Rows of both directions and two speeds at nine places.
std::vector<PassedMark> Marks(const Truth& truth, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, truth.noise_mm);
  std::vector<PassedMark> marks;
  for (int place = 0; place < 9; ++place) {
    for (int kind = 0; kind < 8; ++kind) {
      const int axis = kind / 4;
      const double speed_mm_s = kind % 4 < 2 ? 15 : 60, sense = kind % 2 == 0 ? 1 : -1;
      for (int i = 0; i < 6; ++i) {
        PassedMark mark;
        mark.place_mm = Vec2(5 + 17.0 * (place % 3), 5 + 17.0 * (place / 3));
        mark.place_mm[axis] += i * speed_mm_s / 50;
        mark.place_mm[1 - axis] += 0.6 * kind;
        mark.speed_mm_s[axis] = sense * speed_mm_s;
        mark.direction[axis] = sense;
        Vec2 axes = mark.place_mm;
        // The carriage is half the play behind its drive, and the drive late.
        axes -= 0.5 * truth.backlash_mm.cwiseProduct(mark.direction) +
                truth.lag_s.cwiseProduct(mark.speed_mm_s);
        const Vec2 y_axis(std::sin(truth.squareness_rad), std::cos(truth.squareness_rad));
        Vec2 at_mm =
            truth.x_scale * axes.x() * Vec2::UnitX() + truth.y_scale * axes.y() * y_axis;
        at_mm += Vec2(noise(random), noise(random));
        const double c = std::cos(truth.rotation_rad), s = std::sin(truth.rotation_rad);
        mark.measured_mm = truth.offset_mm + Vec2(c * at_mm.x() - s * at_mm.y(),
                                                  s * at_mm.x() + c * at_mm.y());
        marks.push_back(mark);
      }
    }
  }
  return marks;
}

Truth Wrong() {
  Truth truth;
  truth.x_scale = 1.0004;
  truth.y_scale = 0.9993;
  truth.squareness_rad = 0.0005;
  truth.backlash_mm = Vec2(0.012, 0.007);
  truth.lag_s = Vec2(0.0003, 0.0001);
  truth.rotation_rad = 0.6;
  truth.offset_mm = Vec2(3, -4);
  return truth;
}

TEST(MachineFit, FindsEveryErrorWithoutNoise) {
  Truth truth = Wrong();
  truth.noise_mm = 0;
  const auto fit = FitMachine(Marks(truth, 1));
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_NEAR(fit->axes[0].scale_ratio.value, 1.0004, 1e-9);
  EXPECT_NEAR(fit->axes[1].scale_ratio.value, 0.9993, 1e-9);
  EXPECT_NEAR(fit->squareness_rad.value, 0.0005, 1e-9);
  EXPECT_NEAR(fit->rotation_rad, 0.6, 1e-9);
  // Backlash and lag are along axes that are 4e-4 longer and 5e-4 inclined.
  EXPECT_NEAR(fit->axes[0].backlash_mm.value, 0.012, 1e-5);
  EXPECT_NEAR(fit->axes[1].backlash_mm.value, 0.007, 1e-5);
  EXPECT_NEAR(fit->axes[0].lag_s.value, 0.0003, 1e-6);
  EXPECT_NEAR(fit->axes[1].lag_s.value, 0.0001, 1e-6);
  EXPECT_EQ(fit->axes[0].rejected_count, 0);
}

// Nine figures over many machines: each within its interval in 95 of 100, and the
// repeatability is that of the noise. Of 200 draws with p = 0.95 fewer than 178 come with
// a probability of 3e-4.
TEST(MachineFit, IntervalsHoldWhatTheyPromise) {
  constexpr int kMachines = 200;
  std::array<int, 9> covered{};
  double widest_scale = 0;
  for (unsigned seed = 0; seed < kMachines; ++seed) {
    const Truth truth = Wrong();
    const auto fit = FitMachine(Marks(truth, 100 + seed));
    ASSERT_TRUE(fit);
    const auto& [x, y] = fit->axes;
    const std::array<std::pair<Figure, double>, 9> figures = {
        {{x.scale_ratio, truth.x_scale},
         {y.scale_ratio, truth.y_scale},
         {fit->squareness_rad, truth.squareness_rad},
         {x.backlash_mm, truth.backlash_mm.x()},
         {y.backlash_mm, truth.backlash_mm.y()},
         {x.lag_s, truth.lag_s.x()},
         {y.lag_s, truth.lag_s.y()},
         {x.repeatability_mm, truth.noise_mm},
         {y.repeatability_mm, truth.noise_mm}}};
    for (std::size_t i = 0; i < figures.size(); ++i) {
      const auto& [figure, true_value] = figures[i];
      covered[i] += std::abs(figure.value - true_value) <= figure.interval95 ? 1 : 0;
    }
    widest_scale = std::max(widest_scale, x.scale_ratio.interval95);
  }
  for (const int count : covered) EXPECT_GE(count, 178);
  // Intervals so wide that they hold anything would prove nothing: 3 um of noise over
  // 216 marks that spread by 14 mm are 1.5e-5.
  EXPECT_LT(widest_scale, 5e-5);
}

TEST(MachineFit, LeavesOutMarksThatDoNotBelong) {
  const Truth truth = Wrong();
  auto marks = Marks(truth, 5);
  std::mt19937 random(9);
  for (int i = 0; i < 40; ++i) {  // of 432: dust, and neighbours that were taken for them
    marks[random() % marks.size()].measured_mm += Vec2(0.3, -0.6);
  }
  const auto fit = FitMachine(marks);
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->axes[0].rejected_count, 10);
  EXPECT_NEAR(fit->axes[0].scale_ratio.value, 1.0004, 5e-5);
  EXPECT_NEAR(fit->axes[1].backlash_mm.value, 0.007, 0.002);
  EXPECT_NEAR(fit->axes[0].repeatability_mm.value, 0.003, 0.0006);
}

// Measured again with what was found: nothing is left, and the figures of a profile are
// the whole ones.
TEST(MachineFit, WhatIsKnownIsIncluded) {
  Truth left;  // of a machine that is corrected already
  left.noise_mm = 0;
  const auto fit = FitMachine(Marks(left, 1), {1.0004, 0.9993, 0.0005});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->axes[0].scale_ratio.value, 1.0004, 1e-12);
  EXPECT_NEAR(fit->axes[1].scale_ratio.value, 0.9993, 1e-12);
  EXPECT_NEAR(fit->squareness_rad.value, 0.0005, 1e-12);
}

TEST(MachineFit, NamesWhatIsMissing) {
  const auto error = [](const auto& wanted) {
    std::vector<PassedMark> some;
    for (const PassedMark& mark : Marks(Wrong(), 3)) {
      if (wanted(mark)) some.push_back(mark);
    }
    const auto fit = FitMachine(some);
    return fit ? "" : fit.error().message;
  };
  EXPECT_THAT(error([](const PassedMark& m) { return m.direction.sum() > 0; }),
              HasSubstr("axis x: the marks were passed in one direction"));
  EXPECT_THAT(error([](const PassedMark& m) { return m.speed_mm_s.norm() > 30; }),
              HasSubstr("at one speed; measure slow and fast rows"));
  EXPECT_THAT(error([](const PassedMark& m) { return m.direction.x() != 0; }),
              HasSubstr("axis y: there are too few marks"));
  EXPECT_THAT(error([](const PassedMark&) { return false; }), HasSubstr("too few"));
  auto marks = Marks(Wrong(), 3);
  marks[7].measured_mm.x() = std::nan("");
  EXPECT_THAT(FitMachine(marks).error().message, HasSubstr("mark 7 has a coordinate"));
}

}  // namespace
}  // namespace intaglio::calibrate
