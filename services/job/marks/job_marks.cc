#include "services/job/marks/job_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "engrave/mark/jump_order.h"
#include "services/job/checks/marks_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"
#include "services/job/marks/item_place.h"
#include "services/job/marks/mark_table.h"

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

class JobMarks {
 public:
  JobMarks(Marks marks, std::vector<std::string> names, std::vector<FileBytes> files,
           const ReadLimits& limits, Warnings& warnings)
      : marks_(std::move(marks)),
        files_(std::move(files)),
        limits_(limits),
        warnings_(warnings) {
    for (std::size_t i = 0; i < files_.size() && i < names.size(); ++i)
      named_.push_back(
          {names[i],
           {reinterpret_cast<const char*>(files_[i].data()), files_[i].size()}});
  }

  Result<mark::MarkSet> Make(const ProgressSink& progress) {
    INTAGLIO_TRY(DivideFiles());
    table_.emplace(INTAGLIO_TRY(MarkTable::Make(marks_, table_file_)));
    const std::size_t count = table_->repeat_count();
    for (int i = 0; i < marks_.items_size(); ++i)
      made_.pens.push_back(PenOf(marks_.items(i), i));
    constant_.resize(item_files_.size());
    for (std::size_t k = 0; k < count; ++k) {
      if (progress && !progress(k, count))
        return Fail(ErrorCode::kCancelled, "the making of marks was cancelled");
      INTAGLIO_TRY(AddRepeat(k));
    }
    INTAGLIO_TRY(mark::CheckMarks(made_));
    return std::move(made_);
  }

 private:
  /// To each item its own, in the order of JobMarkFilesOf.
  Status DivideFiles() {
    std::size_t next = 0;
    for (const MarkItem& item : marks_.items()) {
      const std::size_t first = next;
      if (item.has_drawing() || item.has_image()) next += 1;
      if (item.has_text())
        next += 1 + static_cast<std::size_t>(item.text().fallback_fonts_size());
      if (next > named_.size()) return TooFewFiles(next);
      item_files_.push_back(std::span(named_).subspan(first, next - first));
    }
    if (marks_.table().empty()) return {};
    if (next + 1 > named_.size()) return TooFewFiles(next + 1);
    table_file_ = named_[next];
    return {};
  }

  Status TooFewFiles(std::size_t needed) const {
    return Fail(ErrorCode::kMissing, fmt::format("marks.items: need {}, got {}",
                                                 Counted(needed, "file"), named_.size()));
  }

  Status AddRepeat(std::size_t repeat) {
    for (int i = 0; i < marks_.items_size(); ++i) {
      const MarkItem& item = marks_.items(i);
      auto& kept = constant_[static_cast<std::size_t>(i)];
      if (kept) {
        INTAGLIO_TRY(Append(*kept, repeat));
        continue;
      }
      const auto filled =
          INTAGLIO_TRY(table_->Fill(item, fmt::format("marks.items[{}]", i), repeat));
      auto marks = MarksOf(filled, static_cast<std::uint32_t>(i));
      if (!marks) return tl::unexpected(Named(std::move(marks.error()), i, repeat));
      INTAGLIO_TRY(Append(*marks, repeat));
      if (MarkTable::Varies(item)) continue;
      // Before all of them take their time.
      if (marks->size() > kMaxMarks / table_->repeat_count()) return TooManyMarks();
      kept = std::move(*marks);
    }
    return {};
  }

  Error Named(Error error, int item, std::size_t repeat) const {
    error.message = fmt::format("marks.items[{}].{}{}", item, error.message,
                                table_->NameOf(marks_.items(item), repeat));
    return error;
  }

  /// Makes the marks at the first repeat's place.
  Result<std::vector<mark::Mark>> MarksOf(const MarkItem& item, std::uint32_t pen) {
    const auto shapes =
        INTAGLIO_TRY(ShapesOf(item, item_files_[pen], limits_, warnings_));
    const ItemPlace place = PlaceOf(item.placement(), shapes);
    std::vector<mark::Mark> marks;
    std::vector<std::vector<Vec2>> closed;
    std::vector<mark::Mark> outlines;
    for (const MarkShape& shape : shapes.shapes) {
      mark::Mark outline{pen, shape.closed, 0, {}};
      outline.places.reserve(shape.places_mm.size());
      for (const Vec2& p : shape.places_mm) outline.places.push_back({place(p), 0});
      if (shape.closed) {
        closed.emplace_back();
        for (const mark::Place& p : outline.places) closed.back().push_back(p.at_mm);
      }
      outlines.push_back(std::move(outline));
    }
    if (item.has_hatch()) {
      auto chords = mark::Hatch(closed, HatchOptionsOf(item.hatch(), shapes, place));
      if (!chords) return tl::unexpected(OfFill(std::move(chords.error())));
      for (const mark::Chord& chord : *chords)
        marks.push_back({pen, false, 0, {{chord.from_mm, 0}, {chord.to_mm, 0}}});
    }
    for (mark::Mark& outline : outlines) {
      // A filled shape without its contour pass.
      if (item.has_hatch() && outline.closed && !item.hatch().contour()) continue;
      marks.push_back(std::move(outline));
    }
    return marks;
  }

  static Error OfFill(Error error) {
    error.message = "hatch.distance_mm: " + error.message;
    return error;
  }

  Status TooManyMarks() const {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("marks.repeats.count: {} repeats make more than {} marks; "
                            "use fewer, or a larger hatch.distance_mm",
                            table_->repeat_count(), kMaxMarks),
                fmt::format("{}", table_->repeat_count()));
  }

  Status Append(const std::vector<mark::Mark>& marks, std::size_t repeat) {
    if (made_.marks.size() + marks.size() > kMaxMarks) return TooManyMarks();
    const double along_mm = static_cast<double>(repeat) * marks_.repeats().pitch_mm();
    for (mark::Mark mark : marks) {
      if (marks_.has_web()) {
        mark.web_mm = along_mm;
      } else {
        for (mark::Place& place : mark.places) place.at_mm.x() += along_mm;
      }
      made_.marks.push_back(std::move(mark));
    }
    return {};
  }

  Marks marks_;
  std::vector<FileBytes> files_;
  const ReadLimits& limits_;
  Warnings& warnings_;
  std::vector<MarkFile> named_;
  std::vector<std::span<const MarkFile>> item_files_;
  MarkFile table_file_;
  std::optional<MarkTable> table_;
  std::vector<std::optional<std::vector<mark::Mark>>> constant_;  // of items that repeat
  mark::MarkSet made_;
};

}  // namespace

std::vector<std::string> JobMarkFilesOf(const JobSpec& job) {
  JobSpec marks;
  *marks.mutable_marks() = job.marks();
  std::vector<std::string> files;
  ForEachFile(marks,
              [&](std::string& file, const std::string&) { files.push_back(file); });
  return files;
}

Result<std::vector<FileBytes>> ReadJobMarkFiles(const JobSpec& job,
                                                const ReadLimits& limits) {
  std::vector<FileBytes> files;
  for (const std::string& name : JobMarkFilesOf(job)) {
    const auto text = io::ReadWholeFile(name, limits.max_file_bytes);
    if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
    const auto bytes = std::as_bytes(std::span(*text));
    files.emplace_back(bytes.begin(), bytes.end());
  }
  return files;
}

Result<mark::MarkSet> MakeJobMarks(const JobSpec& job, const MachineSpec&,
                                   std::vector<FileBytes> files, const ReadLimits& limits,
                                   Warnings& warnings, const ProgressSink& progress) {
  return JobMarks(WithDefaults(job.marks()), JobMarkFilesOf(job), std::move(files),
                  limits, warnings)
      .Make(progress);
}

HeadFigures HeadFiguresOf(const MachineSpec& machine) {
  const ScanHead& head = machine.scan_head();
  HeadFigures figures;
  if (head.field_mm() > 0) {
    // A sorter on another computer than the head's may not have the file: it plans with
    // the whole field, and the head's driver refuses what it cannot reach.
    figures.window = WindowOf(head).value_or(galvo::FieldWindow(head.field_mm()));
  }
  const double jump_mm_s = figures.ticks.jump_mm_s;
  figures.ticks = TickOptionsOf(head, mark::Pen(), figures.ticks.rate_hz);
  if (!(head.jump_mm_s() > 0)) figures.ticks.jump_mm_s = jump_mm_s;
  return figures;
}

Result<mark::MarkSet> OrderJobMarks(const JobSpec& job, const MachineSpec& machine,
                                    mark::MarkSet marks, const ProgressSink& progress) {
  const HeadFigures head = HeadFiguresOf(machine);
  const bool may_reverse =
      std::ranges::none_of(job.marks().items(), [](const MarkItem& item) {
        return item.has_hatch() && item.hatch().has_bidirectional() &&
               !item.hatch().bidirectional();
      });
  if (job.marks().has_web())
    return OrderForWeb(std::move(marks), head, may_reverse, progress);
  INTAGLIO_TRY(CheckField(marks, false, head));
  marks.marks = mark::OrderByJumps(std::move(marks.marks), {Vec2::Zero(), may_reverse});
  return marks;
}

}  // namespace intaglio
