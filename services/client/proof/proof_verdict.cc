#include "services/client/proof/proof_verdict.h"

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include "engrave/core/counted.h"
#include "engrave/io/whole_file.h"
#include "services/client/proof/evidence/collisions.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/client/proof/marks/mark_verdict.h"
#include "services/job/verdict/verdict.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace pb = google::protobuf;

constexpr std::uint64_t kMaxReportBytes = 64u << 20;

void AddFaults(const JobReport& report, Verdict& verdict) {
  const PointCounts& points = report.points();
  const auto need = [&](bool holds, std::string reason) {
    if (!holds) verdict.add_reasons(std::move(reason));
  };
  need(points.planned() > 0, "the plan has no points");
  for (const CollisionReport& collision : report.collisions())
    need(false, CollisionText(collision));
  const auto none = [&](std::uint64_t count, const char* what) {
    need(count == 0,
         fmt::format("{} {} {}", Counted(count, "point"), WasOrWere(count), what));
  };
  none(points.doubled(), "made twice");
  need(points.stray() == 0,
       fmt::format("{} {} to no planned point", Counted(points.stray(), "crack"),
                   VerbFor(points.stray(), "belongs", "belong")));
  none(points.skipped(), "skipped");
  none(points.missed(), "fired without a crack");
  const std::uint64_t open = points.unaccounted();
  need(open == 0, report.evidence() == kControllerEvidence
                      ? fmt::format("it is unknown whether {} {} fired: check the block",
                                    Counted(open, "point"), WasOrWere(open))
                      : fmt::format("{} {} unaccounted for: journal and glass disagree",
                                    Counted(open, "point"), IsOrAre(open)));
  const PositionErrors& errors = report.position_errors();
  need(errors.max_um() <= ToleranceUm(errors),
       fmt::format("a crack is {:.2f} um off, the tolerance is {:.2f} um",
                   errors.max_um(), ToleranceUm(errors)));
  none(report.shadow_violations(), "fired through an earlier crack");
  need(KeepsSpacing(report),
       fmt::format("two planned points are {:.4f} mm apart, nearer than {:.4f} mm",
                   report.measured_spacing_mm(), report.min_spacing_mm()));
}

std::string TextOf(const pb::Struct& object, const char* field) {
  const auto found = object.fields().find(field);
  return found == object.fields().end() ? std::string() : found->second.string_value();
}

Warning WarningOfJson(const pb::Value& value) {
  if (!value.has_struct_value()) return {.text = value.string_value()};
  const pb::Struct& object = value.struct_value();
  return {WarningCodeOf(TextOf(object, "code")),
          WarningWeightOf(TextOf(object, "weight")), TextOf(object, "text")};
}

}  // namespace

void Judge(JobReport& report) {
  Verdict& verdict = *report.mutable_verdict();
  verdict.Clear();
  if (report.has_marks()) {
    AddMarkFaults(report, verdict);
  } else {
    AddFaults(report, verdict);
  }
  const Warnings warnings = WarningsOf(report.warnings());
  const VerdictKind kind =
      VerdictFor({verdict.reasons().begin(), verdict.reasons().end()}, warnings).verdict;
  if (kind == VerdictKind::kGoodWithWarnings) {
    for (const Warning& warning : AtLeast(WarningWeight::kWarning, warnings))
      verdict.add_reasons(warning.text);
  }
  verdict.set_good(kind == VerdictKind::kGood);
  verdict.set_kind(VerdictName(kind));
}

void AddWarningsOf(const std::filesystem::path& report_file, JobReport& report) {
  const auto text = io::ReadWholeFile(report_file, kMaxReportBytes);
  pb::Struct json;
  if (!text || !pb::util::JsonStringToMessage(*text, &json).ok()) return;
  const auto warnings = json.fields().find("warnings");
  if (warnings != json.fields().end()) {
    for (const pb::Value& value : warnings->second.list_value().values()) {
      *report.add_warnings() = RecordOf(WarningOfJson(value));
    }
  }
  report.set_breakage_accepted_by(TextOf(json, "breakage_accepted_by"));
}

}  // namespace intaglio::client
