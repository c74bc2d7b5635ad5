#include "engrave/drawing/dxf/dxf_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/drawing/dxf/dxf_spline.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

// Flag bits of group 70.
constexpr int kClosed = 1;
constexpr int k3dPolyline = 8;
constexpr int kMesh = 16;
constexpr int kPolyface = 64;
constexpr int kFrameVertex = 16;  // of a VERTEX: control point of a smoothed polyline

// tan(1e-6) of a quarter of the sweep: less than 1 nm away from the line in a chord of 2
// mm, and a radius that no drawing uses on purpose.
constexpr double kMinBulge = 1e-6;

double Radians(double degrees) { return degrees * pi / 180; }

struct Values {
  std::array<double, 80> number{};
  std::array<bool, 80> has{};
  std::size_t vertex_count = 0;

  Vec3 Point(std::size_t code) const {
    return {number[code], number[code + 10], number[code + 20]};
  }
  int Flags() const {
    return number[70] >= 0 && number[70] < 65536 ? static_cast<int>(number[70]) : 0;
  }
};

/// Calls visit(code, number) for the numbers of the entity up to its first vertex.
template <typename Visit>
bool ForEachNumber(const DxfEntity& entity, DrawingBuilder& builder, DxfCommon& common,
                   const Visit& visit) {
  DxfGroups groups(entity.groups, builder);
  DxfGroup group;
  while (groups.Next(group)) {
    if (!TakeCommon(group, entity, builder, common)) return false;
    if (group.code < 10 || group.code >= 80 || group.code == 62) continue;
    double number = 0;
    if (!DxfNumber(group, entity, builder, number)) return false;
    if (!visit(group.code, number)) return false;
  }
  return groups.good();
}

bool ReadValues(const DxfEntity& entity, DrawingBuilder& builder, DxfCommon& common,
                Values& values) {
  return ForEachNumber(entity, builder, common, [&](int code, double number) {
    values.number[static_cast<std::size_t>(code)] = number;
    values.has[static_cast<std::size_t>(code)] = true;
    return true;
  });
}

bool CircleOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  Values v;
  if (!ReadValues(entity, builder, result.common, v)) return false;
  const double radius = v.number[40];
  if (!(radius > 0)) {
    result.wrong = "without a radius";
    return true;
  }
  const bool full = entity.type == "CIRCLE";
  const double begin = full ? 0 : Radians(v.number[50]);
  const double sweep = full ? 2 * pi : DxfSweep(begin, Radians(v.number[51]));
  EllipticArc arc{v.Point(10), radius * Vec3::UnitX(), radius * Vec3::UnitY(),
                  std::fmod(begin, 2 * pi), sweep};
  result.curve.closed = full;
  result.curve.pieces.push_back(arc);
  Transform(WorldFromEntity(result.common.extrusion), Vec3::Zero(),
            result.curve.pieces.front());
  return true;
}

bool EllipseOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  Values v;
  if (!ReadValues(entity, builder, result.common, v)) return false;
  const double ratio = v.number[40];
  const Vec3 major = v.Point(11);
  if (!(std::abs(ratio) > 0) || !(major.norm() > 0)) {
    result.wrong = "without a width";
    return true;
  }
  const Vec3 minor = ratio * WorldFromEntity(result.common.extrusion).col(2).cross(major);
  const double begin = v.number[41];
  const double sweep = DxfSweep(begin, v.has[42] ? v.number[42] : begin + 2 * pi);
  result.curve.closed = sweep > 2 * pi - 1e-9;
  result.curve.pieces.push_back(
      EllipticArc{v.Point(10), major, minor, std::fmod(begin, 2 * pi), sweep});
  return true;
}

/// The curve through the vertices; `in_plane`: their coordinates are the entity's own.
bool TakeVertices(const std::vector<DxfVertex>& vertices, bool closed, bool in_plane,
                  const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  result.curve.closed = closed && vertices.size() > 1;
  if (!DxfPolyline(vertices, result.curve.closed, entity, builder, result.curve.pieces)) {
    return false;
  }
  if (in_plane) {
    const Mat3 world = WorldFromEntity(result.common.extrusion);
    for (Piece& piece : result.curve.pieces) Transform(world, Vec3::Zero(), piece);
  }
  return true;
}

bool LightPolylineOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  std::vector<DxfVertex> vertices;
  double elevation = 0, flags = 0;
  const auto visit = [&](int code, double number) {
    if (code == 10) {
      if (vertices.size() > builder.limits().max_points) {
        return builder.CountPoints(vertices.size(), entity.Place());
      }
      vertices.emplace_back().p.x() = number;
    } else if (code == 38) {
      elevation = number;
    } else if (code == 70) {
      flags = number;
    } else if (!vertices.empty() && code == 20) {
      vertices.back().p.y() = number;
    } else if (!vertices.empty() && code == 42) {
      vertices.back().bulge = number;
    }
    return true;
  };
  if (!ForEachNumber(entity, builder, result.common, visit)) return false;
  for (DxfVertex& vertex : vertices) vertex.p.z() = elevation;
  const bool closed = (static_cast<int>(std::clamp(flags, 0.0, 255.0)) & kClosed) != 0;
  return TakeVertices(vertices, closed, true, entity, builder, result);
}

/// The groups of a POLYLINE in parts: its own, then those of each VERTEX.
bool PolylineOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  DxfGroups groups(entity.groups, builder);
  DxfGroup group;
  Values own, part;
  DxfCommon of_vertex;
  std::vector<DxfVertex> vertices;
  bool in_vertex = false;
  const auto take_vertex = [&] {
    if (!in_vertex || (part.Flags() & kFrameVertex) != 0) return true;
    if (vertices.size() > builder.limits().max_points) {
      return builder.CountPoints(vertices.size(), entity.Place());
    }
    vertices.push_back({part.Point(10), part.number[42]});
    return true;
  };
  while (groups.Next(group)) {
    if (group.code == 0) {
      if (!take_vertex()) return false;
      part = Values();
      in_vertex = group.value == "VERTEX";
      if (!in_vertex) break;
      continue;
    }
    DxfCommon& common = in_vertex ? of_vertex : result.common;
    if (!TakeCommon(group, entity, builder, common)) return false;
    if (group.code < 10 || group.code >= 80 || group.code == 62) continue;
    Values& values = in_vertex ? part : own;
    if (!DxfNumber(group, entity, builder,
                   values.number[static_cast<std::size_t>(group.code)])) {
      return false;
    }
  }
  if (!groups.good() || !take_vertex()) return false;
  const int flags = own.Flags();
  if ((flags & (kMesh | kPolyface)) != 0) return true;
  const bool in_space = (flags & k3dPolyline) != 0;
  for (DxfVertex& vertex : vertices) {
    if (in_space) {
      vertex.bulge = 0;
    } else {
      vertex.p.z() = own.number[30];
    }
  }
  return TakeVertices(vertices, (flags & kClosed) != 0, !in_space, entity, builder,
                      result);
}

bool SplineOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  DxfSpline spline;
  const auto visit = [&](int code, double number) {
    return spline.Consume(code, number, entity, builder);
  };
  return ForEachNumber(entity, builder, result.common, visit) &&
         spline.AddPieces(entity, builder, result.curve.pieces);
}

bool LineOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  Values v;
  if (!ReadValues(entity, builder, result.common, v)) return false;
  Polyline line{{v.Point(10)}};
  if (entity.type == "LINE") line.points_mm.push_back(v.Point(11));
  result.curve.pieces.push_back(std::move(line));
  return true;
}

using CurveReader = bool (*)(const DxfEntity&, DrawingBuilder&, DxfCurve&);
constexpr std::pair<std::string_view, CurveReader> kReaders[] = {
    {"LINE", LineOf},         {"ARC", CircleOf},    {"LWPOLYLINE", LightPolylineOf},
    {"POLYLINE", PolylineOf}, {"CIRCLE", CircleOf}, {"SPLINE", SplineOf},
    {"ELLIPSE", EllipseOf},   {"POINT", LineOf}};

CurveReader ReaderOf(std::string_view type) {
  for (const auto& [name, reader] : kReaders) {
    if (name == type) return reader;
  }
  return nullptr;
}

}  // namespace

bool IsDxfCurve(std::string_view type) { return ReaderOf(type) != nullptr; }

bool DxfCurveOf(const DxfEntity& entity, DrawingBuilder& builder, DxfCurve& result) {
  return ReaderOf(entity.type)(entity, builder, result);
}

bool DxfPolyline(const std::vector<DxfVertex>& vertices, bool closed,
                 const DxfEntity& entity, DrawingBuilder& builder,
                 std::vector<Piece>& pieces) {
  const std::size_t n = vertices.size();
  if (n == 0) return true;
  const auto bulged = static_cast<std::size_t>(
      std::ranges::count_if(vertices, [](const DxfVertex& v) { return v.bulge != 0; }));
  if (2 * bulged + n > builder.limits().max_points) {
    return builder.CountPoints(builder.limits().max_points + 1, entity.Place());
  }
  pieces.reserve(2 * bulged + 1);
  Polyline straight;
  for (std::size_t i = 0; i < (closed ? n : n - 1); ++i) {
    const DxfVertex& from = vertices[i];
    const Vec3& to = vertices[(i + 1) % n].p;
    Piece piece = BulgedSegment(from.p, to, from.bulge);
    if (std::holds_alternative<Polyline>(piece)) {
      if (straight.points_mm.empty()) straight.points_mm.push_back(from.p);
      straight.points_mm.push_back(to);
      continue;
    }
    if (!straight.points_mm.empty()) pieces.push_back(std::exchange(straight, {}));
    pieces.push_back(std::move(piece));
  }
  if (!straight.points_mm.empty()) pieces.push_back(std::move(straight));
  if (pieces.empty()) pieces.push_back(Polyline{{vertices.front().p}});
  return true;
}

double DxfSweep(double begin_rad, double end_rad) {
  const double sweep = std::fmod(end_rad - begin_rad, 2 * pi);
  return sweep > 1e-12 ? sweep : sweep + 2 * pi;
}

Piece BulgedSegment(const Vec3& p, const Vec3& q, double bulge) {
  const Vec3 chord = q - p;
  if (!(std::abs(bulge) >= kMinBulge) || !(chord.norm() > 0)) return Polyline{{p, q}};
  const Vec3 left(-chord.y(), chord.x(), 0);
  const Vec3 center = p + 0.5 * chord + left * ((1 - bulge * bulge) / (4 * bulge));
  const Vec3 u = p - center;
  return EllipticArc{center, u, {-u.y(), u.x(), 0}, 0, 4 * std::atan(bulge)};
}

}  // namespace intaglio::drawing
