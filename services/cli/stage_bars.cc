#include "services/cli/stage_bars.h"

namespace intaglio::cli {

void StageBars::Show(const client::JobView& job, const std::string& note) {
  const client::JobView::Progress* at_work = client::StageAtWork(job);
  for (const client::JobView::Progress& p : job.progress) {
    if (&p == at_work && p.stage == intaglio_STAGE_DISCRETIZE && !p.ended()) {
      bar_.ShowShare(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s,
                     note);
    } else if (&p == at_work) {
      bar_.Show(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s, note);
    } else if (p.ended() && ended_.insert(p.stage).second) {
      bar_.Show(client::NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s);
      bar_.Finish();
    }
  }
}

}  // namespace intaglio::cli
