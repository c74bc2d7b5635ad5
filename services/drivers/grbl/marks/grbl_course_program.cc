#include "services/drivers/grbl/marks/grbl_course_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace intaglio::drivers {
namespace {

using std::numbers::pi;
constexpr double kSlowestFeed_mm_min = 0.1;
/// Coordinates of a line are printed in these steps.
constexpr double kPrinted_mm = 1e-4;
/// A way has no more pieces, whatever its speed.
constexpr double kMaxPieces = 1e9;
/// An arc that bends less than it is printed is a line.
constexpr double kFlat_mm = kPrinted_mm;

double Printed(double mm) { return std::round(mm / kPrinted_mm) * kPrinted_mm; }
Vec3 Printed(const Vec3& mm) {
  return {Printed(mm.x()), Printed(mm.y()), Printed(mm.z())};
}

/// Four decimals without zeros at the end: the line's bytes bound how fast it follows.
std::string CourseNumber(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

Vec2 FlatOf(const Vec3& place) { return {place.x(), place.y()}; }
Vec3 At(const Vec2& place, double z) { return {place.x(), place.y(), z}; }

}  // namespace

double GrblCourseProgram::Leg::length_mm() const {
  return std::hypot(edge.length_mm, to_z_mm - from_z_mm);
}

void GrblCourseProgram::SetController(const GrblTraits& traits) {
  traits_ = traits;
  feed_text_.clear();
  power_text_ = "S0";
}

void GrblCourseProgram::RestAt(const Vec3& place_mm) {
  at_mm_ = planned_mm_ = Printed(place_mm);
  reach_ = {at_mm_, at_mm_};
}

void GrblCourseProgram::Begin(const mark::Mark& mark, const mark::Pen& pen) {
  edges_ = EdgesOfMark(mark);
  closed_ = mark.closed;
  pen_ = pen;
  pass_ = 0;
  ended_ = false;
  reach_ = {at_mm_, at_mm_};
  const Vec2 begin_mm = mark.places.front().at_mm;
  if (options_.tool == GrblTool::kSpindle) {
    const double z_mm = std::max(options_.safe_height_mm, planned_mm_.z());
    AddRapid(At(FlatOf(planned_mm_), z_mm));
    AddRapid(At(begin_mm, z_mm));
    AddRapid(At(begin_mm, options_.safe_height_mm));
    return;
  }
  AddRapid(At(begin_mm, planned_mm_.z()));
  AddCommand("M4S0");
}

void GrblCourseProgram::Drop() {
  legs_.clear();
  edges_.clear();
  ended_ = true;
}

void GrblCourseProgram::AddRapid(const Vec3& to_mm) {
  if ((to_mm - planned_mm_).norm() < kPrinted_mm) return;
  Leg leg;
  leg.edge = contour::MakeLine(FlatOf(planned_mm_), FlatOf(to_mm));
  leg.from_z_mm = planned_mm_.z();
  leg.to_z_mm = to_mm.z();
  // The slowest of the axes that move.
  leg.speed_mm_s = 1e9;
  const Vec3 way = (to_mm - planned_mm_).cwiseAbs();
  for (int i = 0; i < 3; ++i) {
    if (way[i] < kPrinted_mm) continue;
    const double axis_mm_s =
        traits_.max_speed_mm_s[i] > 0 ? traits_.max_speed_mm_s[i] : 1;
    leg.speed_mm_s = std::min(leg.speed_mm_s, axis_mm_s * way.norm() / way[i]);
  }
  Divide(leg);
  legs_.push_back(std::move(leg));
  planned_mm_ = to_mm;
}

void GrblCourseProgram::AddWork(const contour::Edge& edge) {
  Leg leg;
  leg.kind = Kind::kWork;
  leg.edge = edge;
  leg.from_z_mm = leg.to_z_mm = planned_mm_.z();
  leg.speed_mm_s = pen_.speed_mm_s;
  Divide(leg);
  legs_.push_back(std::move(leg));
  planned_mm_ = At(edge.end_mm, planned_mm_.z());
}

void GrblCourseProgram::AddPlunge(double z_mm) {
  Leg leg;
  leg.kind = Kind::kWork;
  leg.edge = contour::MakeLine(FlatOf(planned_mm_), FlatOf(planned_mm_));
  leg.from_z_mm = planned_mm_.z();
  leg.to_z_mm = z_mm;
  leg.speed_mm_s = pen_.plunge_mm_s > 0 ? pen_.plunge_mm_s : pen_.speed_mm_s;
  Divide(leg);
  legs_.push_back(std::move(leg));
  planned_mm_.z() = z_mm;
}

void GrblCourseProgram::AddCommand(std::string text) {
  Leg leg;
  leg.command = std::move(text);
  legs_.push_back(std::move(leg));
}

void GrblCourseProgram::Divide(Leg& leg) const {
  double pieces = leg.length_mm() / (leg.speed_mm_s * kPiece_s);
  if (leg.edge.is_arc()) {
    pieces = std::max(pieces, std::abs(leg.edge.sweep_rad) / (pi / 2));
    if (options_.lines_only) {
      // The sagitta of an angle a is r (1 - cos(a / 2)).
      const double ratio = std::min(1.0, kChord_mm / leg.edge.radius_mm);
      pieces =
          std::max(pieces, std::abs(leg.edge.sweep_rad) / (2 * std::acos(1 - ratio)));
    }
  }
  leg.piece_count =
      static_cast<std::uint64_t>(std::clamp(std::ceil(pieces - 1e-9), 1.0, kMaxPieces));
}

void GrblCourseProgram::AddPass() {
  const bool spindle = options_.tool == GrblTool::kSpindle;
  const auto begin_mm = [&] {
    return edges_.empty() ? FlatOf(planned_mm_) : edges_.front().begin_mm;
  };
  if (pass_ > 0 && !closed_) {
    if (spindle) AddRapid(At(FlatOf(planned_mm_), options_.safe_height_mm));
    AddRapid(At(begin_mm(), planned_mm_.z()));
  }
  ++pass_;
  if (spindle) AddPlunge(-pen_.depth_mm * pass_ / pen_.pass_count);
  for (const contour::Edge& edge : edges_) AddWork(edge);
}

void GrblCourseProgram::AddEnd() {
  ended_ = true;
  if (options_.tool == GrblTool::kSpindle)
    AddRapid(At(FlatOf(planned_mm_), options_.safe_height_mm));
  else
    AddCommand("M5S0");
}

std::optional<CourseLine> GrblCourseProgram::Next() {
  for (;;) {
    while (legs_.empty()) {
      if (ended_) return std::nullopt;
      if (pass_ < pen_.pass_count)
        AddPass();
      else
        AddEnd();
    }
    Leg& leg = legs_.front();
    ++leg.piece;
    auto line = LineOf(leg);
    if (leg.piece >= leg.piece_count) legs_.pop_front();
    if (line) return line;
  }
}

bool GrblCourseProgram::IsStep(const Vec3& from_mm, const Vec3& to_mm) const {
  const Vec3 from = (from_mm.array() * traits_.steps_per_mm.array()).round();
  const Vec3 to = (to_mm.array() * traits_.steps_per_mm.array()).round();
  return from != to;
}

std::optional<CourseLine> GrblCourseProgram::LineOf(const Leg& leg) {
  if (!leg.command.empty()) {
    power_text_ = "S0";
    return CourseLine{leg.command, 0, 0};
  }
  const double part =
      static_cast<double>(leg.piece) / static_cast<double>(leg.piece_count);
  const Vec2 to = leg.piece == leg.piece_count
                      ? leg.edge.end_mm
                      : contour::PointAt(leg.edge, part * leg.edge.length_mm);
  const double z = leg.from_z_mm + part * (leg.to_z_mm - leg.from_z_mm);
  const Vec3 to_mm = Printed(At(to, z));
  if ((to_mm - at_mm_).norm() < kPrinted_mm / 2) return std::nullopt;
  return Motion(leg, to_mm);
}

std::string GrblCourseProgram::CoordinatesTo(const Vec3& to_mm) const {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(to_mm[i] - at_mm_[i]) >= kPrinted_mm / 2)
      text += "XYZ"[i] + CourseNumber(to_mm[i], 4);
  }
  return text;
}

// mc_arc: chords of its tolerance, the last one to the target.
int GrblCourseProgram::BlocksOfArc(const contour::Edge& arc) const {
  const double tolerance = std::min(traits_.arc_tolerance_mm, arc.radius_mm);
  const double chord = std::sqrt(tolerance * (2 * arc.radius_mm - tolerance));
  if (!(chord > 0)) return 1;
  return std::max(1, static_cast<int>(arc.length_mm / 2 / chord));
}

CourseLine GrblCourseProgram::Motion(const Leg& leg, const Vec3& to_mm) {
  CourseLine line;
  const Vec2 from = FlatOf(at_mm_);
  const Vec2 chord = FlatOf(to_mm) - from;
  const double radius_mm = leg.edge.radius_mm;
  const bool is_arc = leg.edge.is_arc() && !options_.lines_only &&
                      chord.squaredNorm() / (8 * radius_mm) >= kFlat_mm;
  if (is_arc) {
    const bool ccw = leg.edge.sweep_rad > 0;
    const Vec2 center = leg.edge.center_mm - from;
    line.text = (ccw ? "G3" : "G2") + CoordinatesTo(to_mm) + "I" +
                CourseNumber(center.x(), 4) + "J" + CourseNumber(center.y(), 4);
    contour::Edge piece = leg.edge;
    piece.length_mm = leg.edge.length_mm / static_cast<double>(leg.piece_count);
    line.blocks = BlocksOfArc(piece);
    line.seconds = piece.length_mm / leg.speed_mm_s;
    for (const double side : {-radius_mm, radius_mm})
      reach_.Extend(At(leg.edge.center_mm + Vec2::Constant(side), to_mm.z()));
  } else {
    line.text = (leg.kind == Kind::kRapid ? "G0" : "G1") + CoordinatesTo(to_mm);
    line.blocks = IsStep(at_mm_, to_mm) ? 1 : 0;
    line.seconds = (to_mm - at_mm_).norm() / leg.speed_mm_s;
  }
  at_mm_ = to_mm;
  reach_.Extend(to_mm);
  if (leg.kind == Kind::kRapid) return line;
  const std::string feed =
      "F" + CourseNumber(std::max(kSlowestFeed_mm_min, leg.speed_mm_s * 60), 1);
  if (feed != feed_text_) line.text += feed_text_ = feed;
  if (options_.tool == GrblTool::kSpindle) return line;
  const double largest_s =
      std::max(1.0, std::floor(traits_.max_power * pen_.power_ratio));
  const std::string power =
      pen_.power_ratio > 0 ? "S" + CourseNumber(largest_s, 0) : std::string("S0");
  if (power != power_text_) line.text += power_text_ = power;
  return line;
}

}  // namespace intaglio::drivers
