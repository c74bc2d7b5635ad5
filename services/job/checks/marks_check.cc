#include "services/job/checks/marks_check.h"

#include <filesystem>
#include <utility>

#include "engrave/drawing/font_list.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/convert/placeholders.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/machine/head_ticks.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

void CheckMarkFile(const std::string& file, const std::string& path, Findings& findings) {
  const bool is_font = path.find(".text.") != std::string::npos;
  if (file.empty()) return findings.Missing(path, "name a {}", is_font ? "font" : "file");
  std::error_code error;
  if (fs::is_regular_file(file, error)) return;
  if (is_font && !drawing::IsFontFile(file)) {
    return findings.Wrong(path, file,
                          "is no font of this computer; name a file, or one that "
                          "`intaglio fonts` lists");
  }
  findings.Wrong(path, file, "does not exist or is not a file");
}

void CheckMarkText(const std::string& text, const std::string& path, bool has_table,
                   Findings& findings) {
  if (text.empty()) return findings.Missing(path, "give the text to mark");
  for (const std::string& name : PlaceholdersOf(text)) {
    if (name == "n" || has_table) continue;
    return findings.Wrong(path, "{" + name + "}",
                          "needs a table with this column; name its file in marks.table, "
                          "or write {{{{ and }}}} for braces");
  }
}

void CheckTextOptions(const Text& text, const std::string& path, Findings& findings) {
  if (text.shrink_to_fit() || text.has_max_width_mm() || text.has_max_height_mm()) {
    findings.Wrong(path + ".shrink_to_fit", text.shrink_to_fit(),
                   "and max_width_mm, max_height_mm are of blocks; use "
                   "placement.fit_width_mm or fit_height_mm");
  }
}

void CheckImageItem(const MarkItem& item, const std::string& path, Findings& findings) {
  const MarkImage& image = item.image();
  if (!MarkImageMake_IsValid(image.make())) {
    findings.Wrong(path + ".image.make", static_cast<int>(image.make()), "is none, 0..{}",
                   static_cast<int>(MarkImageMake_MAX));
  }
  if (item.has_hatch()) {
    findings.Wrong(path + ".hatch.distance_mm", item.hatch().distance_mm(),
                   "is of closed curves, and an image has none; remove the hatch");
  }
  if (image.make() != MARK_IMAGE_MAKE_DOTS && image.has_dot_mm()) {
    findings.Wrong(path + ".image.dot_mm", image.dot_mm(),
                   "is of MARK_IMAGE_MAKE_DOTS; remove it, or make dots");
  }
  if (!MarkDotMode_IsValid(image.dot_mode())) {
    findings.Wrong(path + ".image.dot_mode", static_cast<int>(image.dot_mode()),
                   "is none, 0..{}", static_cast<int>(MarkDotMode_MAX));
  } else if (image.make() != MARK_IMAGE_MAKE_DOTS &&
             image.dot_mode() != MARK_DOT_MODE_DEFAULT) {
    findings.Wrong(path + ".image.dot_mode", MarkDotMode_Name(image.dot_mode()),
                   "is of MARK_IMAGE_MAKE_DOTS; remove it, or make dots");
  }
}

void CheckItem(const MarkItem& item, const std::string& path, bool has_table,
               Findings& findings) {
  switch (item.content_case()) {
    case MarkItem::kText:
      CheckMarkText(item.text().text(), path + ".text.text", has_table, findings);
      CheckTextOptions(item.text(), path + ".text", findings);
      break;
    case MarkItem::kCode:
      CheckMarkText(item.code().text(), path + ".code.text", has_table, findings);
      if (!MarkCodeKind_IsValid(item.code().kind())) {
        findings.Wrong(path + ".code.kind", static_cast<int>(item.code().kind()),
                       "is none, 0..{}", static_cast<int>(MarkCodeKind_MAX));
      }
      break;
    case MarkItem::kImage:
      CheckImageItem(item, path, findings);
      break;
    case MarkItem::kDrawing:
      break;
    default:
      findings.Missing(path, "give it a drawing, a text, an image or a code");
  }
  if (!MarkFillRule_IsValid(item.hatch().rule())) {
    findings.Wrong(path + ".hatch.rule", static_cast<int>(item.hatch().rule()),
                   "is none, 0..{}", static_cast<int>(MarkFillRule_MAX));
  }
}

void CheckExclusions(const JobSpec& job, Findings& findings) {
  if (!job.models().empty()) {
    findings.Wrong("models", job.models_size(),
                   "are given beside marks; make a job of each");
  }
  if (job.has_course()) {
    findings.Wrong("course.make", static_cast<int>(job.course().make()),
                   "is given beside marks; make a job of each");
  }
  const MarkRepeats& repeats = job.marks().repeats();
  const bool several =
      repeats.count() > 1 || !job.marks().table().empty() || job.marks().web().has_eye();
  if (several && !repeats.has_pitch_mm()) {
    findings.Missing("marks.repeats.pitch_mm",
                     "give the way from one repeat to the next, 0.001..100000 mm");
  }
}

/// Of the print marks that are expected.
void CheckEye(const Marks& given, Findings& findings) {
  if (!given.web().has_eye() || !given.repeats().has_pitch_mm()) return;
  const Marks marks = WithDefaults(given);
  const double tolerance_mm = marks.web().eye().tolerance_mm();
  if (tolerance_mm < marks.repeats().pitch_mm() / 2) return;
  findings.Wrong("marks.web.eye.tolerance_mm", tolerance_mm,
                 "mm is half of marks.repeats.pitch_mm or more, {:g} mm, so that a print "
                 "mark would be that of two repeats; give less",
                 marks.repeats().pitch_mm());
}

/// That it has a photo eye, where the job needs one.
void CheckEyeOn(const MachineSpec& machine, const Marks& marks, Findings& findings) {
  if (!marks.web().has_eye() || machine.scan_head().has_eye_mm()) return;
  findings.Wrong("marks.web.eye.offset_mm", marks.web().eye().offset_mm(),
                 "is from print marks, and {} has no photo eye: its profile has no "
                 "scan_head.eye_mm; remove marks.web.eye, or name the profile of a head "
                 "with an eye in machine_file",
                 machine.name());
}

/// That it can make the rows of dots that the job asks for.
void CheckDotRows(const MachineSpec& machine, const Marks& given, Findings& findings) {
  const Marks marks = WithDefaults(given);
  for (int i = 0; i < marks.items_size(); ++i) {
    const MarkItem& item = marks.items(i);
    if (item.image().dot_mode() != MARK_DOT_MODE_ROWS) continue;
    const std::string why =
        WhyNoDotRows(machine, item.image().dot_mm(), item.pen().speed_mm_s());
    if (why.empty()) continue;
    findings.Wrong(fmt::format("marks.items[{}].image.dot_mode", i),
                   MarkDotMode_Name(item.image().dot_mode()),
                   "is not possible on {}: {}, or use MARK_DOT_MODE_EACH", machine.name(),
                   why);
  }
}

}  // namespace

std::vector<Finding> CheckMarks(const JobSpec& job) {
  Findings findings;
  CheckEye(job.marks(), findings);
  CheckRanges(job.marks(), "marks", findings.found());
  if (job.marks().items().empty()) {
    findings.Missing("marks.items", "give a drawing, a text, an image or a code");
  }
  for (int i = 0; i < job.marks().items_size(); ++i) {
    CheckItem(job.marks().items(i), fmt::format("marks.items[{}]", i),
              !job.marks().table().empty(), findings);
  }
  CheckExclusions(job, findings);
  JobSpec marks;
  *marks.mutable_marks() = job.marks();
  ForEachFile(marks, [&](const std::string& file, const std::string& path) {
    CheckMarkFile(file, path, findings);
  });
  if (job.machine_file().empty()) {
    findings.Missing("machine_file", "name the profile of a machine that marks");
  }
  return std::move(findings.found());
}

std::vector<Finding> CheckMarksOnMachine(const JobSpec& job, const MachineSpec& machine) {
  Findings findings;
  if (!machine.has_mark_line()) {
    findings.Wrong("marks.items", job.marks().items_size(),
                   "items to mark, and {} engraves points: its profile has no mark_line; "
                   "name the profile of a machine that marks in machine_file",
                   machine.name());
  } else if (!machine.has_scan_head()) {
    findings.Wrong("marks.items", job.marks().items_size(),
                   "items to mark, and {} has no scan head: its profile has no "
                   "scan_head; name the profile of one in machine_file",
                   machine.name());
  } else if (job.marks().has_web() && !FollowsWeb(machine.scan_head())) {
    findings.Wrong("marks.web.speed_mm_s", job.marks().web().speed_mm_s(),
                   "is of a web, and {} does not follow one: its profile has no "
                   "scan_head.encoder_count_um, or follow_web: false; remove marks.web, "
                   "or name the profile of a head with an encoder in machine_file",
                   machine.name());
  } else {
    CheckEyeOn(machine, job.marks(), findings);
    CheckDotRows(machine, job.marks(), findings);
  }
  return std::move(findings.found());
}

}  // namespace intaglio
