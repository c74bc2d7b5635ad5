#include "engrave/post/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"

namespace intaglio::post {
namespace {

constexpr std::size_t kMaxPlaces = 1'000'000;
constexpr double kSamePlaceMm = 0.05;
constexpr double kReachMm = 1e5;

/// Which step of the ascending values a value is in, and how far into it, 0..1.
struct InStep {
  std::size_t step = 0;
  double share = 0;
};

InStep StepOf(const std::vector<double>& values, double value) {
  const auto above = std::upper_bound(values.begin(), values.end(), value);
  const auto last = values.size() - 2;
  const auto step = above == values.begin()
                        ? std::size_t{0}
                        : std::min(last, std::size_t(above - values.begin()) - 1);
  const double share = (value - values[step]) / (values[step + 1] - values[step]);
  return {step, std::clamp(share, 0.0, 1.0)};
}

/// Shares of the way from a to b at which it passes one of the values.
void AddCrossings(const std::vector<double>& values, double a, double b,
                  std::vector<double>& shares) {
  if (a == b) return;
  for (auto value = std::upper_bound(values.begin(), values.end(), std::min(a, b));
       value != values.end() && *value < std::max(a, b); ++value)
    shares.push_back((*value - a) / (b - a));
}

struct Row {
  Vec3 place_mm;
  std::size_t line = 0;
};

tl::unexpected<Error> At(std::string_view file, std::size_t line, const std::string& what,
                         std::string_view value) {
  return Fail(ErrorCode::kUnreadable, fmt::format("{}:{}: {}", file, line, what),
              std::string(value));
}

/// What stands between blanks, commas, semicolons, tabs.
std::vector<std::string_view> ColumnsOf(std::string_view line) {
  constexpr std::string_view kBetween = " ,;\t\r";
  std::vector<std::string_view> words;
  while (true) {
    const auto begin = line.find_first_not_of(kBetween);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const auto end = std::min(line.find_first_of(kBetween), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

class HeightReader {
 public:
  HeightReader(std::string_view file, const std::vector<double>& zero_mm)
      : file_(file), zero_mm_(zero_mm) {}

  Status Read(std::string_view text) {
    for (std::size_t number = 1; !text.empty(); ++number) {
      const auto end = std::min(text.find('\n'), text.size());
      INTAGLIO_TRY(ReadLine(text.substr(0, end), number));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    return {};
  }
  std::vector<Row> Take() { return std::move(rows_); }

 private:
  Status ReadLine(std::string_view line, std::size_t number) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    constexpr std::string_view kProbe = "[PRB:";
    if (line.starts_with(kProbe)) return ReadProbe(line.substr(kProbe.size()), number);
    if (line.empty() || std::string_view("#;(%[<$").find(line[0]) != line.npos ||
        line.starts_with("ok"))
      return {};
    return AddPlace(line, number);
  }

  /// "x,y,z:1]"
  Status ReadProbe(std::string_view line, std::size_t number) {
    const auto colon = line.find(':');
    if (colon == line.npos || colon + 1 >= line.size())
      return At(file_, number, "a [PRB:] without its end", line);
    if (line[colon + 1] != '1') {
      return At(file_, number,
                "the probe touched nothing there; probe again, from nearer or deeper",
                line);
    }
    if (zero_mm_.empty()) {
      return Fail(ErrorCode::kMissing,
                  fmt::format("{}:{}: [PRB:] has places of the machine; give the zero of "
                              "the work in them, as $# writes it behind [G54:, with "
                              "--height-map-zero",
                              file_, number),
                  std::string(line));
    }
    return AddPlace(line.substr(0, colon), number);
  }

  Status AddPlace(std::string_view line, std::size_t number) {
    const auto words = ColumnsOf(line);
    Vec3 place_mm;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view word = axis < words.size() ? words[axis] : "";
      const auto value = io::ParseNumber<double>(word);
      if (!value || !(std::abs(*value) <= kReachMm)) {
        return At(file_, number,
                  fmt::format("'{}' is no {} in mm; a line has x, y and z",
                              word.substr(0, 40), "xyz"[axis]),
                  word.substr(0, 40));
      }
      place_mm[static_cast<int>(axis)] = *value;
    }
    if (!zero_mm_.empty()) place_mm -= Vec3(zero_mm_[0], zero_mm_[1], zero_mm_[2]);
    if (rows_.size() >= kMaxPlaces) {
      return Fail(
          ErrorCode::kTooLarge,
          fmt::format("{}: has more than {} places; probe fewer", file_, kMaxPlaces));
    }
    rows_.push_back({place_mm, number});
    return {};
  }

  std::string_view file_;
  const std::vector<double>& zero_mm_;
  std::vector<Row> rows_;
};

/// The middle of each group of values that lie within kSamePlaceMm.
std::vector<double> GroupsOf(std::vector<double> values) {
  std::ranges::sort(values);
  std::vector<double> middles;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && values[end] - values[i] <= kSamePlaceMm) ++end;
    middles.push_back((values[i] + values[end - 1]) / 2);
    i = end;
  }
  return middles;
}

std::vector<double> GroupsAlong(const std::vector<Row>& rows, int axis) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(row.place_mm[axis]);
  return GroupsOf(std::move(values));
}

std::size_t NearestOf(const std::vector<double>& values, double value) {
  const InStep in = StepOf(values, value);
  return in.share < 0.5 ? in.step : in.step + 1;
}

}  // namespace

HeightMap::HeightMap(std::vector<double> x_mm, std::vector<double> y_mm,
                     std::vector<double> z_mm)
    : x_mm_(std::move(x_mm)), y_mm_(std::move(y_mm)), z_mm_(std::move(z_mm)) {
  Require(x_mm_.size() >= 2 && y_mm_.size() >= 2 &&
              z_mm_.size() == x_mm_.size() * y_mm_.size(),
          "{} heights of {} x {} places", z_mm_.size(), x_mm_.size(), y_mm_.size());
  const auto [min, max] = std::ranges::minmax(z_mm_);
  min_mm_ = min;
  max_mm_ = max;
}

double HeightMap::At(const Vec2& place_mm) const {
  const InStep x = StepOf(x_mm_, place_mm.x()), y = StepOf(y_mm_, place_mm.y());
  const double* const corner = &z_mm_[y.step * x_mm_.size() + x.step];
  const double* const above = corner + x_mm_.size();
  return std::lerp(std::lerp(corner[0], corner[1], x.share),
                   std::lerp(above[0], above[1], x.share), y.share);
}

ToolPath HeightMap::Divided(const ToolPath& lines, const Vec2& origin_mm,
                            double tolerance_mm) const {
  ToolPath divided{lines.name, lines.begin_mm, {}};
  Vec2 from_mm = lines.begin_mm;
  std::vector<double> shares;
  for (const WorkMove& move : lines.moves) {
    Require(move.kind == WorkKind::kLine, "{} has an arc", lines.name);
    const Vec2 way = move.end_mm - from_mm;
    const auto place = [&](double share) -> Vec2 { return from_mm + share * way; };
    const auto height = [&](double share) { return At(place(share) - origin_mm); };
    const Vec2 a = from_mm - origin_mm, b = move.end_mm - origin_mm;
    shares = {0, 1};
    AddCrossings(x_mm_, a.x(), b.x(), shares);
    AddCrossings(y_mm_, a.y(), b.y(), shares);
    std::ranges::sort(shares);
    for (std::size_t i = 0; i + 1 < shares.size(); ++i) {
      const double first = shares[i], last = shares[i + 1];
      if (!(last > first)) continue;
      // Inside a cell the height is a parabola along a line: its greatest distance from
      // the chord is in the middle, and a quarter of that with half the length.
      const double off_mm =
          std::abs(height((first + last) / 2) - (height(first) + height(last)) / 2);
      const double count = std::max(1.0, std::ceil(std::sqrt(off_mm / tolerance_mm)));
      for (double k = 1; k <= count; ++k) {
        WorkMove part = move;
        part.end_mm = k == count && last == 1 ? move.end_mm
                                              : place(first + (last - first) * k / count);
        divided.moves.push_back(part);
      }
    }
    from_mm = move.end_mm;
  }
  return divided;
}

Status HeightMap::RequireCovers(const ToolPath& path, const Vec2& origin_mm) const {
  const Vec2 margin((x_mm_[1] - x_mm_[0]) / 2, (y_mm_[1] - y_mm_[0]) / 2);
  const auto covers = [&](const Vec2& place_mm) {
    return place_mm.x() >= x_mm_.front() - margin.x() &&
           place_mm.x() <= x_mm_.back() + margin.x() &&
           place_mm.y() >= y_mm_.front() - margin.y() &&
           place_mm.y() <= y_mm_.back() + margin.y();
  };
  const auto check = [&](const Vec2& at_mm) -> Status {
    const Vec2 place_mm = at_mm - origin_mm;
    if (covers(place_mm)) return {};
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format(
            "{} reaches ({:.2f}, {:.2f}) mm, and the heights are of x {:g} to {:g} "
            "and y {:g} to {:g} mm; probe the whole work, or check --origin and "
            "--height-map-zero",
            path.name, place_mm.x(), place_mm.y(), x_mm_.front(), x_mm_.back(),
            y_mm_.front(), y_mm_.back()),
        path.name);
  };
  INTAGLIO_TRY(check(path.begin_mm));
  for (const WorkMove& move : path.moves) INTAGLIO_TRY(check(move.end_mm));
  return {};
}

Result<HeightMap> ParseHeightMap(std::string_view text, std::string_view file,
                                 const std::vector<double>& zero_mm) {
  HeightReader reader(file, zero_mm);
  INTAGLIO_TRY(reader.Read(io::WithoutByteOrderMark(text)));
  const std::vector<Row> rows = reader.Take();
  std::vector<double> x_mm = GroupsAlong(rows, 0), y_mm = GroupsAlong(rows, 1);
  if (x_mm.size() < 2 || y_mm.size() < 2) {
    return Fail(
        ErrorCode::kMissing,
        fmt::format("{}: has the heights of {} x {} places; probe a grid of 2 x 2 "
                    "or more",
                    file, x_mm.size(), y_mm.size()),
        std::string(file));
  }
  if (x_mm.size() * y_mm.size() > std::max<std::size_t>(4, 100 * rows.size()))
    return Fail(
        ErrorCode::kMissing,
        fmt::format("{}: its {} places form no grid: they have {} different x and "
                    "{} different y; probe the places of a grid",
                    file, rows.size(), x_mm.size(), y_mm.size()),
        std::string(file));
  std::vector<double> z_mm(x_mm.size() * y_mm.size(),
                           std::numeric_limits<double>::quiet_NaN());
  for (const Row& row : rows) {
    double& z = z_mm[NearestOf(y_mm, row.place_mm.y()) * x_mm.size() +
                     NearestOf(x_mm, row.place_mm.x())];
    if (!std::isnan(z)) {
      return At(file, row.line, "a height of this place came before; leave one of them",
                fmt::format("{:g} {:g}", row.place_mm.x(), row.place_mm.y()));
    }
    z = row.place_mm.z();
  }
  for (std::size_t i = 0; i < z_mm.size(); ++i) {
    if (!std::isnan(z_mm[i])) continue;
    return Fail(
        ErrorCode::kMissing,
        fmt::format("{}: the height at ({:g}, {:g}) mm is missing; a grid has one "
                    "at each x with each y",
                    file, x_mm[i % x_mm.size()], y_mm[i / x_mm.size()]),
        std::string(file));
  }
  return HeightMap(std::move(x_mm), std::move(y_mm), std::move(z_mm));
}

std::vector<Vec2> ProbePlaces(const Vec2& min_mm, const Vec2& max_mm, double step_mm) {
  Require(step_mm > 0, "a step of {} mm", step_mm);
  const auto steps = [&](double length_mm) {
    return std::max(1, static_cast<int>(std::ceil(length_mm / step_mm - 1e-9)));
  };
  const Vec2 size_mm = max_mm - min_mm;
  const int columns = steps(size_mm.x()), rows = steps(size_mm.y());
  std::vector<Vec2> places_mm;
  for (int row = 0; row <= rows; ++row) {
    for (int i = 0; i <= columns; ++i) {
      const int column = row % 2 == 0 ? i : columns - i;
      places_mm.emplace_back(min_mm.x() + size_mm.x() * column / columns,
                             min_mm.y() + size_mm.y() * row / rows);
    }
  }
  return places_mm;
}

}  // namespace intaglio::post
