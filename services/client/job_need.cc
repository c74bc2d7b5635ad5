#include "services/client/job_need.h"

#include <fmt/format.h>

#include "services/client/figure_text.h"

namespace intaglio::client {
namespace {

std::string PausedNeed(const JobView& job) {
  const std::string why = fmt::format("job {} is paused{}", job.number,
                                      job.message.empty() ? "" : ": " + job.message);
  if (job.counts.uncertain == 0)
    return fmt::format("{} (intaglio resume {}, or cancel)", why, job.number);
  const bool marks = job.makes == "marks";
  return fmt::format(
      "{0}; of {1} {2} it is not known whether they were {4}: check the {5}, then "
      "intaglio resume {3} to leave them as they are, or intaglio resume {3} "
      "--fire-uncertain to {6} them again",
      why, GroupedDigits(job.counts.uncertain), job.makes, job.number,
      marks ? "made to their end" : "fired", job.workpiece(), marks ? "make" : "fire");
}

/// The job service has a reason to refuse an arm, as what is mounted, and its sentence
/// names the command that comes before it.
bool NamesCommand(const std::string& message) {
  return message.find("intaglio ") != std::string::npos;
}

}  // namespace

std::string NeedOf(const JobView& job) {
  if (job.ended() || job.armed || job.state == intaglio_JOB_QUEUED) return "";
  if (const Warning* consent = job.open_consent()) {
    return fmt::format("job {} needs a consent: {} ({}, or cancel)", job.number,
                       consent->text, ArmCommandOf(job));
  }
  if (job.state == intaglio_JOB_PAUSED) return PausedNeed(job);
  if (job.state != intaglio_JOB_WAITING_FOR_ARM) return "";
  if (NamesCommand(job.message))
    return fmt::format("job {} waits for its arm: {}", job.number, job.message);
  const char* const piece = job.workpiece();
  if (job.awaits_block) {
    return fmt::format(
        "job {0} waits for its {3}: neither key nor door of {1} was opened and closed "
        "since the piece before it; change the {3} ({2}, if it is in)",
        job.number, job.cell, ArmCommandOf(job), piece);
  }
  return fmt::format("job {} waits for its arm: put its {} into {}, then {}", job.number,
                     piece, job.cell, ArmCommandOf(job));
}

std::string StateAndNextOf(const JobView& job) {
  if (const std::string need = NeedOf(job); !need.empty()) return need;
  const bool may_fire = job.armed && job.state == intaglio_JOB_WAITING_FOR_ARM;
  const std::string state =
      fmt::format("job {} is {}{}", job.number, may_fire ? "armed" : StateOf(job),
                  job.message.empty() ? "" : ": " + job.message);
  if (job.ended() || job.armed || job.state == intaglio_JOB_ENGRAVING) return state;
  return fmt::format("{}; nothing of it fires before {}", state, ArmCommandOf(job));
}

}  // namespace intaglio::client
