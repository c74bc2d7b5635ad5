#include "services/drivers/galvo/mark_player.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"
#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"

namespace intaglio::drivers {
namespace {

// Arcs as chords: far below a step of the outputs.
constexpr double kChordTolerance_mm = 1e-4;
// One mark takes 50 s at most, with all its passes.
constexpr double kMaxTicksOfMark = 5e6;
// Those of more are made aside: they take longer than a host may be silent.
constexpr double kTicksMadeAtOnce = 1e5;
// The web moves so far until the first mark of a run is in the field: on a web at rest
// nothing is made.
constexpr double kWebLeadIn_mm = 1;
constexpr double kSurpriseMargin = 1.5;

Error MarkError(ErrorCode code, const NumberedMark& mark, const std::string& what) {
  return {code, fmt::format("mark {}: {}", mark.number, what),
          fmt::format("{}", mark.number)};
}

/// A profile without a field is refused before anything is sent.
double FieldOrOne(const ScanHead& head) {
  return head.field_mm() > 0 ? head.field_mm() : 1;
}

double XOf(const Vec2& place) { return place.x(); }

}  // namespace

MarkPlayer::MarkPlayer(const ScanHead& head,
                       std::optional<galvo::CorrectionTable> correction)
    : head_(head),
      correction_(std::move(correction)),
      window_(correction_ ? galvo::FieldWindow(FieldOrOne(head), *correction_)
                          : galvo::FieldWindow(FieldOrOne(head))),
      outputs_(head.field_mm(), correction_ ? &*correction_ : nullptr),
      tracker_(FollowsWeb(head) ? head.encoder_count_um() / 1e3 : 0,
               head.edge_sensor_mm(), AheadSeconds(head)) {}

void MarkPlayer::Begin(std::span<const mark::Pen> pens, const Vec2& mirrors_mm) {
  pens_.assign(pens.begin(), pens.end());
  mirrors_mm_ = mirrors_mm;
  loaded_ = false;
  web_begin_mm_.reset();
  tracker_.Restart();
}

Status MarkPlayer::Check(const NumberedMark& mark) const {
  const auto fail = [&](ErrorCode code, const std::string& what) {
    return tl::make_unexpected(MarkError(code, mark, what));
  };
  INTAGLIO_TRY(mark::CheckMarks({pens_, {mark.mark}}));
  const mark::Pen& pen = pens_[mark.mark.pen];
  if (!(mark::LengthOf(mark.mark) > 0)) {
    return fail(
        ErrorCode::kUnsupported,
        "has no length: a scan head makes strokes; draw a hole as a small circle");
  }
  const double seconds = pen.pass_count * mark::LengthOf(mark.mark) / pen.speed_mm_s;
  if (!(seconds * rate_hz_ <= kMaxTicksOfMark)) {
    return fail(ErrorCode::kTooLarge,
                fmt::format("takes {:.0f} s; divide it or mark faster (pen {})", seconds,
                            pen.name));
  }
  if (mark.mark.web_mm != 0 && !(head_.encoder_count_um() > 0)) {
    return fail(ErrorCode::kUnsupported,
                "is on a web, and the machine has no encoder of one; give "
                "scan_head.encoder_count_um in the profile");
  }
  INTAGLIO_TRY(CheckPlaces(mark));
  if (tracker_.follows() && seconds * rate_hz_ > kTicksMadeAtOnce) {
    return fail(ErrorCode::kTooLarge,
                fmt::format("takes {:.1f} s, on a web 1 s at most; divide it or mark "
                            "faster (pen {})",
                            seconds, pen.name));
  }
  return {};
}

Status MarkPlayer::CheckPlaces(const NumberedMark& mark) const {
  const auto fail = [&](const std::string& what) {
    return tl::make_unexpected(MarkError(ErrorCode::kInvalidValue, mark, what));
  };
  const auto places_mm = mark::PlacesOf(mark.mark, kChordTolerance_mm);
  const double margin_mm = tracker_.follows() ? kWebBorderMm : 0;
  for (const Vec2& at : places_mm) {
    const bool inside = tracker_.follows()
                            ? !window_.Displacements({&at, 1}, margin_mm).empty()
                            : window_.Has(at);
    if (inside) continue;
    return fail(
        fmt::format("({:.3f}, {:.3f}) mm is outside the field of {} mm{}; move "
                    "or scale the drawing",
                    at.x(), at.y(), head_.field_mm(), NarrowedText(window_)));
  }
  if (tracker_.follows() && window_.Displacements(places_mm, margin_mm).empty()) {
    const auto [low, high] = std::ranges::minmax(places_mm, {}, &XOf);
    return fail(fmt::format("is {:.3f} mm long, the field {} mm{}; divide it",
                            high.x() - low.x(), head_.field_mm(), NarrowedText(window_)));
  }
  return {};
}

Status MarkPlayer::MakeTicks(const Vec2& from_mm) {
  const mark::Pen& pen = pens_[mark_.mark.pen];
  mark::Mark mark = mark_.mark;
  if (!tracker_.follows()) mark.web_mm = 0;
  std::vector<galvo::MarkStroke> strokes = StrokesOf(mark, pen);
  const auto options = TickOptionsOf(head_, pen, rate_hz_);
  const double count =
      pen.pass_count * mark::LengthOf(mark_.mark) / pen.speed_mm_s * rate_hz_;
  if (count <= kTicksMadeAtOnce)
    return TakeTicks(galvo::MakeMarkTicks(strokes, from_mm, options));
  ticks_.clear();
  next_ = 0;
  made_aside_ =
      std::async(std::launch::async, [strokes = std::move(strokes), from_mm, options] {
        return galvo::MakeMarkTicks(strokes, from_mm, options);
      });
  return {};
}

Status MarkPlayer::TakeTicks(Result<std::vector<galvo::MarkTick>> ticks) {
  if (!ticks)
    return tl::make_unexpected(
        MarkError(ticks.error().code, mark_, ticks.error().message));
  ticks_ = std::move(*ticks);
  const auto lit = [](const galvo::MarkTick& tick) { return tick.laser; };
  first_lit_ =
      static_cast<std::size_t>(std::ranges::find_if(ticks_, lit) - ticks_.begin());
  behind_lit_ = static_cast<std::size_t>(
      std::find_if(ticks_.rbegin(), ticks_.rend(), lit).base() - ticks_.begin());
  next_ = 0;
  return {};
}

Status MarkPlayer::Load(const NumberedMark& mark, std::optional<double> origin_count) {
  mark_ = mark;
  origin_count_ = origin_count;
  if (origin_count_) mark_.mark.web_mm = 0;
  placed_ = false;
  made_aside_ = {};
  retry_tick_ = 0;
  if (!tracker_.follows()) {
    INTAGLIO_TRY(MakeTicks(mirrors_mm_));
    placed_ = true;
  } else if (!origin_count_ && !web_begin_mm_) {
    BeginWeb();
  }
  loaded_ = true;
  return {};
}

// Wherever the web is then: where it was at the begin of the job is not known any more
// after a pause.
void MarkPlayer::BeginWeb() {
  std::vector<Vec2> places_mm = mark::PlacesOf(mark_.mark, kChordTolerance_mm);
  for (Vec2& place : places_mm) place.x() -= mark_.mark.web_mm;
  web_begin_mm_ = window_.Displacements(places_mm, kWebBorderMm).from_mm - kWebLeadIn_mm;
}

// The displacement that the beam has in the middle of the tick, which is commanded by the
// lag of the servo before.
Vec2 MarkPlayer::DisplacementAt(std::uint64_t tick) {
  if (origin_count_) return tracker_.Since(*origin_count_, tick, head_.servo_lag_s());
  return tracker_.At(tick, head_.servo_lag_s()) + Vec2(web_begin_mm_.value_or(0), 0);
}

// What the controller adds, where the web is elsewhere than DisplacementAt says. The
// slope of the correction, some percent, is left out: it is of a part of a millimetre.
link::HeadFollow MarkPlayer::FollowFrom(std::uint64_t first_tick) const {
  const double lag_s = head_.servo_lag_s();
  link::HeadFollow follow;
  follow.count = tracker_.CountAt(first_tick, lag_s);
  follow.counts_per_tick = tracker_.counts_per_tick();
  follow.lead_ticks = static_cast<float>(0.5 + lag_s * rate_hz_);
  follow.x_per_count = static_cast<float>(tracker_.count_mm() * 65536 / head_.field_mm());
  return follow;
}

// The web may be as far from where it is expected as it was lately, and farther the
// later: what it moves back would take a mark that has just arrived out of the field.
double MarkPlayer::SurpriseAfter(std::size_t ticks) const {
  const double later = static_cast<double>(ticks) / rate_hz_ / tracker_.ahead_s();
  return kSurpriseMargin * tracker_.surprise_mm() * (1 + later);
}

Status MarkPlayer::Place(std::uint64_t first_tick) {
  if (!tracker_.ready() || first_tick < retry_tick_) return {};
  INTAGLIO_TRY(MakeTicks(mirrors_mm_ - DisplacementAt(first_tick)));
  const double border_mm = head_.field_mm() / 2 - kWebBorderMm;
  double short_mm = 0;
  for (std::size_t k = first_lit_; k < behind_lit_; ++k) {
    const Vec2 at_mm = ticks_[k].place_mm + DisplacementAt(first_tick + k);
    galvo::Span by_mm = window_.Displacements({&at_mm, 1}, kWebBorderMm);
    // Too far aside, by the edge of the web: NextBlock names it.
    if (by_mm.empty()) by_mm = {-border_mm - at_mm.x(), border_mm - at_mm.x()};
    if (by_mm.to_mm < 0) {
      return tl::make_unexpected(MarkError(
          ErrorCode::kRefused, mark_,
          fmt::format("has left the field before it could be made: the web moves {:.1f} "
                      "mm/s; let it move slower, or mark faster (pen {})",
                      tracker_.speed_mm_s(), pens_[mark_.mark.pen].name)));
    }
    short_mm = std::max(short_mm, by_mm.from_mm + SurpriseAfter(k));
  }
  if (short_mm == 0) {
    placed_ = true;
    return {};
  }
  const double speed_mm_s = std::max(tracker_.speed_mm_s(), 1e-3);
  const double wait_s = std::clamp(0.5 * short_mm / speed_mm_s, 1e-4, 0.1);
  retry_tick_ = first_tick + static_cast<std::uint64_t>(wait_s * rate_hz_);
  return {};
}

Result<std::optional<link::HeadBlock>> MarkPlayer::NextBlock(std::uint64_t first_tick) {
  if (!placed_) {
    INTAGLIO_TRY(Place(first_tick));
    if (!placed_) return std::nullopt;
  }
  if (made_aside_.valid()) {
    if (made_aside_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      return std::nullopt;
    INTAGLIO_TRY(TakeTicks(made_aside_.get()));
  }
  link::HeadBlock block;
  const mark::Pen& pen = pens_[mark_.mark.pen];
  const std::size_t end = std::min(next_ + link::kMaxHeadTicks, ticks_.size());
  const auto outside = outputs_.lit_outside_count();
  for (std::size_t k = next_; k < end; ++k) {
    const auto at = static_cast<std::uint16_t>(k - next_);
    if (k == first_lit_) {
      block.edges.push_back({at, true, mark_.number, static_cast<float>(pen.power_ratio),
                             static_cast<float>(pen.frequency_hz)});
    }
    const Vec2 by_mm =
        tracker_.follows() ? DisplacementAt(first_tick + at) : Vec2(Vec2::Zero());
    const galvo::HeadOutput out = outputs_.Make(ticks_[k], by_mm);
    block.ticks.push_back({out.x, out.y, out.laser});
    // Behind the last of it.
    if (k + 1 == behind_lit_)
      block.edges.push_back(
          {static_cast<std::uint16_t>(at + 1), false, mark_.number, 0, 0});
  }
  if (outputs_.lit_outside_count() != outside) {
    return tl::make_unexpected(MarkError(
        ErrorCode::kRefused, mark_,
        "the mirrors do not reach it: with the correction, the lead of the servo or the "
        "web it is outside the field; move it away from the border"));
  }
  if (tracker_.follows()) {
    block.first_tick = first_tick;
    block.follow = FollowFrom(first_tick);
  }
  return block;
}

void MarkPlayer::Took(const link::HeadBlock& block) {
  next_ += block.ticks.size();
  output_ = block.ticks.back();
  const Vec2 by_mm = tracker_.follows()
                         ? DisplacementAt(block.first_tick + block.ticks.size() - 1)
                         : Vec2(Vec2::Zero());
  mirrors_mm_ = ticks_[next_ - 1].place_mm + by_mm;
  if (next_ == ticks_.size()) loaded_ = false;
}

link::HeadBlock MarkPlayer::Hold(std::uint64_t first_tick) const {
  link::HeadBlock block;
  block.first_tick = first_tick;
  block.ticks.assign(link::kMaxHeadTicks, {output_.x, output_.y, false});
  return block;
}

}  // namespace intaglio::drivers
