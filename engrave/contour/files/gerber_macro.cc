#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/contour/files/gerber_aperture.h"
#include "engrave/contour/region/region.h"
#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
constexpr int kMaxNesting = 32;
constexpr std::size_t kMaxOutline = 5000;
constexpr int kMaxCleared = 200;

using Variables = std::map<int, double>;

/// + - x / and brackets, after the specification's chapter on macros.
class Arithmetic {
 public:
  Arithmetic(std::string_view text, const Variables& variables)
      : text_(text), variables_(variables) {}

  Result<double> Value() {
    const double value = INTAGLIO_TRY(Sum(0));
    if (at_ == text_.size() && std::isfinite(value)) return value;
    return Wrong();
  }

 private:
  tl::unexpected<Error> Wrong() const {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("'{}' is no arithmetic of a macro", text_.substr(0, 40)));
  }
  bool Take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  Result<double> Sum(int depth) {
    double value = INTAGLIO_TRY(Product(depth));
    for (;;) {
      if (Take('+'))
        value += INTAGLIO_TRY(Product(depth));
      else if (Take('-'))
        value -= INTAGLIO_TRY(Product(depth));
      else
        return value;
    }
  }
  Result<double> Product(int depth) {
    double value = INTAGLIO_TRY(Factor(depth));
    for (;;) {
      if (Take('x') || Take('X'))
        value *= INTAGLIO_TRY(Factor(depth));
      else if (Take('/'))
        value /= INTAGLIO_TRY(Factor(depth));
      else
        return value;
    }
  }
  Result<double> Factor(int depth) {
    if (depth > kMaxNesting) return Wrong();
    if (Take('-')) return -INTAGLIO_TRY(Factor(depth + 1));
    if (Take('+')) return Factor(depth + 1);
    if (Take('(')) {
      const double value = INTAGLIO_TRY(Sum(depth + 1));
      if (!Take(')')) return Wrong();
      return value;
    }
    const bool variable = Take('$');
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           ((text_[at_] >= '0' && text_[at_] <= '9') || (text_[at_] == '.' && !variable)))
      ++at_;
    const auto number = io::ParseFinite(text_.substr(begin, at_ - begin));
    if (!number || *number > 1e9) return Wrong();
    if (!variable) return *number;
    // A variable that nobody set is 0.
    const auto found = variables_.find(static_cast<int>(*number));
    return found == variables_.end() ? 0 : found->second;
  }

  std::string_view text_;
  const Variables& variables_;
  std::size_t at_ = 0;
};

class MacroReader {
 public:
  MacroReader(const std::vector<double>& values, double unit_mm) : unit_mm_(unit_mm) {
    for (std::size_t k = 0; k < values.size(); ++k)
      variables_[static_cast<int>(k) + 1] = values[k];
  }

  Status Read(const std::string& block) {
    if (block.empty() || block.front() == '0') return {};
    if (block.front() == '$') {
      const std::size_t equals = block.find('=');
      const auto number = io::ParseFinite(std::string_view(block).substr(
          1, equals == std::string::npos ? equals : equals - 1));
      if (equals == std::string::npos || !number || *number < 1 || *number > 1e6)
        return Fail(ErrorCode::kInvalidValue, "a macro has a variable without a value");
      variables_[static_cast<int>(*number)] =
          INTAGLIO_TRY(Arithmetic(block.substr(equals + 1), variables_).Value());
      return {};
    }
    return ReadPrimitive(block);
  }

  GerberAperture Take() { return std::move(aperture_); }

 private:
  Status ReadPrimitive(const std::string& block) {
    std::vector<double> n;
    for (std::size_t begin = 0; begin <= block.size();) {
      const std::size_t end = std::min(block.find(',', begin), block.size());
      if (n.size() > 2 * kMaxOutline + 8)
        return Fail(ErrorCode::kTooLarge, "a primitive of a macro has too many numbers");
      n.push_back(
          INTAGLIO_TRY(Arithmetic(block.substr(begin, end - begin), variables_).Value()));
      begin = end + 1;
    }
    const int code = static_cast<int>(n[0]);
    n.erase(n.begin());
    clears_ = false;
    if (code == 7) return Thermal(n);
    if (!n.empty() && n[0] != 0 && n[0] != 1)
      return Fail(ErrorCode::kInvalidValue,
                  "a primitive of a macro has an exposure that is neither 0 nor 1");
    clears_ = !n.empty() && n[0] == 0;
    switch (code) {
      case 1:
        return Needs(n, 4) ? Add(Circle{At(n, 2, Turn(n, 4)), n[1] * unit_mm_}, n[1])
                           : TooFew(code);
      case 20:
      case 2:
        return Needs(n, 7) ? VectorLine(n) : TooFew(code);
      case 21:
        return Needs(n, 6) ? CenterLine(n) : TooFew(code);
      case 4:
        return OutlineOf(n);
      case 5:
        return Needs(n, 6) ? Polygon(n) : TooFew(code);
      default:
        return Fail(ErrorCode::kUnsupported,
                    fmt::format("primitive {} of macros is not read", code));
    }
  }

  static bool Needs(const std::vector<double>& n, std::size_t count) {
    return n.size() >= count;
  }
  static Status TooFew(int code) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("primitive {} of a macro has too few numbers", code));
  }
  static double Turn(const std::vector<double>& n, std::size_t k) {
    return k < n.size() ? n[k] * pi / 180 : 0;
  }
  /// Turned about the origin of the macro.
  Vec2 At(const Vec2& p, double turn) const {
    return unit_mm_ * Vec2(p.x() * std::cos(turn) - p.y() * std::sin(turn),
                           p.x() * std::sin(turn) + p.y() * std::cos(turn));
  }
  Vec2 At(const std::vector<double>& n, std::size_t k, double turn) const {
    return At(Vec2(n[k], n[k + 1]), turn);
  }
  Status Add(Shape shape, double size) {
    if (!(size > 0))
      return Fail(ErrorCode::kInvalidValue, "a primitive of a macro has no size");
    if (!clears_) {
      aperture_.shapes.push_back(std::move(shape));
      return {};
    }
    // Exposure 0 takes away what the macro drew before, nothing else.
    if (++cleared_count_ > kMaxCleared)
      return Fail(ErrorCode::kTooLarge, "a macro has too many primitives of exposure 0");
    std::vector<Element> drawn;
    for (Shape& before : aperture_.shapes) drawn.push_back({std::move(before), {}});
    const Element cleared{std::move(shape), {}};
    drawn = INTAGLIO_TRY(Cleared(drawn, {&cleared, 1}));
    aperture_.shapes.clear();
    for (Element& rest : drawn) aperture_.shapes.push_back(std::move(rest.shape));
    return {};
  }
  Status AddCorners(const std::vector<Vec2>& corners, double turn, double size) {
    Edges loop;
    for (std::size_t k = 0; k < corners.size(); ++k)
      loop.push_back(
          MakeLine(At(corners[k], turn), At(corners[(k + 1) % corners.size()], turn)));
    return Add(Outline{{loop}}, size);
  }

  /// Exposure, width, begin, end, rotation: with square ends.
  Status VectorLine(const std::vector<double>& n) {
    const Vec2 a(n[2], n[3]);
    const Vec2 b(n[4], n[5]);
    if ((b - a).norm() == 0) {  // its square ends, as viewers show it
      const Vec2 h = Vec2::Constant(n[1] / 2), k(h.x(), -h.y());
      return AddCorners({a - h, a + k, a + h, a - k}, Turn(n, 6), n[1]);
    }
    const Vec2 side = n[1] / 2 * RightOf((b - a).normalized());
    return AddCorners({a + side, b + side, b - side, a - side}, Turn(n, 6), n[1]);
  }
  /// Exposure, width, height, centre, rotation.
  Status CenterLine(const std::vector<double>& n) {
    const Vec2 c(n[3], n[4]);
    const Vec2 h(n[1] / 2, n[2] / 2);
    const Vec2 k(h.x(), -h.y());
    return AddCorners({c - h, c + k, c + h, c - k}, Turn(n, 5), std::min(n[1], n[2]));
  }
  /// Exposure, number of sides, corners with the first one again, rotation.
  Status OutlineOf(const std::vector<double>& n) {
    const double count = n.size() > 1 ? n[1] : 0;
    if (!(count >= 3 && count <= kMaxOutline) ||
        n.size() < 2 * static_cast<std::size_t>(count) + 4)
      return TooFew(4);
    std::vector<Vec2> corners;
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
      corners.push_back({n[2 + 2 * k], n[3 + 2 * k]});
    return AddCorners(corners, Turn(n, 2 * static_cast<std::size_t>(count) + 4), 1);
  }
  /// Exposure, number of corners, centre, diameter, rotation.
  Status Polygon(const std::vector<double>& n) {
    if (n[1] < 3 || n[1] > 12) return TooFew(5);
    std::vector<Vec2> corners;
    for (int k = 0; k < static_cast<int>(n[1]); ++k) {
      const double angle = 2 * pi * k / std::floor(n[1]);
      corners.push_back(Vec2(n[2], n[3]) +
                        n[4] / 2 * Vec2(std::cos(angle), std::sin(angle)));
    }
    return AddCorners(corners, Turn(n, 5), n[4]);
  }
  /// Centre, outer and inner diameter, gap, rotation: a ring cut by a cross.
  Status Thermal(const std::vector<double>& n) {
    if (n.size() < 5) return TooFew(7);
    const double outer = n[2] / 2 * unit_mm_;
    const double inner = n[3] / 2 * unit_mm_;
    const double h = n[4] / 2 * unit_mm_;
    if (!(outer > inner && inner >= 0 && h >= 0 && h * std::numbers::sqrt2 < outer))
      return Fail(ErrorCode::kInvalidValue, "a thermal of a macro has no copper");
    const Vec2 center = At(n, 0, Turn(n, 5));
    for (int quarter = 0; quarter < 4; ++quarter) {
      const double turn = Turn(n, 5) + quarter * pi / 2;
      const auto at = [&](double x, double y) -> Vec2 {
        return center + At(Vec2(x, y) / unit_mm_, turn);
      };
      const double far = std::sqrt(outer * outer - h * h);
      Edges loop{MakeArcBetween(at(far, h), at(h, far), center, true)};
      if (inner > h * std::numbers::sqrt2) {
        const double near = std::sqrt(inner * inner - h * h);
        loop.push_back(MakeLine(at(h, far), at(h, near)));
        loop.push_back(MakeArcBetween(at(h, near), at(near, h), center, false));
        loop.push_back(MakeLine(at(near, h), at(far, h)));
      } else {
        loop.push_back(MakeLine(at(h, far), at(h, h)));
        loop.push_back(MakeLine(at(h, h), at(far, h)));
      }
      INTAGLIO_TRY(Add(Outline{{loop}}, 1));
    }
    return {};
  }

  double unit_mm_;
  Variables variables_;
  GerberAperture aperture_;
  bool clears_ = false;
  int cleared_count_ = 0;
};

}  // namespace

Result<GerberAperture> MacroAperture(const GerberMacro& macro,
                                     const std::vector<double>& values, double unit_mm) {
  MacroReader reader(values, unit_mm);
  for (const std::string& block : macro) INTAGLIO_TRY(reader.Read(block));
  return reader.Take();
}

}  // namespace intaglio::contour
