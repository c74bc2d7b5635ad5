#pragma once

// Marks as blocks of ticks for the controller of a scan head: their ticks by
// engrave/galvo, moved with the web, corrected, within the field.

#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "engrave/galvo/field_window.h"
#include "engrave/galvo/head_output.h"
#include "engrave/galvo/mark_ticks.h"
#include "services/drivers/galvo/head_profile.h"
#include "services/drivers/galvo/head_tracker.h"
#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

class MarkPlayer {
 public:
  MarkPlayer(const ScanHead& head, std::optional<galvo::CorrectionTable> correction);

  HeadTracker& tracker() { return tracker_; }
  void SetRate(double rate_hz) { rate_hz_ = rate_hz; }
  /// A run with these pens; the mirrors are there, field, mm.
  void Begin(std::span<const mark::Pen> pens, const Vec2& mirrors_mm);

  /// Errors of a mark that cannot be made on this machine: its pen, its places, its time.
  Status Check(const NumberedMark& mark) const;

  /// Takes a mark whose ticks come next. Only when !playing(). `origin_count`: the
  /// encoder's count when the origin of its repeat is in the middle of the field; none:
  /// by its web_mm since the begin of the run.
  Status Load(const NumberedMark& mark, std::optional<double> origin_count = {});
  bool playing() const { return loaded_; }
  /// Its ticks follow those that were sent without a gap.
  bool placed() const { return placed_ && next_ > 0; }

  /// The ticks that come next, played from `first_tick` on; of a piece at rest they are
  /// behind those before, `first_tick` is not used, and the block does not name it.
  /// Nothing yet: its place is not in the field, or its ticks are being made. kRefused:
  /// it has left it. They are counted as sent by Took.
  Result<std::optional<link::HeadBlock>> NextBlock(std::uint64_t first_tick);
  void Took(const link::HeadBlock& block);
  /// Mirrors that rest, of a web whose samples are waited for.
  link::HeadBlock Hold(std::uint64_t first_tick) const;

 private:
  /// Its places can be brought where the mirrors reach with the correction.
  Status CheckPlaces(const NumberedMark& mark) const;
  Status MakeTicks(const Vec2& from_mm);
  Status TakeTicks(Result<std::vector<galvo::MarkTick>> ticks);
  /// Of a web: its first mark is about to enter the field.
  void BeginWeb();
  /// Of a web: makes the ticks when the mark can begin at that tick.
  Status Place(std::uint64_t first_tick);
  Vec2 DisplacementAt(std::uint64_t tick);
  double SurpriseAfter(std::size_t ticks) const;
  link::HeadFollow FollowFrom(std::uint64_t first_tick) const;

  ScanHead head_;
  std::optional<galvo::CorrectionTable> correction_;
  galvo::FieldWindow window_;
  galvo::OutputMaker outputs_;
  HeadTracker tracker_;
  double rate_hz_ = 1e5;
  std::vector<mark::Pen> pens_;
  NumberedMark mark_;
  bool loaded_ = false;
  bool placed_ = false;  // its ticks are made for the moment of its beginning
  std::vector<galvo::MarkTick> ticks_;
  std::future<Result<std::vector<galvo::MarkTick>>> made_aside_;  // of a long mark
  std::size_t next_ = 0, first_lit_ = 0, behind_lit_ = 0;
  std::uint64_t retry_tick_ = 0;        // it cannot begin before
  std::optional<double> origin_count_;  // of the repeat that begins at a print mark
  std::optional<double> web_begin_mm_;  // displacement of the web when the run began
  Vec2 mirrors_mm_ = Vec2::Zero();      // field, as commanded last, before the correction
  link::HeadTick output_;
};

}  // namespace intaglio::drivers
