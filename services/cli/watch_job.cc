#include "services/cli/watch_job.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "services/cli/progress/progress_bar.h"
#include "services/cli/progress/stage_bars.h"
#include "services/cli/progress/warning_lines.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/job_need.h"

namespace intaglio::cli {

std::string NoteOf(const client::JobView& job) {
  const std::string need = client::NeedOf(job);
  std::string note = !need.empty()         ? need
                     : job.message.empty() ? client::StateOf(job)
                                           : job.message;
  const bool waits = job.armed && job.state != intaglio_JOB_ENGRAVING;
  if (waits && !job.message.empty()) note = "armed, " + note;
  if (job.state == intaglio_JOB_PAUSED && job.armed) note = "paused: " + note;
  if (const std::string estimate = EstimateNote(job); !estimate.empty()) {
    note = estimate + ", " + note;
  }
  if (!job.alarm.empty()) note += "; ALARM " + job.alarm;
  const std::string speed = client::SpeedNote(job.speed_percent);
  return speed.empty() ? note : note + ", " + speed;
}

namespace {

using namespace std::chrono_literals;

int PrintEnd(client::JobClient& client, const client::JobView& job,
             client::EventLines* events) {
  const client::JobEnd end = EndOf(client, job);
  if (events != nullptr) events->Ended(job, end);
  std::ostream& human = events != nullptr ? std::cerr : std::cout;
  human << "job " << job.number << " " << client::NameOf(job.state)
        << (job.message.empty() ? "" : ": " + job.message) << "\n";
  if (!end.verdict.reason.empty()) {
    human << "verdict: " << VerdictName(end.verdict.verdict) << ", " << end.verdict.reason
          << "\n";
  }
  return ExitCodeOf(job, end.verdict);
}

}  // namespace

int WatchJob(client::JobClient& client, const std::string& uid,
             client::EventLines* events) {
  CatchInterrupts();
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  StageBars bars(bar);
  WarningLines warnings(bar);
  for (;;) {
    const client::JobView& job = client.jobs().at(uid);
    warnings.Show(job.warnings);
    bars.Show(job, NoteOf(job));
    if (job.ended()) {
      bar.Finish();
      return PrintEnd(client, client::JobView(job), events);
    }
    if (client.IsForgotten(uid)) {
      bar.Finish();
      return Complain(
          {ErrorCode::kNotFound,
           fmt::format(
               "job {0} has ended while this program was stopped or disconnected, and "
               "the job service no longer lists it: see intaglio history --job {0}",
               job.number),
           uid},
          client::kExitInternal);
    }
    if (events != nullptr) events->Show(job);
    if (Interrupts() > 0) {
      bar.Finish();
      std::cerr << "the job continues; intaglio cancel " << job.number << " ends it\n";
      return client::kExitLeft;
    }
    client.Poll(100ms);
  }
}

}  // namespace intaglio::cli
