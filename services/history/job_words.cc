#include "services/history/job_words.h"

namespace intaglio::history {

const char* StateWord(intaglio_JobState state) {
  switch (state) {
    case intaglio_JOB_QUEUED:
      return "queued";
    case intaglio_JOB_DISCRETIZING:
      return "discretizing";
    case intaglio_JOB_SORTING:
      return "ordering";
    case intaglio_JOB_WAITING_FOR_ARM:
      return "waiting_for_arm";
    case intaglio_JOB_ENGRAVING:
      return "engraving";
    case intaglio_JOB_PAUSED:
      return "paused";
    case intaglio_JOB_DONE:
      return "done";
    case intaglio_JOB_FAILED:
      return "failed";
    case intaglio_JOB_CANCELLED:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace intaglio::history
