#include "engrave/contour/element.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kStepsPerMm = 1e6;  // 1 nm
constexpr double kNode_mm = 1e-4;
constexpr double kMaxCoordinate_mm = 10'000;
constexpr double kJoint_mm = 1e-3;

std::string At(const Vec2& place_mm) {
  return fmt::format("({:.6g}, {:.6g})", place_mm.x(), place_mm.y());
}

struct Description {
  std::string operator()(const Circle& s) const {
    return fmt::format("round pad {:.6g} at {}", s.diameter_mm, At(s.center_mm));
  }
  std::string operator()(const Square& s) const {
    return fmt::format("square pad {:.6g} at {}", s.side_mm, At(s.center_mm));
  }
  std::string operator()(const Octagon& s) const {
    return fmt::format("octagon pad {:.6g} at {}", s.size_mm, At(s.center_mm));
  }
  std::string operator()(const Track& s) const {
    return fmt::format("track {:.6g} from {} to {}", s.width_mm, At(s.begin_mm),
                       At(s.end_mm));
  }
  std::string operator()(const ArcTrack& s) const {
    return fmt::format("arc track {:.6g} from {} to {}", s.width_mm, At(s.arc.begin_mm),
                       At(s.arc.end_mm));
  }
  std::string operator()(const Outline& s) const {
    if (s.loops.empty() || s.loops[0].empty()) return "empty outline";
    return fmt::format("outline from {}", At(s.loops[0][0].begin_mm));
  }
};

double Rounded_mm(double value_mm) {
  return std::round(value_mm * kStepsPerMm) / kStepsPerMm;
}

Vec2 Rounded_mm(const Vec2& point_mm) {
  return {Rounded_mm(point_mm.x()), Rounded_mm(point_mm.y())};
}

bool IsUsable(double value_mm) { return std::abs(value_mm) <= kMaxCoordinate_mm; }
bool IsUsable(const Vec2& p_mm) { return IsUsable(p_mm.x()) && IsUsable(p_mm.y()); }
bool IsUsable(const Edge& edge) {
  return IsUsable(edge.begin_mm) && IsUsable(edge.end_mm) && IsUsable(edge.center_mm) &&
         IsUsable(edge.radius_mm) && std::abs(edge.sweep_rad) < 6.3;
}

/// Places that elements share, in squares as wide as the distance of merging.
class Nodes {
 public:
  Vec2 Merged(const Vec2& exact_mm) {
    const Vec2 place = Rounded_mm(exact_mm);
    const auto x = static_cast<std::int64_t>(std::floor(place.x() / kNode_mm));
    const auto y = static_cast<std::int64_t>(std::floor(place.y() / kNode_mm));
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = nodes_.find(Key(x + dx, y + dy));
        if (found == nodes_.end()) continue;
        for (const Vec2& node : found->second) {
          if ((node - place).norm() < kNode_mm) return node;
        }
      }
    }
    nodes_[Key(x, y)].push_back(place);
    return place;
  }

 private:
  static std::uint64_t Key(std::int64_t x, std::int64_t y) {
    return (static_cast<std::uint64_t>(x) << 32) ^
           (static_cast<std::uint64_t>(y) & 0xFFFFFFFF);
  }
  std::unordered_map<std::uint64_t, std::vector<Vec2>> nodes_;
};

Edge WithEnds(const Edge& edge, const Vec2& begin_mm, const Vec2& end_mm) {
  if (!edge.is_arc()) return MakeLine(begin_mm, end_mm);
  Edge moved = MakeArcBetween(begin_mm, end_mm, edge.center_mm, edge.sweep_rad > 0);
  // The ends of a full circle stay one place; those of a short arc stay two.
  if (std::abs(std::abs(moved.sweep_rad) - std::abs(edge.sweep_rad)) > 1) return edge;
  return moved;
}

/// Checks and rounds one shape; the message of what is wrong, empty when nothing is.
class Rounding {
 public:
  std::string operator()(Circle& s) { return Pad(s.center_mm, s.diameter_mm); }
  std::string operator()(Square& s) { return Pad(s.center_mm, s.side_mm); }
  std::string operator()(Octagon& s) { return Pad(s.center_mm, s.size_mm); }
  std::string operator()(Track& s) {
    if (!IsUsable(s.begin_mm) || !IsUsable(s.end_mm)) return Coordinates();
    s.begin_mm = nodes_.Merged(s.begin_mm);
    s.end_mm = nodes_.Merged(s.end_mm);
    return Size(s.width_mm);
  }
  std::string operator()(ArcTrack& s) {
    if (!IsUsable(s.arc)) return Coordinates();
    if (!s.arc.is_arc()) return "has an arc without a radius; make it a track";
    s.arc = WithEnds(s.arc, nodes_.Merged(s.arc.begin_mm), nodes_.Merged(s.arc.end_mm));
    return Size(s.width_mm);
  }
  std::string operator()(Outline& s) const {
    for (Edges& loop : s.loops) {
      for (std::size_t k = 0; k < loop.size(); ++k) {
        if (!IsUsable(loop[k])) return Coordinates();
        const Vec2 gap = loop[(k + 1) % loop.size()].begin_mm - loop[k].end_mm;
        if (!(gap.norm() <= kJoint_mm))
          return fmt::format("is open at {}; close it", At(loop[k].end_mm));
      }
      Edges rounded;
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec2 begin = Rounded_mm(loop[k].begin_mm);
        const Vec2 end = Rounded_mm(loop[(k + 1) % loop.size()].begin_mm);
        if (!loop[k].is_arc() && begin == end) continue;
        rounded.push_back(WithEnds(loop[k], begin, end));
      }
      loop = std::move(rounded);
    }
    return {};
  }

 private:
  static std::string Coordinates() {
    return fmt::format("has a coordinate that is no number within +-{} mm; correct it",
                       kMaxCoordinate_mm);
  }
  static std::string Size(double& size_mm) {
    if (!(size_mm >= 0) || !IsUsable(size_mm))
      return fmt::format("has a size that is not within 0 .. {} mm; correct it",
                         kMaxCoordinate_mm);
    size_mm = Rounded_mm(size_mm);
    return {};
  }
  std::string Pad(Vec2& center_mm, double& size_mm) {
    if (!IsUsable(center_mm)) return Coordinates();
    center_mm = nodes_.Merged(center_mm);
    return Size(size_mm);
  }

  Nodes nodes_;
};

}  // namespace

std::string Describe(const Element& element) {
  const std::string what = std::visit(Description{}, element.shape);
  return element.name.empty() ? what : element.name + ", " + what;
}

Result<std::vector<Element>> Rounded(std::span<const Element> elements) {
  std::vector<Element> rounded(elements.begin(), elements.end());
  Rounding rounding;
  for (Element& element : rounded) {
    const std::string wrong =
        std::visit([&](auto& shape) { return rounding(shape); }, element.shape);
    if (!wrong.empty())
      return Fail(ErrorCode::kInvalidValue, Describe(element) + " " + wrong);
  }
  return rounded;
}

}  // namespace intaglio::contour
