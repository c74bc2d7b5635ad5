#include "engrave/proof/crack_risk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

constexpr double kRadiusInLengths = 2;
constexpr double kApartInRadii = 4;
constexpr double kApartInDiagonals = 0.1;
constexpr std::size_t kBallsPerTask = 4096;
// A ball with so many points is beyond any limit; counting further would take quadratic
// time.
constexpr std::uint32_t kMaxPlacesCounted = 4096;

double SphereVolume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

/// Counts the points in the ball of each place.
std::vector<std::uint32_t> CountInBalls(const DistinctPlaces& places,
                                        const std::vector<std::uint32_t>& points_of,
                                        const PointTree& tree, double radius_mm,
                                        const Executor& executor) {
  const std::size_t count = places.places_mm.size();
  std::vector<std::uint32_t> in_ball(count, 0);
  RunEach(executor, (count + kBallsPerTask - 1) / kBallsPerTask, [&](std::size_t task) {
    const std::size_t end = std::min(count, (task + 1) * kBallsPerTask);
    for (std::size_t at = task * kBallsPerTask; at < end; ++at) {
      std::uint32_t points = 0, met = 0;
      tree.ForEachWithin(places.places_mm[at], radius_mm * radius_mm,
                         [&](std::uint32_t place, double) {
                           points += points_of[place];
                           return ++met < kMaxPlacesCounted;
                         });
      in_ball[at] = points;
    }
  });
  return in_ball;
}

}  // namespace

CrackRisk MeasureCrackRisk(const DistinctPlaces& places, const PointTree& tree,
                           const CrackRiskOptions& options) {
  Require(options.crack_diameter_mm > 0 && options.crack_length_mm > 0 &&
              options.max_share > 0,
          "cracks of {} x {} mm, share {}", options.crack_diameter_mm,
          options.crack_length_mm, options.max_share);
  Require(!places.places_mm.empty(), "there are no points to measure");
  CrackRisk risk;
  risk.max_share = options.max_share;
  risk.ball_radius_mm = kRadiusInLengths * options.crack_length_mm;
  const double ball_mm3 = SphereVolume(risk.ball_radius_mm);
  const double crack_mm3 = SphereVolume(0.5) * options.crack_diameter_mm *
                           options.crack_diameter_mm * options.crack_length_mm;
  const std::vector<std::uint32_t> points_of = PointsPerPlace(places);
  const std::vector<std::uint32_t> in_ball =
      CountInBalls(places, points_of, tree, risk.ball_radius_mm, options.executor);
  const auto dense_place = [&](std::uint32_t at) {
    const double cracks = in_ball[at];
    return DensePlace{places.places_mm[at], in_ball[at], cracks / ball_mm3,
                      cracks * crack_mm3 / ball_mm3};
  };
  const auto densest = std::max_element(in_ball.begin(), in_ball.end());
  risk.densest = dense_place(static_cast<std::uint32_t>(densest - in_ball.begin()));

  std::vector<std::uint32_t> risky;
  for (std::uint32_t at = 0; at < in_ball.size(); ++at) {
    if (in_ball[at] * crack_mm3 <= options.max_share * ball_mm3) continue;
    risky.push_back(at);
    risk.risky_count += points_of[at];
  }
  std::stable_sort(risky.begin(), risky.end(), [&](std::uint32_t a, std::uint32_t b) {
    return in_ball[a] > in_ball[b];
  });
  Box3 box;
  for (const Vec3& p : places.places_mm) box.Extend(p);
  const double apart_mm = std::max(kApartInRadii * risk.ball_radius_mm,
                                   kApartInDiagonals * box.size_mm().norm());
  for (const std::uint32_t at : risky) {
    if (risk.worst.size() == options.max_places) break;
    const bool apart =
        std::all_of(risk.worst.begin(), risk.worst.end(), [&](const DensePlace& other) {
          return (other.place_mm - places.places_mm[at]).norm() >= apart_mm;
        });
    if (apart) risk.worst.push_back(dense_place(at));
  }
  return risk;
}

}  // namespace intaglio::proof
