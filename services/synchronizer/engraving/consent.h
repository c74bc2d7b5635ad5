#pragma once

// The consent of a person to fire uncertain points again: points of which it is not known
// whether they were fired.
//
// Guarantees:
// - Without consent an uncertain point is left as it is, and a job that asks
//   (asks_when_uncertain) fires nothing more before a person has answered its question.
// - Consent comes with a grant, and counts once over all lives of the process: the
//   journal has it before anything more is armed.
// - It covers the points that are uncertain when it is taken, and, while a halt is being
//   settled, those that were armed before it and are found uncertain. What is armed
//   later, in this life or another, it does not cover, nor what a life had not reopened
//   before it ended. Points before the place that is engraved from are not covered
//   either.
// - A grant that is spent, replaced or comes without consent takes it back.
//
// The question of a job that asks:
//
//   quiet --a point becomes uncertain--> due --NoteAsked--> asked --a run begins--> quiet
//     ^                                   | ^                  |
//     +--- consent reopened all of them --+ +--- another one --+
//
// Used from one thread; nothing waits, and only Question and TakeConsent allocate.

#include <cstdint>
#include <string>
#include <vector>

#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/engraving_inputs.h"
#include "services/synchronizer/permission/permission_chain.h"
#include "services/synchronizer/pulses/pulse_record.h"

namespace intaglio::synchronizer {

class Consent {
 public:
  /// All outlive this. `job` has what earlier lives left.
  Consent(const EngravingJob& job, PulseRecord& record, const PermissionChain& chain)
      : job_(job),
        record_(record),
        chain_(chain),
        grant_number_(job.earlier.consent_grant) {}

  /// Whether the question of an earlier life is still open. Once, when the record has
  /// been taken up.
  void TakeUp();
  /// What became of a point.
  void Note(const PulseResult& result);
  /// Takes consent that comes with the inputs' grant, once for each grant. `settling`:
  /// points that are armed now and become uncertain are covered, too.
  void TakeConsent(const EngravingInputs& inputs, bool settling);
  /// Opens what is covered; with nothing armed. False: the journal's ring is full, go on
  /// in a later turn. `reopened_any` is set when a point was opened.
  bool Reopen(const EngravingInputs& inputs, bool& reopened_any);

  /// A question is open, whether asked or not.
  bool asks() const { return asks_; }
  bool was_asked() const { return asked_; }
  /// The question has to be asked now: a grant is known that the question spends, and it
  /// was not answered before it came up.
  bool MustAsk(const EngravingInputs& inputs) const;
  void NoteAsked() { asked_ = true; }
  /// A run begins: the question has been answered.
  void BeginRun() { asks_ = asked_ = false; }
  /// With the number and the places of the uncertain points, and both answers.
  std::string Question() const;
  /// Covered points or an open question keep the job from being over. Only a grant that
  /// came after the question is an answer to it.
  bool KeepsJobOpen(const EngravingInputs& inputs) const;

 private:
  bool IsOf(const Grant& grant) const {
    return grant_number_ > 0 && grant.number == grant_number_;
  }
  bool IsUncertain(std::uint32_t point) const {
    return record_.ledger().state(point) == PointState::kUncertain;
  }
  bool Holds(const EngravingInputs& inputs) const;
  bool AnswersAll(const EngravingInputs& inputs) const;

  const EngravingJob& job_;
  PulseRecord& record_;
  const PermissionChain& chain_;
  bool asks_ = false;
  bool asked_ = false;
  std::uint64_t grant_number_;          // greatest whose consent was taken
  std::vector<std::uint32_t> covered_;  // and not open yet
};

}  // namespace intaglio::synchronizer
