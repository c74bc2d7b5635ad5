#pragma once

// Calls visit(topic) for every topic of services/platform/bus/topics.h: ForEachTopic for
// those that are recorded, which is all but Presence, ForEveryTopic for that one, too.

#include "services/platform/bus/topics.h"

namespace intaglio::test {

template <typename Visit>
void ForEachTopic(Visit&& visit) {
  visit(bus::kJobSubmission);
  visit(bus::kJobCommand);
  visit(bus::kJobCommandAnswer);
  visit(bus::kJobStatus);
  visit(bus::kJobCount);
  visit(bus::kMounted);
  visit(bus::kDiscretizeTask);
  visit(bus::kSortTask);
  visit(bus::kEngraveTask);
  visit(bus::kTaskStatus);
  visit(bus::kServiceHealth);
  visit(bus::kServiceList);
  visit(bus::kMachineReport);
  visit(bus::kKnownService);
  visit(bus::kCredit);
  visit(bus::kAlarm);
  visit(bus::kDiskSpace);
  visit(bus::kModelChunk);
  visit(bus::kPointBatch);
  visit(bus::kPathBatch);
  visit(bus::kMarkBatch);
  visit(bus::kOrderedMarkBatch);
  visit(bus::kMotionSegmentBatch);
  visit(bus::kMotionState);
  visit(bus::kPositionReport);
  visit(bus::kLampSync);
  visit(bus::kPulseEventBatch);
  visit(bus::kPermission);
  visit(bus::kEmergencyStop);
  visit(bus::kInterlock);
  visit(bus::kManualCommand);
  visit(bus::kCellMove);
  visit(bus::kManualState);
}

template <typename Visit>
void ForEveryTopic(Visit&& visit) {
  ForEachTopic(visit);
  visit(bus::kPresence);
}

}  // namespace intaglio::test
