#include "services/marker/begun_zero.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/cell/begun_job.h"
#include "services/platform/host/process/log.h"

namespace intaglio::marker {
namespace {

/// The profile of such a machine has no taught zeros.
FrozenJob WithZero(const FrozenJob& job, const Vec3& zero_mm) {
  FrozenJob begun = job;
  TaughtPositions& taught = *begun.mutable_machine()->mutable_taught();
  taught.clear_zeros();
  Vector3& place = *taught.add_zeros()->mutable_block_origin_mm();
  place.set_x(zero_mm.x());
  place.set_y(zero_mm.y());
  place.set_z(zero_mm.z());
  return begun;
}

std::optional<Vec3> ZeroOf(const FrozenJob& begun) {
  if (begun.machine().taught().zeros_size() != 1) return std::nullopt;
  const Vector3& place = begun.machine().taught().zeros(0).block_origin_mm();
  return Vec3(place.x(), place.y(), place.z());
}

std::string TextOfOther(const Vec3& now_mm, const Vec3& begun_mm) {
  const Vec3 back_mm = begun_mm - now_mm;
  return fmt::format(
      "the work zero of the controller is at {:.3f}, {:.3f}, {:.3f} mm of its axes, and "
      "the job was begun with {:.3f}, {:.3f}, {:.3f} mm: move the tool to {:.3f}, "
      "{:.3f}, "
      "{:.3f} mm from the zero and set it there (`intaglio teach zero`), or cancel the "
      "job",
      now_mm.x(), now_mm.y(), now_mm.z(), begun_mm.x(), begun_mm.y(), begun_mm.z(),
      back_mm.x(), back_mm.y(), back_mm.z());
}

}  // namespace

Status BegunZero::Begin(const FrozenJob& job, bool taken_up) {
  if (taken_up && job_uid_ == job.job_uid()) return {};
  *this = {};
  job_uid_ = job.job_uid();
  taken_up_ = taken_up;
  if (!taken_up) return {};
  const auto begun = INTAGLIO_TRY(cell::ReadBegunJob(job.result_directory()));
  if (begun) zero_mm_ = ZeroOf(*begun);
  return {};
}

void BegunZero::Turn(const FrozenJob& job, const drivers::MarkDeviceState& state,
                     Sight sight) {
  // What it was while the line is down, or the place is lost, is asked again.
  if (!state.link_up || !state.work_offset_mm || !state.place_lost.empty()) return;
  const Vec3& now_mm = *state.work_offset_mm;
  const bool other_axes = state.axes_number != axes_number_;
  refusal_.clear();
  if (!sight.started || other_axes) {
    if (sight.has_grant && (other_axes || zero_mm_ != now_mm)) Record(job, state);
    return;
  }
  if (!zero_mm_ && !taken_up_) return Record(job, state);
  if (!zero_mm_) {
    refusal_ = fmt::format(
        "{}/{} has no work zero, but the job was begun: nobody knows with which; check "
        "the piece, cancel the job, and make it again on a new one",
        job.result_directory(), cell::kJobFile);
  } else if ((now_mm - *zero_mm_).norm() > kSameZero_mm) {
    refusal_ = TextOfOther(now_mm, *zero_mm_);
  }
}

void BegunZero::Record(const FrozenJob& job, const drivers::MarkDeviceState& state) {
  const Vec3& zero_mm = *state.work_offset_mm;
  const auto written =
      cell::WriteBegunJob(job.result_directory(), WithZero(job, zero_mm));
  if (!written) {
    refusal_ = written.error().message;
    return;
  }
  zero_mm_ = zero_mm;
  axes_number_ = state.axes_number;
  host::LogInfo("job {} is made with the work zero at {:.3f}, {:.3f}, {:.3f} mm",
                job.job_uid(), zero_mm.x(), zero_mm.y(), zero_mm.z());
}

}  // namespace intaglio::marker
