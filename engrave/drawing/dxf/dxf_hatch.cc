#include "engrave/drawing/dxf/dxf_hatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/drawing/dxf/dxf_curves.h"
#include "engrave/drawing/dxf/dxf_spline.h"
#include "engrave/drawing/pieces.h"

// The groups of a HATCH in their order: elevation 30; 70 solid or not; 91; for each path
// 92 with its flags, then 10 20 [42] of each vertex, or for each edge 72 with its type
// and its groups; 97 and 330, its source objects; then 75 or 76, the pattern, and 98 with
// seed points, whose codes are those of vertices.

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

// Flag bits of group 92.
constexpr int kByVertices = 2;
constexpr int kFrameOfText = 8;

constexpr int kLine = 1, kArc = 2, kEllipse = 3, kSpline = 4;  // group 72
// Tolerance of joined edges: their end points agree to the digits of the file.
constexpr double kGapRatio = 1e-6;

int WholeOf(double number) {
  return number >= 0 && number < 65536 ? static_cast<int>(number) : 0;
}

class HatchReader {
 public:
  HatchReader(const DxfEntity& entity, DrawingBuilder& builder, DxfHatch& hatch)
      : entity_(entity), builder_(builder), hatch_(hatch) {}

  bool Read() {
    DxfGroups groups(entity_.groups, builder_);
    DxfGroup group;
    while (groups.Next(group)) {
      if (!TakeCommon(group, entity_, builder_, hatch_.common)) return false;
      if (group.code < 10 || group.code >= 100 || group.code == 62) continue;
      double number = 0;
      if (!DxfNumber(group, entity_, builder_, number)) return false;
      if (!Consume(group.code, number)) return false;
    }
    if (!groups.good() || !EndPath()) return false;
    ToWorld();
    return true;
  }

 private:
  bool Consume(int code, double number) {
    if (code == 92) return EndPath() && BeginPath(WholeOf(number));
    if (code == 75 || code == 76 || code == 98) return EndPath();
    if (!in_path_) {
      if (code == 30) elevation_ = number;
      if (code == 70) hatch_.has_lines = number == 0;
      return true;
    }
    if ((flags_ & kByVertices) != 0) return TakeOfVertices(code, number);
    if (code != 72) return TakeOfEdge(code, number);
    if (!EndEdge()) return false;
    edge_ = WholeOf(number);
    return true;
  }

  bool BeginPath(int flags) {
    in_path_ = true;
    flags_ = flags;
    return builder_.CountEntity(entity_.Place());
  }

  bool TakeOfVertices(int code, double number) {
    if (code == 10) {
      if (!CountStored(1)) return false;
      vertices_.emplace_back().p.x() = number;
    } else if (code == 20 && !vertices_.empty()) {
      vertices_.back().p.y() = number;
    } else if (code == 42 && !vertices_.empty()) {
      vertices_.back().bulge = number;
      return CountStored(2);
    }
    return true;
  }

  /// Points of all paths, before they are stored.
  bool CountStored(std::uint64_t points) {
    stored_ += points;
    return stored_ <= builder_.limits().max_points ||
           builder_.CountPoints(stored_, entity_.Place());
  }

  bool TakeOfEdge(int code, double number) {
    if (edge_ == kSpline) {
      // Degree and weights have other codes than in a SPLINE; counts do not matter.
      if (code == 94) code = 71;
      if (code == 42) code = 41;
      return code > 71 || spline_.Consume(code, number, entity_, builder_);
    }
    if (code < 80) values_[static_cast<std::size_t>(code)] = number;
    return true;
  }

  Vec3 Point(std::size_t code) const { return {values_[code], values_[code + 10], 0}; }

  bool EndEdge() {
    if (edge_ == 0) return true;
    if (!CountStored(3)) return false;
    bool good = true;
    if (edge_ == kLine) {
      pieces_.push_back(Polyline{{Point(10), Point(11)}});
    } else if (edge_ == kArc) {
      AddArc(values_[40] * Vec3::UnitX(), values_[40] * Vec3::UnitY());
    } else if (edge_ == kEllipse) {
      const Vec3 major = Point(11);
      AddArc(major, values_[40] * Vec3(-major.y(), major.x(), 0));
    } else if (edge_ == kSpline) {
      good = spline_.AddPieces(entity_, builder_, pieces_);
    }
    values_ = {};
    spline_ = {};
    edge_ = 0;
    return good;
  }

  /// From 50 to 51, in degrees of the parameter. Clockwise, both count clockwise too.
  void AddArc(const Vec3& u, const Vec3& v) {
    if (!(u.norm() > 0) || !(v.norm() > 0)) return;
    const double turn = values_[73] != 0 ? 1 : -1;
    const double begin = std::fmod(values_[50], 360) * pi / 180;
    const double end = std::fmod(values_[51], 360) * pi / 180;
    pieces_.push_back(
        EllipticArc{Point(10), u, v, turn * begin, turn * DxfSweep(begin, end)});
  }

  bool EndPath() {
    if (!EndEdge()) return false;
    const bool drawn = std::exchange(in_path_, false) && (flags_ & kFrameOfText) == 0;
    std::vector<Piece> pieces = std::exchange(pieces_, {});
    const std::vector<DxfVertex> vertices = std::exchange(vertices_, {});
    if (!drawn) return true;
    if (!DxfPolyline(vertices, true, entity_, builder_, pieces)) return false;
    if (pieces.empty()) return true;
    if (Joins(pieces)) {
      hatch_.contours.push_back({std::move(pieces), true});
      return true;
    }
    for (Piece& piece : pieces) {
      if (!builder_.CountEntity(entity_.Place())) return false;
      hatch_.contours.push_back({{std::move(piece)}, false});
    }
    return true;
  }

  /// Whether each piece begins where the one before it ends, and the first at the last.
  static bool Joins(const std::vector<Piece>& pieces) {
    double longest = 0, widest_gap = 0;
    Vec3 end = EndOf(pieces.back());
    const Vec3 origin = end;
    for (const Piece& piece : pieces) {
      const Vec3 begin = BeginOf(piece);
      widest_gap = std::max(widest_gap, (begin - end).norm());
      end = EndOf(piece);
      longest = std::max({longest, (begin - origin).norm(), (end - begin).norm()});
    }
    return pieces.size() == 1 || widest_gap <= kGapRatio * longest;
  }

  void ToWorld() {
    const Mat3 world = WorldFromEntity(hatch_.common.extrusion);
    const Vec3 offset = world * Vec3(0, 0, elevation_);
    for (Curve& contour : hatch_.contours) {
      for (Piece& piece : contour.pieces) Transform(world, offset, piece);
    }
  }

  const DxfEntity& entity_;
  DrawingBuilder& builder_;
  DxfHatch& hatch_;
  std::uint64_t stored_ = 0;
  double elevation_ = 0;
  bool in_path_ = false;
  int flags_ = 0;
  int edge_ = 0;
  std::array<double, 80> values_{};
  DxfSpline spline_;
  std::vector<DxfVertex> vertices_;
  std::vector<Piece> pieces_;
};

}  // namespace

bool ReadDxfHatch(const DxfEntity& entity, DrawingBuilder& builder, DxfHatch& hatch) {
  return HatchReader(entity, builder, hatch).Read();
}

}  // namespace intaglio::drawing
