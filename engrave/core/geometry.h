#pragma once

// The few geometric types that every folder shares. Doubles throughout: at 4 kHz
// a coordinate rounded to 1 um already costs pulses.
// Frames (see docs/glossary.md): model (the file), glass (block, origin at the
// corner nearest the taught zero, z up, the beam comes from +z), machine (stage).

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

namespace intaglio {

inline constexpr double kTwoPi = 2 * std::numbers::pi;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// N points, one after another; the frame is named where they are used, mm.
using PointList = std::vector<Vec3>;

/// An axis-parallel box, mm. Empty when constructed: min > max.
struct Box3 {
  Vec3 min_mm = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max_mm = Vec3::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return (min_mm.array() > max_mm.array()).any(); }
  Vec3 size_mm() const { return empty() ? Vec3(Vec3::Zero()) : Vec3(max_mm - min_mm); }
  Vec3 center_mm() const { return 0.5 * (min_mm + max_mm); }
  void Extend(const Vec3& p_mm) {
    min_mm = min_mm.cwiseMin(p_mm);
    max_mm = max_mm.cwiseMax(p_mm);
  }
  void Extend(const Box3& other) {
    min_mm = min_mm.cwiseMin(other.min_mm);
    max_mm = max_mm.cwiseMax(other.max_mm);
  }
  bool Contains(const Vec3& p_mm) const {
    return (p_mm.array() >= min_mm.array()).all() &&
           (p_mm.array() <= max_mm.array()).all();
  }
};

/// A cloud of points to be engraved, as structure of arrays of equal length.
/// Frame glass, mm. `source` names the model (or curve, image) a point came
/// from, by its index in the job.
struct PointCloud {
  PointList points_mm;
  std::vector<std::uint32_t> source;

  std::size_t size() const { return points_mm.size(); }
  void Add(const Vec3& p_mm, std::uint32_t source_index) {
    points_mm.push_back(p_mm);
    source.push_back(source_index);
  }
};

}  // namespace intaglio
