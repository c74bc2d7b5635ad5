#include "services/job/marks/repeat_marks.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/mark/hatch.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/marks/dot_rows.h"
#include "services/job/marks/item_place.h"
#include "services/job/marks/job_marks.h"

namespace intaglio {
namespace {

mark::Pen PenOf(const MarkItem& item, int number) {
  mark::Pen pen;
  pen.name = fmt::format("item {}", number + 1);
  pen.speed_mm_s = item.pen().speed_mm_s();
  pen.power_ratio = item.pen().power_ratio();
  pen.frequency_hz = item.pen().frequency_hz();
  pen.pass_count = item.pen().pass_count();
  return pen;
}

/// Lines of a code lie alike in each of its modules.
double LineDistance(const MarkHatch& hatch, double module_mm) {
  if (module_mm <= 0) return hatch.distance_mm();
  return module_mm / std::ceil(module_mm / hatch.distance_mm() - 1e-9);
}

mark::HatchOptions HatchOptionsOf(const MarkHatch& hatch, const MarkShapes& shapes,
                                  const ItemPlace& place) {
  mark::HatchOptions options;
  options.distance_mm = LineDistance(hatch, shapes.module_mm * place.scale);
  options.angle_rad = place.angle_rad + hatch.angle_deg() * std::numbers::pi / 180;
  options.cross = hatch.cross();
  options.bidirectional = hatch.bidirectional();
  options.rule = shapes.rule;
  if (hatch.rule() == MARK_FILL_RULE_EVEN_ODD) options.rule = mark::InsideRule::kEvenOdd;
  if (hatch.rule() == MARK_FILL_RULE_NONZERO) options.rule = mark::InsideRule::kNonZero;
  options.inset_mm = hatch.inset_mm();
  return options;
}

/// The item's closed shapes filled with lines, before its curves.
Status AddLines(const MarkItem& item, const MarkShapes& shapes, const ItemPlace& place,
                std::uint32_t pen, const std::vector<mark::Mark>& outlines,
                std::vector<mark::Mark>& marks) {
  std::vector<std::vector<Vec2>> closed;
  for (const mark::Mark& outline : outlines) {
    if (!outline.closed) continue;
    closed.emplace_back().reserve(outline.places.size());
    for (const mark::Place& p : outline.places) closed.back().push_back(p.at_mm);
  }
  auto chords = mark::Hatch(closed, HatchOptionsOf(item.hatch(), shapes, place));
  if (!chords) {
    chords.error().message = "hatch.distance_mm: " + chords.error().message;
    return tl::unexpected(std::move(chords.error()));
  }
  marks.reserve(chords->size());
  for (const mark::Chord& chord : *chords)
    marks.push_back({pen, false, 0, {{chord.from_mm, 0}, {chord.to_mm, 0}}});
  return {};
}

/// Dots of rows count as marks.
std::size_t WayCountOf(const std::vector<mark::Mark>& marks) {
  std::size_t count = 0;
  for (const mark::Mark& mark : marks) count += mark::LitWayCount(mark);
  return count;
}

}  // namespace

RepeatMarks::RepeatMarks(std::shared_ptr<const JobOfMarks> job)
    : job_(std::move(job)),
      fonts_(job_->item_files.size()),
      constant_(job_->item_files.size()) {}

Result<RepeatMarks> RepeatMarks::Open(const JobSpec& job, const MachineSpec& machine,
                                      std::vector<FileBytes> files,
                                      const ReadLimits& limits) {
  auto read = std::make_shared<JobOfMarks>();
  read->marks = WithDefaults(job.marks());
  read->files = std::move(files);
  read->limits = limits;
  const std::vector<std::string> names = JobMarkFilesOf(job);
  for (std::size_t i = 0; i < read->files.size() && i < names.size(); ++i)
    read->named.push_back(
        {names[i],
         {reinterpret_cast<const char*>(read->files[i].data()), read->files[i].size()}});
  INTAGLIO_TRY(read->DivideFiles());
  read->table = INTAGLIO_TRY(MarkTable::Make(read->marks, read->table_file));
  for (int i = 0; i < read->marks.items_size(); ++i)
    read->pens.push_back(PenOf(read->marks.items(i), i));
  for (const MarkItem& item : read->marks.items())
    read->rows.push_back(DotRowsOf(item, read->marks.has_web(), machine));
  return RepeatMarks(std::move(read));
}

RepeatMarks RepeatMarks::Another() const {
  RepeatMarks another(job_);
  another.constant_ = constant_;
  return another;
}

Status RepeatMarks::JobOfMarks::DivideFiles() {
  std::size_t next = 0;
  for (const MarkItem& item : marks.items()) {
    const std::size_t first = next;
    if (item.has_drawing() || item.has_image()) next += 1;
    if (item.has_text())
      next += 1 + static_cast<std::size_t>(item.text().fallback_fonts_size());
    if (next > named.size()) return TooFewFiles(next);
    item_files.push_back(std::span(named).subspan(first, next - first));
  }
  if (marks.table().empty()) return {};
  if (next + 1 > named.size()) return TooFewFiles(next + 1);
  table_file = named[next];
  return {};
}

Status RepeatMarks::JobOfMarks::TooFewFiles(std::size_t needed) const {
  return Fail(ErrorCode::kMissing, fmt::format("marks.items: need {}, got {}",
                                               Counted(needed, "file"), named.size()));
}

Status RepeatMarks::CheckCount(std::size_t marks) const {
  if (marks <= kMaxMarks) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("marks.repeats.count: {} repeats make more than {} marks; "
                          "use fewer, or a larger hatch.distance_mm",
                          count(), kMaxMarks),
              fmt::format("{}", count()));
}

Result<std::vector<mark::Mark>> RepeatMarks::Make(std::size_t repeat,
                                                  Warnings& warnings) {
  std::vector<mark::Mark> made;
  for (int i = 0; i < job_->marks.items_size(); ++i) {
    const MarkItem& item = job_->marks.items(i);
    auto& kept = constant_[static_cast<std::size_t>(i)];
    if (kept) {
      Append(*kept, repeat, made);
      continue;
    }
    const auto filled =
        INTAGLIO_TRY(job_->table->Fill(item, fmt::format("marks.items[{}]", i), repeat));
    auto marks = MarksOf(filled, static_cast<std::uint32_t>(i), warnings);
    if (!marks) return tl::unexpected(Named(std::move(marks.error()), i, repeat));
    if (!MarkTable::Varies(item)) {
      // Before all of them take their time.
      INTAGLIO_TRY(CheckCount(WayCountOf(*marks) * count()));
      kept = std::make_shared<const std::vector<mark::Mark>>(*marks);
    }
    Append(*std::move(marks), repeat, made);
  }
  return made;
}

Error RepeatMarks::Named(Error error, int item, std::size_t repeat) const {
  error.message = fmt::format("marks.items[{}].{}{}", item, error.message,
                              job_->table->NameOf(job_->marks.items(item), repeat));
  return error;
}

/// Makes the marks at the first repeat's place.
Result<std::vector<mark::Mark>> RepeatMarks::MarksOf(const MarkItem& item,
                                                     std::uint32_t pen,
                                                     Warnings& warnings) {
  const auto shapes = INTAGLIO_TRY(ShapesOf(item, job_->item_files[pen], job_->limits,
                                            job_->rows[pen], fonts_[pen], warnings));
  const ItemPlace place = PlaceOf(item.placement(), shapes);
  std::vector<mark::Mark> outlines;
  outlines.reserve(shapes.shapes.size());
  for (const MarkShape& shape : shapes.shapes) {
    mark::Mark outline{pen, shape.closed, 0, {}};
    outline.places.reserve(shape.places_mm.size());
    for (const Vec2& p : shape.places_mm) outline.places.push_back({place(p), 0});
    for (std::size_t i = 1; shape.dashed && i + 1 < outline.places.size(); i += 2)
      outline.places[i].dark = true;
    outlines.push_back(std::move(outline));
  }
  if (!item.has_hatch()) return outlines;
  std::vector<mark::Mark> marks;
  INTAGLIO_TRY(AddLines(item, shapes, place, pen, outlines, marks));
  for (mark::Mark& outline : outlines) {
    // A filled shape without its contour pass.
    if (outline.closed && !item.hatch().contour()) continue;
    marks.push_back(std::move(outline));
  }
  return marks;
}

void RepeatMarks::Append(std::vector<mark::Mark> marks, std::size_t repeat,
                         std::vector<mark::Mark>& made) const {
  const double along_mm = static_cast<double>(repeat) * job_->marks.repeats().pitch_mm();
  made.reserve(made.size() + marks.size());
  for (mark::Mark& mark : marks) {
    if (job_->marks.has_web()) {
      mark.web_mm = along_mm;
    } else {
      for (mark::Place& place : mark.places) place.at_mm.x() += along_mm;
    }
    made.push_back(std::move(mark));
  }
}

}  // namespace intaglio
