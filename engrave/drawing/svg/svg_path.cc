#include "engrave/drawing/svg/svg_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "engrave/core/counted.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

/// How many numbers a command takes; -1: no command.
int NumberCountOf(char command) {
  switch (io::LowerCase(command)) {
    case 'z':
      return 0;
    case 'h':
    case 'v':
      return 1;
    case 'm':
    case 'l':
    case 't':
      return 2;
    case 's':
    case 'q':
      return 4;
    case 'c':
      return 6;
    case 'a':
      return 7;
    default:
      return -1;
  }
}

class PathParser {
 public:
  PathParser(std::string_view text, std::uint64_t max_points, std::vector<Curve>& curves)
      : numbers_(text), max_points_(max_points), curves_(curves) {}

  /// With an error the curves before it are kept, as browsers draw them.
  std::optional<SvgTextError> Parse() {
    const auto wrong = ParseCommands();
    if (wrong) EndCurve(false);
    return wrong;
  }

 private:
  std::optional<SvgTextError> ParseCommands() {
    char command = 0;
    while (const char next = numbers_.Peek()) {
      if (NumberCountOf(next) >= 0) {
        command = next;
        numbers_.Skip();
      } else if (command == 0 || io::IsLetter(next) || io::LowerCase(command) == 'z') {
        return Wrong("expected a path command, one of MLHVCSQTAZ");
      }
      if (first_ && io::LowerCase(command) != 'm')
        return Wrong("a path must begin with M or m");
      first_ = false;
      if (!ReadNumbers(command)) {
        return Wrong(fmt::format("the command {} needs {}", command,
                                 Counted(NumberCountOf(command), "finite number")));
      }
      Draw(command);
      if (points_ > max_points_) return Wrong("the path has too many points");
      // Further pairs behind a move are lines.
      if (command == 'M') command = 'L';
      if (command == 'm') command = 'l';
    }
    EndCurve(false);
    return std::nullopt;
  }
  SvgTextError Wrong(std::string sentence) const {
    return {std::move(sentence), Shown(numbers_.rest())};
  }

  bool ReadNumbers(char command) {
    const int count = NumberCountOf(command);
    for (int i = 0; i < count; ++i) {
      if (i > 0) numbers_.SkipComma();
      if (io::LowerCase(command) == 'a' && (i == 3 || i == 4)) {
        const std::optional<bool> flag = numbers_.NextFlag();
        if (!flag) return false;
        n_[static_cast<std::size_t>(i)] = *flag ? 1 : 0;
        continue;
      }
      const std::optional<double> number = numbers_.Next();
      if (!number) return false;
      n_[static_cast<std::size_t>(i)] = *number;
    }
    if (count > 0) numbers_.SkipComma();
    return true;
  }

  /// The pair of numbers from i on, as a point.
  Vec3 PointAt(std::size_t i, bool relative) const {
    const Vec3 p(n_[i], n_[i + 1], 0);
    return relative ? Vec3(at_ + p) : p;
  }

  void Draw(char command) {
    const bool relative = command >= 'a';
    const char kind = io::LowerCase(command);
    // Smooth forms mirror the last control point of their own kind, or none.
    const Vec3 cubic = last_kind_ == 'c' ? Vec3(2 * at_ - control_) : at_;
    const Vec3 quadratic = last_kind_ == 'q' ? Vec3(2 * at_ - control_) : at_;
    last_kind_ = 0;
    switch (kind) {
      case 'z':
        Close();
        break;
      case 'm':
        Move(PointAt(0, relative));
        break;
      case 'l':
        Line(PointAt(0, relative));
        break;
      case 'h':
        Line({relative ? at_.x() + n_[0] : n_[0], at_.y(), 0});
        break;
      case 'v':
        Line({at_.x(), relative ? at_.y() + n_[0] : n_[0], 0});
        break;
      case 'c':
        Cubic(PointAt(0, relative), PointAt(2, relative), PointAt(4, relative));
        break;
      case 's':
        Cubic(cubic, PointAt(0, relative), PointAt(2, relative));
        break;
      case 'q':
        Quadratic(PointAt(0, relative), PointAt(2, relative));
        break;
      case 't':
        Quadratic(quadratic, PointAt(0, relative));
        break;
      default:
        Put(SvgArc(at_, PointAt(5, relative), {n_[0], n_[1]}, n_[2], n_[3] != 0,
                   n_[4] != 0),
            PointAt(5, relative));
    }
  }

  void Move(const Vec3& p) {
    EndCurve(false);
    at_ = begin_ = p;
    // A move alone draws nothing.
  }
  void Line(const Vec3& p) {
    ++points_;
    if (line_.empty()) line_.push_back(at_);
    line_.push_back(p);
    at_ = p;
  }
  void Cubic(const Vec3& c1, const Vec3& c2, const Vec3& p) {
    Put(CubicBezier{{at_, c1, c2, p}}, p);
    control_ = c2;
    last_kind_ = 'c';
  }
  void Quadratic(const Vec3& c, const Vec3& p) {
    // Degree elevation: exact.
    Put(CubicBezier{{at_, at_ + 2.0 / 3 * (c - at_), p + 2.0 / 3 * (c - p), p}}, p);
    control_ = c;
    last_kind_ = 'q';
  }
  void Put(Piece piece, const Vec3& end) {
    FlushLine();
    points_ += 4;
    curve_.pieces.push_back(std::move(piece));
    at_ = end;
  }
  void FlushLine() {
    if (!line_.empty()) curve_.pieces.push_back(Polyline{std::move(line_)});
    line_.clear();
  }
  void Close() {
    if (line_.empty() && curve_.pieces.empty()) line_.push_back(at_);
    EndCurve(true);
    at_ = begin_;
  }
  void EndCurve(bool closed) {
    FlushLine();
    if (!curve_.pieces.empty()) {
      curve_.closed = closed;
      curves_.push_back(std::move(curve_));
    }
    curve_ = Curve();
  }

  SvgNumbers numbers_;
  std::uint64_t max_points_;
  std::vector<Curve>& curves_;
  std::array<double, 7> n_{};
  bool first_ = true;
  std::uint64_t points_ = 0;
  Vec3 at_ = Vec3::Zero(), begin_ = Vec3::Zero(), control_ = Vec3::Zero();
  char last_kind_ = 0;
  PointList line_;
  Curve curve_;
};

}  // namespace

void SvgNumbers::SkipBlanks() {
  while (!rest_.empty() && IsSvgBlank(rest_.front())) rest_.remove_prefix(1);
}

void SvgNumbers::SkipComma() {
  SkipBlanks();
  if (!rest_.empty() && rest_.front() == ',') rest_.remove_prefix(1);
  SkipBlanks();
}

char SvgNumbers::Peek() {
  SkipBlanks();
  return rest_.empty() ? '\0' : rest_.front();
}

std::optional<double> SvgNumbers::Next() {
  SkipBlanks();
  std::string_view text = rest_;
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  // Not "inf" or "nan", which from_chars accepts.
  const auto digit = text.find_first_not_of("+-.");
  if (digit == text.npos || text[digit] < '0' || text[digit] > '9') return std::nullopt;
  double number = 0;
  const auto [end, failure] =
      std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || !std::isfinite(number)) return std::nullopt;
  rest_ = text.substr(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::optional<bool> SvgNumbers::NextFlag() {
  const char flag = Peek();
  if (flag != '0' && flag != '1') return std::nullopt;
  Skip();
  return flag == '1';
}

std::optional<SvgTextError> ParseSvgPath(std::string_view text, std::uint64_t max_points,
                                         std::vector<Curve>& curves) {
  return PathParser(text, max_points, curves).Parse();
}

Piece SvgArc(const Vec3& p, const Vec3& q, Vec2 radii, double turn_deg, bool large,
             bool positive) {
  radii = radii.cwiseAbs();
  if (p == q || !(radii.minCoeff() > 0)) return Polyline{{p, q}};
  const double turn = std::fmod(turn_deg, 360) * pi / 180;
  const Vec2 along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
  const Vec2 half = 0.5 * (p - q).head<2>();
  // In the ellipse's own axes and radii the half chord is a vector of a unit circle.
  Vec2 h(half.dot(along) / radii.x(), half.dot(across) / radii.y());
  if (h.norm() > 1) {
    radii *= h.norm();
    h /= h.norm();
  }
  const double away = std::sqrt(std::max(0.0, 1 - h.squaredNorm())) / h.norm();
  const Vec2 center = (large == positive ? -1 : 1) * away * Vec2(h.y(), -h.x());
  const Vec2 from = h - center, to = -h - center;
  double sweep = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  if (positive && sweep < 0) sweep += 2 * pi;
  if (!positive && sweep > 0) sweep -= 2 * pi;
  const Vec2 u = radii.x() * along, v = radii.y() * across;
  const Vec2 middle = 0.5 * (p + q).head<2>() + center.x() * u + center.y() * v;
  return EllipticArc{{middle.x(), middle.y(), 0},
                     {u.x(), u.y(), 0},
                     {v.x(), v.y(), 0},
                     std::atan2(from.y(), from.x()),
                     sweep};
}

}  // namespace intaglio::drawing
