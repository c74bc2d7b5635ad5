#pragma once

// The consent of a person (services/cell/consent.h) to fire uncertain points again.

#include <string>

#include "services/cell/consent.h"
#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/pulses/pulse_record.h"

namespace intaglio::synchronizer {

class Consent final : public cell::Consent {
 public:
  /// All outlive this. `job` has what earlier lives left.
  Consent(const EngravingJob& job, PulseRecord& record, const PermissionChain& chain)
      : cell::Consent({job.asks_when_uncertain, job.earlier.uncertain_unanswered,
                       job.earlier.consent_grant},
                      record, chain),
        job_(job),
        record_(record) {}

  /// What became of a point.
  void Note(const PulseResult& result) {
    if (result.outcome == formats::PointOutcome::kUncertain) NoteUncertain();
  }
  /// With the number and the places of the uncertain points, and both answers.
  std::string Question() const;

 private:
  const EngravingJob& job_;
  const PulseRecord& record_;
};

}  // namespace intaglio::synchronizer
