#include "services/platform/host/stage/mark_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

using bus::View;

intaglio_MarkPen WirePen(const mark::Pen& pen) {
  intaglio_MarkPen wire{};
  wire.name = bus::Borrow(pen.name);
  wire.speed_mm_s = pen.speed_mm_s;
  wire.power_ratio = pen.power_ratio;
  wire.frequency_hz = pen.frequency_hz;
  wire.pass_count = pen.pass_count;
  wire.depth_mm = pen.depth_mm;
  wire.plunge_mm_s = pen.plunge_mm_s;
  return wire;
}

mark::Pen PenOf(const intaglio_MarkPen& wire) {
  return {std::string(View(wire.name)),
          wire.speed_mm_s,
          wire.power_ratio,
          wire.frequency_hz,
          wire.pass_count,
          wire.depth_mm,
          wire.plunge_mm_s};
}

Status MarkFault(std::string what) {
  return Fail(ErrorCode::kFault,
              std::move(what) +
                  ": the sender has another version or is faulty; restart "
                  "it and submit the job again");
}

Status CheckArrays(const intaglio_MarkBatch& batch) {
  const std::size_t marks = batch.pen._length;
  const std::size_t places = batch.x_mm._length;
  const std::uint64_t dark = batch.dark._length;
  std::uint64_t sum = 0;
  for (const std::uint32_t count : View(batch.place_count)) sum += count;
  struct Array {
    const char* name;
    std::uint64_t length, needed;
  };
  for (const Array& array : {Array{"closed", batch.closed._length, marks},
                             {"web_mm", batch.web_mm._length, marks},
                             {"place_count", batch.place_count._length, marks},
                             {"the sum of place_count", sum, places},
                             {"y_mm", batch.y_mm._length, places},
                             {"bulge", batch.bulge._length, places},
                             {"dark", dark, dark == 0 ? 0 : places}}) {
    if (array.length == array.needed) continue;
    return MarkFault(
        fmt::format("mark batch {}: {} is {}, and not {}; it has {} "
                    "of {}",
                    batch.sequence_number, array.name, array.length, array.needed,
                    Counted(marks, "mark"), Counted(places, "place")));
  }
  return {};
}

}  // namespace

MarkColumns::MarkColumns(const mark::MarkSet& set, std::size_t first, std::size_t count) {
  if (first == 0) {
    for (const mark::Pen& pen : set.pens) pens_.push_back(WirePen(pen));
  }
  for (std::size_t i = first; i < first + count; ++i) {
    const mark::Mark& mark = set.marks[i];
    pen_.push_back(mark.pen);
    closed_.push_back(mark.closed ? 1 : 0);
    web_mm_.push_back(mark.web_mm);
    place_count_.push_back(static_cast<std::uint32_t>(mark.places.size()));
    for (const mark::Place& place : mark.places) {
      x_mm_.push_back(place.at_mm.x());
      y_mm_.push_back(place.at_mm.y());
      bulge_.push_back(place.bulge);
      dark_.push_back(place.dark ? 1 : 0);
    }
  }
  const auto is_lit = [](std::uint8_t dark) { return dark == 0; };
  if (std::ranges::all_of(dark_, is_lit)) dark_.clear();
}

void MarkColumns::BorrowTo(intaglio_MarkBatch& batch) const {
  bus::Borrow(batch.pens, pens_);
  bus::Borrow(batch.pen, pen_);
  bus::Borrow(batch.closed, closed_);
  bus::Borrow(batch.web_mm, web_mm_);
  bus::Borrow(batch.place_count, place_count_);
  bus::Borrow(batch.x_mm, x_mm_);
  bus::Borrow(batch.y_mm, y_mm_);
  bus::Borrow(batch.bulge, bulge_);
  bus::Borrow(batch.dark, dark_);
}

std::size_t BatchSizeAt(const mark::MarkSet& set, std::size_t first) {
  std::size_t places = 0, last = first;
  for (; last < set.marks.size() && last - first < kBatchMarks; ++last) {
    places += set.marks[last].places.size();
    if (places > kBatchPlaces && last > first) break;
  }
  return last - first;
}

Status CheckMarkRoom(const mark::MarkSet& set) {
  std::uint64_t places = 0;
  for (std::size_t i = 0; i < set.marks.size(); ++i) {
    const std::size_t count = set.marks[i].places.size();
    places += count;
    if (count <= kMaxMarkPlaces) continue;
    return Fail(ErrorCode::kTooLarge,
                fmt::format("mark {} has {} places, more than {}: divide its contour", i,
                            count, kMaxMarkPlaces),
                std::to_string(count));
  }
  if (set.marks.size() > kMaxMarks || places > kMaxPlaces || set.pens.size() > kMaxPens) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{} marks of {} places with {} pens are more than {}, {} and "
                            "{}: divide the job",
                            set.marks.size(), places, set.pens.size(), kMaxMarks,
                            kMaxPlaces, kMaxPens),
                std::to_string(set.marks.size()));
  }
  return {};
}

Status AppendMarks(const intaglio_MarkBatch& batch, mark::MarkSet& set) {
  INTAGLIO_TRY(CheckArrays(batch));
  mark::MarkSet taken;
  if (batch.first_mark == 0) {
    for (const intaglio_MarkPen& pen : View(batch.pens)) taken.pens.push_back(PenOf(pen));
  } else if (batch.pens._length != 0) {
    return MarkFault(fmt::format("mark batch {}: pens are of the first batch alone",
                                 batch.sequence_number));
  } else {
    taken.pens = set.pens;
  }
  const auto x = View(batch.x_mm), y = View(batch.y_mm), bulge = View(batch.bulge);
  const auto dark = View(batch.dark);
  std::size_t place = 0;
  for (std::size_t i = 0; i < batch.pen._length; ++i) {
    mark::Mark mark{
        batch.pen._buffer[i], batch.closed._buffer[i] != 0, batch.web_mm._buffer[i], {}};
    const std::uint32_t count = batch.place_count._buffer[i];
    mark.places.reserve(count);
    for (const std::size_t end = place + count; place < end; ++place)
      mark.places.push_back(
          {Vec2(x[place], y[place]), bulge[place], !dark.empty() && dark[place] != 0});
    taken.marks.push_back(std::move(mark));
  }
  if (const Status good = mark::CheckMarks(taken); !good) {
    return MarkFault(fmt::format("mark batch {}, from mark {} on: {}",
                                 batch.sequence_number, batch.first_mark,
                                 good.error().message));
  }
  if (const Status room = CheckMarkRoom(taken); !room) {
    return MarkFault(room.error().message);
  }
  set.pens = std::move(taken.pens);
  set.marks.insert(set.marks.end(), std::make_move_iterator(taken.marks.begin()),
                   std::make_move_iterator(taken.marks.end()));
  return {};
}

Status MarkCodec::Receiver::Append(const Batch& batch) {
  const std::uint64_t places = place_count_ + batch.x_mm._length;
  if (places > kMaxPlaces) {
    return MarkFault(fmt::format("mark batch {}: {} places have come, above {}",
                                 batch.sequence_number, places, kMaxPlaces));
  }
  INTAGLIO_TRY(AppendMarks(batch, content));
  place_count_ = places;
  return {};
}

Status MarkCodec::CheckTotal(const Batch& batch, std::uint64_t others) {
  const std::uint64_t total = others + batch.total_count;
  if (batch.total_count <= kMaxMarks && total <= kMaxMarks) return {};
  return MarkFault(fmt::format("mark batch {}: total_count is {}, above {}",
                               batch.sequence_number, total, kMaxMarks));
}

mark::MarkSet MarkCodec::Join(std::vector<mark::MarkSet> parts) {
  return parts.empty() ? mark::MarkSet() : std::move(parts.front());
}

}  // namespace intaglio::host
