#include "services/history/job_names.h"

namespace intaglio::history {

const char* StateName(intaglio_JobState state) {
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

const char* PauseReasonName(intaglio_PauseReason reason) {
  switch (reason) {
    case intaglio_PAUSE_NONE:
      return "";
    case intaglio_PAUSE_OPERATOR:
      return "operator";
    case intaglio_PAUSE_NOT_ARMED:
      return "not_armed";
    case intaglio_PAUSE_FAULT:
      return "fault";
    case intaglio_PAUSE_EMERGENCY_STOP:
      return "emergency_stop";
    case intaglio_PAUSE_INTERLOCK:
      return "interlock";
    case intaglio_PAUSE_MACHINE_CHANGED:
      return "machine_changed";
    case intaglio_PAUSE_ABSENCE:
      return "absence";
    case intaglio_PAUSE_CLOSED:
      return "closed";
    case intaglio_PAUSE_UNCERTAIN_POINTS:
      return "uncertain_points";
    case intaglio_PAUSE_LINE_LOST:
      return "line_lost";
    case intaglio_PAUSE_SYNCHRONIZER_LOST:
      return "synchronizer_lost";
    case intaglio_PAUSE_RESTART:
      return "restart";
  }
  return "unknown";
}

}  // namespace intaglio::history
