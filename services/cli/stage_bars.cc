#include "services/cli/stage_bars.h"

namespace intaglio::cli {
namespace {

bool Ended(const JobView::Progress& p) {
  return p.total_count > 0 && p.done_count >= p.total_count;
}

}  // namespace

const JobView::Progress* StageAtWork(const JobView& job) {
  for (const JobView::Progress& p : job.progress) {
    if (!Ended(p)) return &p;
  }
  return job.progress.empty() ? nullptr : &job.progress.back();
}

void StageBars::Show(const JobView& job, const std::string& note) {
  const JobView::Progress* at_work = StageAtWork(job);
  for (const JobView::Progress& p : job.progress) {
    if (&p == at_work && p.stage == intaglio_STAGE_DISCRETIZE && !Ended(p)) {
      bar_.ShowShare(NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s, note);
    } else if (&p == at_work) {
      bar_.Show(NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s, note);
    } else if (Ended(p) && ended_.insert(p.stage).second) {
      bar_.Show(NameOf(p.stage), p.done_count, p.total_count, p.elapsed_s);
      bar_.Finish();
    }
  }
}

}  // namespace intaglio::cli
