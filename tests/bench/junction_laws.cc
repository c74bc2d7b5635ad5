#include "tests/bench/junction_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace intaglio::course {
namespace {

/// sin(h) / (1 - sin(h)); h is a right angle straight on.
double RadiusPerDeviation(double half_rad) {
  return std::sin(half_rad) / std::max(1e-12, 1 - std::sin(half_rad));
}

double HalfAngle(const Path& path, std::size_t node) {
  return (std::numbers::pi - std::abs(path.TurnAt(node))) / 2;
}

}  // namespace

std::vector<double> GrblNodeSpeeds(const Path& path, double deviation_mm,
                                   double acceleration_mm_s2) {
  std::vector<double> speeds;
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    speeds.push_back(std::sqrt(acceleration_mm_s2 * deviation_mm *
                               RadiusPerDeviation(HalfAngle(path, node))));
  }
  return speeds;
}

std::vector<double> KlipperNodeSpeeds(const Path& path, double square_corner_mm_s,
                                      double acceleration_mm_s2) {
  const double deviation_mm = square_corner_mm_s * square_corner_mm_s *
                              (std::numbers::sqrt2 - 1) / acceleration_mm_s2;
  std::vector<double> speeds = GrblNodeSpeeds(path, deviation_mm, acceleration_mm_s2);
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    const double tangent = std::tan(std::min(HalfAngle(path, node), 1.5707));
    const double shorter_mm =
        std::min(path.segments()[node - 1].length_mm, path.segments()[node].length_mm);
    speeds[node - 1] = std::min(speeds[node - 1],
                                std::sqrt(acceleration_mm_s2 * shorter_mm / 2 * tangent));
  }
  return speeds;
}

}  // namespace intaglio::course
