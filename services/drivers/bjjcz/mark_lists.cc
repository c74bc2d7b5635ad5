#include "services/drivers/bjjcz/mark_lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::drivers {
namespace {

using enum LmcOperation;

constexpr double kMaxUint16 = 65535;
// Chords of arcs: half a place of the board.
constexpr double kChordPlaces = 0.5;
// A piece of a line that is cut is not shorter than a tenth of a list.
constexpr double kMinPieceSeconds = kMaxListSeconds / 10;

}  // namespace

MarkLists::MarkLists(const MachineSpec& machine)
    : head_(machine.scan_head()),
      board_(machine.bjjcz_board()),
      field_(head_.field_mm()) {}

std::uint16_t MarkLists::SpeedOf(double speed_mm_s) const {
  return ToUint16(speed_mm_s * field_.places_per_mm() / 1000);
}

Status MarkLists::Begin(std::span<const mark::Pen> pens) {
  INTAGLIO_TRY(mark::CheckMarks({{pens.begin(), pens.end()}, {}}));
  const double clock_hz = PeriodClockHz(board_);
  for (const mark::Pen& pen : pens) {
    const auto refuse = [&](const std::string& what, double value) {
      return Fail(ErrorCode::kUnsupported, fmt::format("pen {:?}: {}", pen.name, what),
                  fmt::format("{}", value));
    };
    const double period = clock_hz / pen.frequency_hz;
    if (!(period >= 1 && period <= kMaxUint16)) {
      return refuse(
          fmt::format("a frequency of {:g} Hz; a BJJCZ board makes pulses of "
                      "{:.0f} to {:g} Hz with this laser",
                      pen.frequency_hz, std::ceil(clock_hz / kMaxUint16), clock_hz),
          pen.frequency_hz);
    }
    const double places_ms = pen.speed_mm_s * field_.places_per_mm() / 1000;
    if (!(places_ms >= 1 && places_ms <= kMaxUint16)) {
      return refuse(
          fmt::format("a speed of {:g} mm/s; in a field of {:g} mm the board "
                      "marks at {:.2g} to {:.0f} mm/s",
                      pen.speed_mm_s, head_.field_mm(), 1000 / field_.places_per_mm(),
                      1000 * kMaxUint16 / field_.places_per_mm()),
          pen.speed_mm_s);
    }
    if (pen.depth_mm > 0)
      return refuse("a depth is of a spindle; give a power", pen.depth_mm);
  }
  pens_.assign(pens.begin(), pens.end());
  moves_.clear();
  next_ = 0;
  first_of_run_ = true;
  return {};
}

Status MarkLists::Check(std::uint32_t number, const mark::Mark& mark) const {
  INTAGLIO_TRY(mark::CheckMarks({pens_, {mark}}));
  const auto refuse = [&](const std::string& what) {
    return Fail(ErrorCode::kUnsupported, fmt::format("mark {}: {}", number, what),
                fmt::format("{}", number));
  };
  if (!(mark::LengthOf(mark) > 0))
    return refuse("has no length; draw a hole as a small circle");
  if (mark.web_mm != 0)
    return refuse("is on a web, which a BJJCZ board does not follow here");
  if (mark::IsRow(mark))
    return refuse(
        "is a row of dots, and a BJJCZ board does not switch the laser on its "
        "way here; use MARK_DOT_MODE_EACH");
  for (const Vec2& at : mark::PlacesOf(mark, kChordPlaces / field_.places_per_mm())) {
    if (field_.Contains(at)) continue;
    return refuse(
        fmt::format("({:.3f}, {:.3f}) mm is outside the field of {:g} mm; move "
                    "or scale the drawing",
                    at.x(), at.y(), head_.field_mm()));
  }
  return {};
}

void MarkLists::Load(const mark::Mark& mark) {
  pen_ = &pens_[mark.pen];
  moves_.clear();
  next_ = 0;
  const auto add = [&](const Vec2& at, bool is_lit) {
    const Vec2 places = field_.places_per_mm() * at + Vec2::Constant(kMiddlePlace);
    moves_.push_back({places.x(), places.y(), is_lit});
  };
  std::vector<Vec2> way = mark::PlacesOf(mark, kChordPlaces / field_.places_per_mm());
  if (mark.closed) way.push_back(way.front());
  for (std::uint32_t pass = 0; pass < pen_->pass_count; ++pass) {
    add(way.front(), false);
    for (std::size_t i = 1; i < way.size(); ++i) add(way[i], true);
  }
}

bool MarkLists::ends_stroke(std::size_t move) const {
  return move + 1 == moves_.size() || !moves_[move + 1].is_lit;
}

void MarkLists::AddHeader(LmcList& list) {
  auto& commands = list.commands;
  BeginList(board_, first_of_run_, list);
  first_of_run_ = false;
  commands.push_back({kJumpSpeed, {SpeedOf(head_.jump_mm_s())}});
  AppendLaser(board_, pen_->power_ratio, pen_->frequency_hz, commands);
  commands.push_back({kMarkSpeed, {SpeedOf(pen_->speed_mm_s)}});
  commands.push_back({kLaserOnDelay, {Microseconds(head_.laser_on_delay_s())}});
  commands.push_back({kLaserOffDelay, {Microseconds(head_.laser_off_delay_s())}});
  commands.push_back({kJumpDelay, {Microseconds(head_.jump_delay_s())}});
  commands.push_back({kPolygonDelay, {Microseconds(head_.polygon_delay_s())}});
}

double MarkLists::SecondsOf(const Move& move, double distance) const {
  const double places_s =
      1000.0 * SpeedOf(move.is_lit ? pen_->speed_mm_s : head_.jump_mm_s());
  return distance / places_s +
         (move.is_lit ? head_.polygon_delay_s() : head_.jump_delay_s());
}

bool MarkLists::AddMove(LmcList& list) {
  const Move& move = moves_[next_];
  const double dx = move.x - at_.x, dy = move.y - at_.y, distance = std::hypot(dx, dy);
  const double seconds = SecondsOf(move, distance);
  // Behind it the beam is switched off, wherever the list ends.
  const double end_s =
      head_.laser_on_delay_s() + head_.laser_off_delay_s() + head_.mark_delay_s();
  const double left_s = kMaxListSeconds - list.seconds - end_s;
  double part = 1;
  if (seconds > left_s) {
    if (!move.is_lit || left_s < kMinPieceSeconds) return false;
    part = left_s / seconds;
  }
  const BoardPlace to{static_cast<int>(std::round(at_.x + part * dx)),
                      static_cast<int>(std::round(at_.y + part * dy))};
  list.commands.push_back({move.is_lit ? kMark : kJump,
                           {ToUint16(to.x), ToUint16(to.y), 0,
                            ToUint16(std::hypot(to.x - at_.x, to.y - at_.y))}});
  list.seconds += part * seconds;
  at_ = to;
  if (part < 1) return true;
  if (move.is_lit && ends_stroke(next_)) {
    list.seconds += end_s;
    if (head_.mark_delay_s() > 0)
      list.commands.push_back({kDelay, {ToUint16(1e5 * head_.mark_delay_s())}});
  }
  ++next_;
  return true;
}

LmcList MarkLists::Next() {
  Require(has_more(), "the mark has no more lists");
  LmcList list;
  AddHeader(list);
  const std::size_t header = list.commands.size();
  while (has_more() && list.commands.size() + 2 <= kMaxListCommands && AddMove(list)) {
  }
  Require(list.commands.size() > header, "a list without a move");
  list.commands.push_back({kEnd, {}});
  return list;
}

}  // namespace intaglio::drivers
