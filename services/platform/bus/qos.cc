#include "services/platform/bus/qos.h"

#include <dds/dds.h>

namespace intaglio::bus::internal {
namespace {

// How long a write may wait for room in the library's own buffers.
constexpr dds_duration_t kControlBlocking = DDS_MSECS(100);
constexpr dds_duration_t kBulkBlocking = DDS_SECS(1);
constexpr std::int32_t kMotionDepth = 64;
constexpr std::int32_t kEventDepth = 512;

void Retained(dds_qos_t* qos) {
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, kControlBlocking);
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, 1, -1, -1, -1);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
}

void Everything(dds_qos_t* qos, dds_duration_t blocking) {
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, blocking);
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
}

}  // namespace

void QosDeleter::operator()(dds_qos* qos) const noexcept { dds_delete_qos(qos); }

QosPointer QosOf(Profile profile, Side side) {
  const bool writes = side == Side::kWriter;
  QosPointer qos(dds_create_qos());
  switch (profile) {
    case Profile::kCommand:
      Retained(qos.get());
      break;
    case Profile::kState:
      Retained(qos.get());
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, DDS_MSECS(1500));
      break;
    case Profile::kMotion:
    case Profile::kEvent: {
      const auto depth = profile == Profile::kMotion ? kMotionDepth : kEventDepth;
      Everything(qos.get(), kControlBlocking);
      if (writes) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
      break;
    }
    case Profile::kStream:
      dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
      dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
      dds_qset_deadline(qos.get(), DDS_MSECS(500));
      break;
    case Profile::kSafety:
      Retained(qos.get());
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(250));
      dds_qset_deadline(qos.get(), DDS_MSECS(200));
      break;
    case Profile::kBulk:
      Everything(qos.get(), kBulkBlocking);
      break;
  }
  return qos;
}

}  // namespace intaglio::bus::internal
