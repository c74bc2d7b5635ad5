#include "services/drivers/lockstep/piece_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::drivers {

Vec3 PieceQueue::Snapped(const Vec3& place_mm) const {
  return (place_mm.array() * steps_per_mm_.array()).round() / steps_per_mm_.array();
}

Status PieceQueue::Check(const Vec3& place_mm) const {
  const bool inside = (place_mm.array() >= travel_.min_mm.array()).all() &&
                      (place_mm.array() <= travel_.max_mm.array()).all();
  if (inside) return {};  // a NaN is not
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("the target {:.3f}, {:.3f}, {:.3f} mm lies outside the travel of "
                  "the axes: check block_origin_mm and the block",
                  place_mm.x(), place_mm.y(), place_mm.z()));
}

void PieceQueue::Begin(std::uint64_t start_tick, const Vec3& from_mm) {
  pieces_.clear();
  has_end_ = false;
  appended_ = {from_mm, Vec3::Zero()};
  appended_subticks_ = start_tick * motion::kSubticksPerTick;
}

void PieceQueue::Drop() {
  pieces_.clear();
  has_end_ = true;
}

Status PieceQueue::Append(std::span<const motion::Segment> segments, double rate_hz) {
  std::deque<Piece> pieces;
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

Status PieceQueue::Cut(const motion::KnotState& from, const motion::Segment& segment,
                       double rate_hz, std::uint64_t start_subticks,
                       std::deque<Piece>& pieces) const {
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

Piece PieceQueue::TakeFront() {
  Piece piece = std::move(pieces_.front());
  pieces_.pop_front();
  return piece;
}

Piece PieceQueue::TakeMerged(std::uint64_t decided_through) {
  Piece merged = TakeFront();
  while (!pieces_.empty() && !merged.pulse && !merged.end) {
    const Piece& next = pieces_.front();
    const bool fits = merged.duration_s + next.duration_s <= kMaxPiece_s + 1e-9;
    if (!fits || TickOf(next.start_subticks) > decided_through) break;
    merged.to_mm = next.to_mm;
    merged.duration_s += next.duration_s;
    merged.speed_mm_s = std::max(merged.speed_mm_s, next.speed_mm_s);
    merged.end_subticks = next.end_subticks;
    merged.pulse = next.pulse;
    merged.end = next.end;
    merged.at_ticks_mm.insert(merged.at_ticks_mm.end(), next.at_ticks_mm.begin(),
                              next.at_ticks_mm.end());
    pieces_.pop_front();
  }
  return merged;
}

PointList PlacesOnChord(const Vec3& from_mm, const Piece& piece) {
  const Vec3 way = piece.to_mm - from_mm;
  const double length2 = std::max(way.squaredNorm(), 1e-12);
  PointList places_mm;
  for (const Vec3& at_mm : piece.at_ticks_mm) {
    const double share = std::clamp(way.dot(at_mm - from_mm) / length2, 0.0, 1.0);
    places_mm.push_back(from_mm + way * share);
  }
  return places_mm;
}

}  // namespace intaglio::drivers
