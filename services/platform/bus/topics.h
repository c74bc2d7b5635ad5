#pragma once

// Every topic of the product: its name, type, QoS profile, domain and scope, in one
// place. idl/ defines the fields.

#include <string_view>

#include "idl/cloud.h"
#include "idl/job.h"
#include "idl/laser.h"
#include "idl/motion.h"
#include "idl/safety.h"
#include "idl/service.h"
#include "idl/teach.h"

struct dds_topic_descriptor;

namespace intaglio::bus {

/// Control carries status, safety, commands and motion; bulk carries models and points.
/// They are separate DDS domains: a full bulk reader would hold up the control topics.
enum class DomainKind { kControl, kBulk };

/// The guarantees of a topic; qos.h defines them.
enum class Profile { kCommand, kState, kMotion, kEvent, kStream, kSafety, kBulk };

/// Shop topics are written by one role and have no partition; cell topics travel in the
/// partition of one machine; what several roles write, in that of its writer's role
/// (role_names.h).
enum class Scope { kShop, kCell, kRole };

template <typename T>
struct Topic {
  using Sample = T;
  const char* name;
  const dds_topic_descriptor* descriptor;
  Profile profile;
  DomainKind domain;
  Scope scope;
};

/// What tells the type from others: names, kinds and keys of all its members, at any
/// depth.
std::string_view TypeInformationOf(const dds_topic_descriptor& type);

inline constexpr Topic<intaglio_JobSubmission> kJobSubmission{
    "JobSubmission", &intaglio_JobSubmission_desc, Profile::kCommand,
    DomainKind::kControl, Scope::kShop};
inline constexpr Topic<intaglio_JobCommand> kJobCommand{
    "JobCommand", &intaglio_JobCommand_desc, Profile::kCommand, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_JobCommandAnswer> kJobCommandAnswer{
    "JobCommandAnswer", &intaglio_JobCommandAnswer_desc, Profile::kCommand,
    DomainKind::kControl, Scope::kShop};
inline constexpr Topic<intaglio_JobStatus> kJobStatus{
    "JobStatus", &intaglio_JobStatus_desc, Profile::kState, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_JobCount> kJobCount{"JobCount", &intaglio_JobCount_desc,
                                                    Profile::kState, DomainKind::kControl,
                                                    Scope::kShop};
inline constexpr Topic<intaglio_CellMount> kMounted{"Mounted", &intaglio_CellMount_desc,
                                                    Profile::kState, DomainKind::kControl,
                                                    Scope::kShop};
inline constexpr Topic<intaglio_StageTask> kDiscretizeTask{
    "DiscretizeTask", &intaglio_StageTask_desc, Profile::kCommand, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_StageTask> kSortTask{"SortTask", &intaglio_StageTask_desc,
                                                     Profile::kCommand,
                                                     DomainKind::kControl, Scope::kShop};
inline constexpr Topic<intaglio_StageTask> kEngraveTask{
    "EngraveTask", &intaglio_StageTask_desc, Profile::kCommand, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_TaskStatus> kTaskStatus{
    "TaskStatus", &intaglio_TaskStatus_desc, Profile::kState, DomainKind::kControl,
    Scope::kRole};
inline constexpr Topic<intaglio_ServiceHealth> kServiceHealth{
    "ServiceHealth", &intaglio_ServiceHealth_desc, Profile::kState, DomainKind::kControl,
    Scope::kRole};
inline constexpr Topic<intaglio_ServiceList> kServiceList{
    "ServiceList", &intaglio_ServiceList_desc, Profile::kState, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_MachineReport> kMachineReport{
    "MachineReport", &intaglio_MachineReport_desc, Profile::kState, DomainKind::kControl,
    Scope::kRole};
inline constexpr Topic<intaglio_KnownService> kKnownService{
    "KnownService", &intaglio_KnownService_desc, Profile::kState, DomainKind::kControl,
    Scope::kShop};
inline constexpr Topic<intaglio_Credit> kCredit{
    "Credit", &intaglio_Credit_desc, Profile::kState, DomainKind::kControl, Scope::kRole};
inline constexpr Topic<intaglio_Presence> kPresence{"Presence", &intaglio_Presence_desc,
                                                    Profile::kState, DomainKind::kControl,
                                                    Scope::kRole};
inline constexpr Topic<intaglio_Alarm> kAlarm{
    "Alarm", &intaglio_Alarm_desc, Profile::kEvent, DomainKind::kControl, Scope::kRole};
inline constexpr Topic<intaglio_DiskSpace> kDiskSpace{
    "DiskSpace", &intaglio_DiskSpace_desc, Profile::kState, DomainKind::kControl,
    Scope::kShop};

inline constexpr Topic<intaglio_ModelChunk> kModelChunk{
    "ModelChunk", &intaglio_ModelChunk_desc, Profile::kBulk, DomainKind::kBulk,
    Scope::kShop};
inline constexpr Topic<intaglio_PointBatch> kPointBatch{
    "PointBatch", &intaglio_PointBatch_desc, Profile::kBulk, DomainKind::kBulk,
    Scope::kShop};
inline constexpr Topic<intaglio_PathBatch> kPathBatch{
    "PathBatch", &intaglio_PathBatch_desc, Profile::kBulk, DomainKind::kBulk,
    Scope::kShop};

inline constexpr Topic<intaglio_MarkBatch> kMarkBatch{
    "MarkBatch", &intaglio_MarkBatch_desc, Profile::kBulk, DomainKind::kBulk,
    Scope::kShop};
inline constexpr Topic<intaglio_MarkBatch> kOrderedMarkBatch{
    "OrderedMarkBatch", &intaglio_MarkBatch_desc, Profile::kBulk, DomainKind::kBulk,
    Scope::kShop};

inline constexpr Topic<intaglio_MotionSegmentBatch> kMotionSegmentBatch{
    "MotionSegmentBatch", &intaglio_MotionSegmentBatch_desc, Profile::kMotion,
    DomainKind::kControl, Scope::kCell};
inline constexpr Topic<intaglio_MotionState> kMotionState{
    "MotionState", &intaglio_MotionState_desc, Profile::kStream, DomainKind::kControl,
    Scope::kCell};
inline constexpr Topic<intaglio_PositionReport> kPositionReport{
    "PositionReport", &intaglio_PositionReport_desc, Profile::kEvent,
    DomainKind::kControl, Scope::kCell};
inline constexpr Topic<intaglio_LampSync> kLampSync{"LampSync", &intaglio_LampSync_desc,
                                                    Profile::kStream,
                                                    DomainKind::kControl, Scope::kCell};
inline constexpr Topic<intaglio_PulseEventBatch> kPulseEventBatch{
    "PulseEventBatch", &intaglio_PulseEventBatch_desc, Profile::kEvent,
    DomainKind::kControl, Scope::kCell};
inline constexpr Topic<intaglio_Permission> kPermission{
    "Permission", &intaglio_Permission_desc, Profile::kSafety, DomainKind::kControl,
    Scope::kCell};
inline constexpr Topic<intaglio_EmergencyStop> kEmergencyStop{
    "EmergencyStop", &intaglio_EmergencyStop_desc, Profile::kSafety, DomainKind::kControl,
    Scope::kCell};
inline constexpr Topic<intaglio_Interlock> kInterlock{
    "Interlock", &intaglio_Interlock_desc, Profile::kState, DomainKind::kControl,
    Scope::kCell};

/// Of a person, by a client; its motion is executed by the bridge.
inline constexpr Topic<intaglio_ManualCommand> kManualCommand{
    "ManualCommand", &intaglio_ManualCommand_desc, Profile::kCommand,
    DomainKind::kControl, Scope::kCell};
/// The same by the cell's synchronizer, which drives before and after a job.
inline constexpr Topic<intaglio_ManualCommand> kCellMove{
    "CellMove", &intaglio_ManualCommand_desc, Profile::kCommand, DomainKind::kControl,
    Scope::kCell};
inline constexpr Topic<intaglio_ManualState> kManualState{
    "ManualState", &intaglio_ManualState_desc, Profile::kState, DomainKind::kControl,
    Scope::kCell};

/// Calls visit(topic) for every topic that is recorded, which is all but Presence.
template <typename Visit>
void ForEachTopic(Visit&& visit) {
  visit(kJobSubmission);
  visit(kJobCommand);
  visit(kJobCommandAnswer);
  visit(kJobStatus);
  visit(kJobCount);
  visit(kMounted);
  visit(kDiscretizeTask);
  visit(kSortTask);
  visit(kEngraveTask);
  visit(kTaskStatus);
  visit(kServiceHealth);
  visit(kServiceList);
  visit(kMachineReport);
  visit(kKnownService);
  visit(kCredit);
  visit(kAlarm);
  visit(kDiskSpace);
  visit(kModelChunk);
  visit(kPointBatch);
  visit(kPathBatch);
  visit(kMarkBatch);
  visit(kOrderedMarkBatch);
  visit(kMotionSegmentBatch);
  visit(kMotionState);
  visit(kPositionReport);
  visit(kLampSync);
  visit(kPulseEventBatch);
  visit(kPermission);
  visit(kEmergencyStop);
  visit(kInterlock);
  visit(kManualCommand);
  visit(kCellMove);
  visit(kManualState);
}

/// Calls visit(topic) for Presence, too.
template <typename Visit>
void ForEveryTopic(Visit&& visit) {
  ForEachTopic(visit);
  visit(kPresence);
}

}  // namespace intaglio::bus
