#include "services/drivers/grbl/grbl_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::drivers {
namespace {

constexpr double kMinFeed_mm_min = 1;
// Of a step aside; and a way shorter than twice that is too short to light its beginning.
constexpr double kAsideSteps = 4;
constexpr double kAside_mm_s = 10;

std::uint64_t TickOf(std::uint64_t subticks) {
  return subticks / motion::kSubticksPerTick;
}

// Without zeros at its end: the line's bytes are what limits the pulses a second.
std::string Short(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

void GrblProgram::SetController(const Vec3& steps_per_mm, double max_power) {
  steps_per_mm_ = steps_per_mm;
  max_power_ = max_power;
}

void GrblProgram::ForgetModes() {
  feed_text_.clear();
  power_text_ = "S0";
}

void GrblProgram::Begin(std::uint64_t start_tick, const Vec3& from_mm) {
  pieces_.clear();
  pulse_tick_ = 0;
  has_end_ = false;
  appended_ = {from_mm, Vec3::Zero()};
  appended_subticks_ = start_tick * motion::kSubticksPerTick;
  place_mm_ = Snapped(from_mm);
}

void GrblProgram::Drop() {
  pieces_.clear();
  pulse_tick_ = 0;
  has_end_ = true;
}

Vec3 GrblProgram::Snapped(const Vec3& place_mm) const {
  return (place_mm.array() * steps_per_mm_.array()).round() / steps_per_mm_.array();
}

double GrblProgram::Steps(const Vec3& from_mm, const Vec3& to_mm) const {
  return ((to_mm - from_mm).array() * steps_per_mm_.array()).abs().round().maxCoeff();
}

Status GrblProgram::Check(const Vec3& place_mm) const {
  const bool inside = (place_mm.array() >= travel_.min_mm.array()).all() &&
                      (place_mm.array() <= travel_.max_mm.array()).all();
  if (inside) return {};  // a NaN is not
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("the target {:.3f}, {:.3f}, {:.3f} mm lies outside the travel of "
                  "the axes: check block_origin_mm and the block",
                  place_mm.x(), place_mm.y(), place_mm.z()));
}

Status GrblProgram::Append(std::span<const motion::Segment> segments, double rate_hz) {
  Pieces pieces;
  motion::KnotState from = appended_;
  std::uint64_t subticks = appended_subticks_;
  bool end = has_end_;
  for (const motion::Segment& segment : segments) {
    if (auto cut = Cut(from, segment, rate_hz, subticks, pieces); !cut) return cut;
    from = segment.end();
    subticks += segment.duration_subticks;
    end = end || segment.program_end;
  }
  pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
  appended_ = from;
  appended_subticks_ = subticks;
  has_end_ = end;
  return {};
}

Status GrblProgram::Cut(const motion::KnotState& from, const motion::Segment& segment,
                        double rate_hz, std::uint64_t start_subticks,
                        Pieces& pieces) const {
  const double duration_s = motion::DurationSeconds(segment.duration_subticks, rate_hz);
  if (auto good = Check(segment.end_position_mm); !good) return good;
  if (!segment.end_velocity_mm_s.allFinite()) {
    return Fail(ErrorCode::kInvalidValue, "a segment's velocity is not a number");
  }
  const auto count = static_cast<std::uint64_t>(
      std::max(1.0, std::ceil(duration_s / kMaxPiece_s - 1e-9)));
  const double speed = motion::MaxSpeed(from, segment, duration_s).norm();
  std::uint64_t start = start_subticks;
  for (std::uint64_t i = 1; i <= count; ++i) {
    const std::uint64_t end = start_subticks + segment.duration_subticks * i / count;
    const double at_s = motion::DurationSeconds(end - start_subticks, rate_hz);
    Piece piece;
    piece.to_mm = i == count ? segment.end_position_mm
                             : motion::HermitePosition(from, segment, at_s, duration_s);
    if (auto good = Check(piece.to_mm); !good) return good;
    piece.to_mm = Snapped(piece.to_mm);
    piece.speed_mm_s = speed;
    piece.duration_s = motion::DurationSeconds(end - start, rate_hz);
    piece.start_subticks = start;
    piece.end_subticks = end;
    piece.pulse = segment.pulse && i == count;
    piece.end = segment.program_end && i == count;
    for (std::uint64_t tick = TickOf(start) + 1; tick <= TickOf(end); ++tick) {
      const double tick_s = motion::DurationSeconds(
          tick * motion::kSubticksPerTick - start_subticks, rate_hz);
      piece.at_ticks_mm.push_back(motion::HermitePosition(
          from, segment, std::min(tick_s, duration_s), duration_s));
    }
    pieces.push_back(piece);
    start = end;
  }
  return {};
}

std::string GrblProgram::Line(const Vec3& to_mm, double speed_mm_s,
                              std::uint64_t pulse_tick) {
  const bool lit = pulse_tick != 0;
  std::string line = lit ? fmt::format("N{}", pulse_tick % 1000 + 1) : "";
  for (int i = 0; i < 3; ++i) {
    const double way = (to_mm[i] - place_mm_[i]) * steps_per_mm_[i];
    if (std::abs(way) >= 0.5) line += "XYZ"[i] + Short(to_mm[i], 4);
  }
  const std::string feed = "F" + Short(std::max(kMinFeed_mm_min, speed_mm_s * 60), 0);
  const std::string power = lit ? "S" + Short(max_power_, 0) : "S0";
  if (feed != feed_text_) line += feed_text_ = feed;
  if (power != power_text_) line += power_text_ = power;
  place_mm_ = to_mm;
  return line;
}

std::string GrblProgram::JogLine(const Vec3& to_mm, double speed_mm_s) const {
  return "$J=G90X" + Short(to_mm.x(), 4) + "Y" + Short(to_mm.y(), 4) + "Z" +
         Short(to_mm.z(), 4) + "F" + Short(std::max(kMinFeed_mm_min, speed_mm_s * 60), 0);
}

GrblMove GrblProgram::MoveOf(const Piece& piece) const {
  GrblMove move;
  move.planned_s = piece.duration_s;
  move.through_tick = TickOf(piece.end_subticks);
  move.to_mm = piece.to_mm;
  move.ends_program = piece.end;
  move.first_tick = TickOf(piece.start_subticks) + 1;
  // The segment may be curved; the stage is on the chord, where it is nearest to it.
  const Vec3 way = piece.to_mm - place_mm_;
  const double length2 = std::max(way.squaredNorm(), 1e-12);
  for (const Vec3& at_mm : piece.at_ticks_mm) {
    const double share = std::clamp(way.dot(at_mm - place_mm_) / length2, 0.0, 1.0);
    move.places_mm.push_back(Snapped(place_mm_ + way * share));
  }
  return move;
}

// The first part of the piece, lit; false: it is too short.
bool GrblProgram::LightBeginning(const Piece& piece, GrblWrite& write) {
  const Vec3 way = piece.to_mm - place_mm_;
  const double steps = Steps(place_mm_, piece.to_mm), length = way.norm();
  if (steps < 2 * kAsideSteps) return false;
  const double lit_mm =
      std::clamp(piece.speed_mm_s * kLit_s, length * kAsideSteps / steps, length / 2);
  GrblMove move;
  move.pulse_tick = pulse_tick_;
  move.to_mm = Snapped(place_mm_ + way * (lit_mm / length));
  write.lines.push_back(Line(move.to_mm, piece.speed_mm_s, pulse_tick_));
  write.moves.push_back(std::move(move));
  return true;
}

void GrblProgram::AddAside(std::uint64_t tick, GrblWrite& write) {
  const Vec3 place = place_mm_;
  const double way = kAsideSteps / steps_per_mm_.x();
  const bool beyond = place.x() + way > travel_.max_mm.x();
  const Vec3 aside = Snapped(place + Vec3(beyond ? -way : way, 0, 0));
  write.lines.push_back(Line(aside, kAside_mm_s, tick));
  GrblMove out, back;
  out.pulse_tick = tick;
  out.to_mm = aside;
  back.to_mm = place;
  write.moves.push_back(out);
  write.lines.push_back(Line(place, kAside_mm_s));
  write.moves.push_back(back);
}

GrblWrite GrblProgram::Aside(std::uint64_t tick) {
  GrblWrite write;
  write.knot_tick = tick;
  AddAside(tick, write);
  return write;
}

std::optional<GrblWrite> GrblProgram::Next(
    std::uint64_t decided_through, const std::function<bool(std::uint64_t)>& fires) {
  if (pulse_tick_ > decided_through) return std::nullopt;
  GrblWrite write;
  write.knot_tick = pulse_tick_;
  if (pieces_.empty()) {
    if (pulse_tick_ == 0 || !has_end_) return std::nullopt;
    if (fires(pulse_tick_)) AddAside(pulse_tick_, write);
    pulse_tick_ = 0;
    return write;
  }
  const Piece piece = pieces_.front();
  if (TickOf(piece.start_subticks) > decided_through) return std::nullopt;
  pieces_.pop_front();
  GrblMove move = MoveOf(piece);
  if (pulse_tick_ != 0 && fires(pulse_tick_) && !LightBeginning(piece, write)) {
    AddAside(pulse_tick_, write);
  }
  move.has_line = Steps(place_mm_, piece.to_mm) >= 1;
  if (move.has_line) write.lines.push_back(Line(piece.to_mm, piece.speed_mm_s));
  write.moves.push_back(std::move(move));
  pulse_tick_ = piece.pulse ? TickOf(piece.end_subticks) : 0;
  return write;
}

}  // namespace intaglio::drivers
