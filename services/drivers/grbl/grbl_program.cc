#include "services/drivers/grbl/grbl_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace intaglio::drivers {
namespace {

constexpr double kMinFeed_mm_min = 1;
// A step aside has these; a way shorter than twice that is too short to light its begin.
constexpr double kAsideSteps = 4;
constexpr double kAside_mm_s = 10;

// Without zeros at its end: the line's bytes are what limits the pulses a second.
std::string Short(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

bool GrblWrite::lights() const {
  return std::ranges::any_of(moves, [](auto& move) { return move.pulse_tick != 0; });
}

// A lit line begins with its number and ends with its power (Line).
void GrblWrite::Darken() {
  for (std::string& line : lines) {
    if (!line.starts_with('N')) continue;
    line.replace(line.rfind('S'), std::string::npos, "S0");
    line.erase(0, line.find_first_not_of("0123456789", 1));
  }
  for (GrblMove& move : moves) move.pulse_tick = 0;
  knot_tick = 0;
}

void GrblProgram::SetController(const Vec3& steps_per_mm, double max_power) {
  pieces_.SetStepsPerMm(steps_per_mm);
  max_power_ = max_power;
}

void GrblProgram::Begin(std::uint64_t start_tick, const Vec3& from_mm) {
  pieces_.Begin(start_tick, from_mm);
  pulse_tick_ = 0;
  place_mm_ = Snapped(from_mm);
}

void GrblProgram::Drop() {
  pieces_.Drop();
  pulse_tick_ = 0;
}

double GrblProgram::Steps(const Vec3& from_mm, const Vec3& to_mm) const {
  return ((to_mm - from_mm).array() * pieces_.steps_per_mm().array())
      .abs()
      .round()
      .maxCoeff();
}

std::string GrblProgram::Line(const Vec3& to_mm, double speed_mm_s,
                              std::uint64_t pulse_tick) {
  const bool lit = pulse_tick != 0;
  std::string line = lit ? fmt::format("N{}", pulse_tick % 1000 + 1) : "";
  for (int i = 0; i < 3; ++i) {
    const double way = (to_mm[i] - place_mm_[i]) * pieces_.steps_per_mm()[i];
    if (std::abs(way) >= 0.5) line += "XYZ"[i] + Short(to_mm[i], 4);
  }
  const std::string feed = "F" + Short(std::max(kMinFeed_mm_min, speed_mm_s * 60), 0);
  if (feed != feed_text_) line += feed_text_ = feed;
  line += lit ? "S" + Short(PulsePower(pulse_tick), 0) : "S0";
  place_mm_ = to_mm;
  return line;
}

// Never S0, which fires nothing, and never more than the setting.
double GrblProgram::PulsePower(std::uint64_t tick) const {
  return std::max(1.0, std::floor(max_power_ * powers_.At(tick)));
}

GrblMove GrblProgram::MoveOf(const Piece& piece) const {
  GrblMove move;
  move.planned_s = piece.duration_s;
  move.through_tick = TickOf(piece.end_subticks);
  move.to_mm = piece.to_mm;
  move.ends_program = piece.end;
  move.first_tick = TickOf(piece.start_subticks) + 1;
  for (const Vec3& place_mm : PlacesOnChord(place_mm_, piece))
    move.places_mm.push_back(Snapped(place_mm));
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
  const double way = kAsideSteps / pieces_.steps_per_mm().x();
  const bool beyond = place.x() + way > pieces_.travel().max_mm.x();
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
    if (pulse_tick_ == 0 || !pieces_.has_end()) return std::nullopt;
    if (fires(pulse_tick_)) AddAside(pulse_tick_, write);
    pulse_tick_ = 0;
    return write;
  }
  if (TickOf(pieces_.front().start_subticks) > decided_through) return std::nullopt;
  const Piece piece = pieces_.TakeFront();
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
