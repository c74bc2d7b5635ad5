#include "tests/engrave/course/cut_program.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "engrave/course/speed_law.h"

namespace intaglio::course {
namespace {

using Points = std::vector<Vec2>;
constexpr double kPi = std::numbers::pi;

/// Numbers of one seed; the same with every standard library.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int Whole(int from, int below) {
    return from + static_cast<int>(engine_() % static_cast<std::uint64_t>(below - from));
  }
  double Sign() { return Uniform(0, 1) < 0.5 ? -1 : 1; }

 private:
  std::mt19937_64 engine_;
};

Vec2 Polar(double radius_mm, double angle_rad) {
  return {radius_mm * std::cos(angle_rad), radius_mm * std::sin(angle_rad)};
}

Points Rectangle(Draws& draws) {
  const double w = draws.Uniform(15, 90), h = draws.Uniform(15, 60);
  const double angle = draws.Uniform(0, 1) < 0.7 ? 0 : draws.Uniform(0, kPi);
  const Vec2 u = Polar(w, angle), v = Polar(h, angle + kPi / 2);
  return {Vec2(0, 0), u, u + v, v, Vec2(0, 0)};
}

Points Gear(Draws& draws) {
  const int teeth = draws.Whole(10, 24);
  const double r = draws.Uniform(12, 30), tip = r + draws.Uniform(2, 5);
  const std::array<std::pair<double, double>, 4> tooth{
      {{-0.30, r}, {-0.18, tip}, {0.18, tip}, {0.30, r}}};
  Points points;
  for (int i = 0; i < teeth; ++i)
    for (const auto& [at, radius] : tooth)
      points.push_back(Polar(radius, 2 * kPi * (i + at) / teeth));
  points.push_back(points.front());
  return points;
}

/// A closed curve with two to five lobes, in chords of equal length.
Points Curve(Draws& draws) {
  const double size = draws.Uniform(8, 35), chord = draws.Uniform(0.8, 2.5);
  std::array<double, 4> depth{}, phase{};
  for (int k = 2; k < 6; ++k) {
    depth[static_cast<std::size_t>(k - 2)] = draws.Uniform(0, 0.25 / k);
    phase[static_cast<std::size_t>(k - 2)] = draws.Uniform(0, 2 * kPi);
  }
  const auto at = [&](double t) {
    double r = 1;
    for (int k = 2; k < 6; ++k)
      r += depth[static_cast<std::size_t>(k - 2)] *
           std::cos(k * t + phase[static_cast<std::size_t>(k - 2)]);
    return Polar(size * r, t);
  };
  Points points{at(0)};
  constexpr int kSteps = 40000;
  for (int i = 1; i < kSteps; ++i) {
    const Vec2 p = at(2 * kPi * i / kSteps);
    if ((p - points.back()).norm() >= chord) points.push_back(p);
  }
  if ((points.front() - points.back()).norm() < chord / 2) points.pop_back();
  points.push_back(points.front());
  return points;
}

Points Ornament(Draws& draws) {
  Points points{Vec2(0, 0)};
  double direction = draws.Uniform(0, 2 * kPi);
  const int legs = draws.Whole(20, 60);
  for (int i = 0; i < legs; ++i) {
    direction += draws.Sign() * draws.Uniform(0.2, 2.0);
    points.push_back(points.back() + Polar(draws.Uniform(2, 12), direction));
  }
  return points;
}

}  // namespace

AxisPair MeasuredMachine(LoopKind loop) { return TunedAxes(150, 220, 0.3, 0.3, loop); }

PlanOptions CompensatedOptions(double motor_mm_s2) {
  PlanOptions options;
  options.compensate = true;
  options.acceleration_mm_s2 = 1e6;
  options.motor_mm_s2 = motor_mm_s2;
  return options;
}

Path PolylinePath(const std::vector<Vec2>& points_mm, double feed_mm_s) {
  std::vector<Piece> pieces;
  for (std::size_t i = 1; i < points_mm.size(); ++i)
    pieces.push_back({points_mm[i], feed_mm_s});
  return Path::Make(points_mm.front(), pieces).value();
}

Path CornerPath(double angle_rad, double turn_rad, double leg_mm, double feed_mm_s) {
  return PolylinePath(
      {-Polar(leg_mm, angle_rad), Vec2(0, 0), Polar(leg_mm, angle_rad + turn_rad)},
      feed_mm_s);
}

std::vector<Path> CutProgram(double length_m, double feed_mm_s, std::uint64_t seed,
                             const ProgramMix& mix) {
  Draws draws(seed);
  std::vector<Path> program;
  const std::array<std::pair<double, std::function<Points(Draws&)>>, 4> kinds{
      {{mix.rectangles, Rectangle},
       {mix.gears, Gear},
       {mix.curves, Curve},
       {mix.ornaments, Ornament}}};
  for (const auto& [share, draw] : kinds) {
    for (double made_mm = 0; made_mm < share * length_m * 1000;) {
      program.push_back(PolylinePath(draw(draws), feed_mm_s));
      made_mm += program.back().length_mm();
    }
  }
  return program;
}

Path JoinedPath(const std::vector<Path>& program, std::size_t max_segments) {
  std::vector<Segment> segments;
  Vec2 at_mm = Vec2::Zero();
  for (const Path& path : program) {
    const Vec2 move_mm = at_mm - path.node_mm(0);
    for (Segment segment : path.segments()) {
      if (segments.size() == max_segments) break;
      segment.begin_mm += move_mm;
      segment.end_mm += move_mm;
      segments.push_back(segment);
    }
    at_mm = segments.back().end_mm;
  }
  return Path::Of(std::move(segments));
}

double LengthMm(const std::vector<Path>& program) {
  double sum_mm = 0;
  for (const Path& path : program) sum_mm += path.length_mm();
  return sum_mm;
}

std::size_t SegmentCount(const std::vector<Path>& program) {
  std::size_t sum = 0;
  for (const Path& path : program) sum += path.segment_count();
  return sum;
}

double StoppingDurationS(const std::vector<Path>& program, double acceleration_mm_s2) {
  double sum_s = 0;
  for (const Path& path : program) {
    const std::vector<double> stops(path.node_count() - 2, 0);
    sum_s += PlanSpeeds(path, stops, acceleration_mm_s2).duration_s;
  }
  return sum_s;
}

}  // namespace intaglio::course
