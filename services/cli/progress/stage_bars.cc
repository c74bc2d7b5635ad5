#include "services/cli/progress/stage_bars.h"

#include "services/cli/progress/time_left.h"
#include "services/client/figure_text.h"

namespace intaglio::cli {

std::string EstimateNote(const client::JobView& job) {
  const client::JobView::Progress* p = client::StageAtWork(job);
  const bool begun =
      p != nullptr && p->stage == intaglio_STAGE_ENGRAVE && p->done_count > 0;
  if (begun || job.ended() || job.estimate_ticks == 0 || job.rate_hz <= 0) return "";
  return "machining time " +
         client::ShortDuration(static_cast<double>(job.estimate_ticks) / job.rate_hz);
}

void StageBars::Show(const client::JobView& job, const std::string& note) {
  const client::JobView::Progress* at_work = client::StageAtWork(job);
  for (const client::JobView::Progress& p : job.progress) {
    if (&p == at_work && p.stage == intaglio_STAGE_DISCRETIZE && !p.ended()) {
      bar_.ShowShare(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s,
                     note);
    } else if (&p == at_work) {
      bar_.Expect(
          p.stage == intaglio_STAGE_ENGRAVE ? client::EngravingSeconds(job, speed_) : 0);
      bar_.Show(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s, note);
    } else if (p.ended() && ended_.insert(p.stage).second) {
      bar_.Show(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s);
      bar_.Finish();
    }
  }
}

}  // namespace intaglio::cli
