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
// Used from one thread; nothing waits, and only TakeConsent allocates.

#include <cstdint>
#include <utility>
#include <vector>

#include "services/cell/grant_inputs.h"
#include "services/cell/permission_chain.h"
#include "services/cell/point_ledger.h"

namespace intaglio::cell {

/// What is made of a job, point by point, as far as consent concerns it.
class UncertainPoints {
 public:
  virtual ~UncertainPoints() = default;
  virtual const PointLedger& ledger() const = 0;
  /// Before anything more is armed, the journal has that the consent of this grant was
  /// taken. False: its ring is full.
  virtual bool KeepConsent(std::uint64_t grant) = 0;
  /// Opens an uncertain point by consent of this grant. False: the journal's ring is
  /// full.
  virtual bool Reopen(std::uint32_t point, std::uint64_t grant) = 0;
};

/// What earlier lives left, and what the job asks for.
struct ConsentTerms {
  bool asks_when_uncertain = false;
  bool uncertain_unanswered = false;
  std::uint64_t consent_grant = 0;
};

class Consent {
 public:
  /// All outlive this.
  Consent(const ConsentTerms& terms, UncertainPoints& record,
          const PermissionChain& chain)
      : terms_(terms),
        record_(record),
        chain_(chain),
        grant_number_(terms.consent_grant) {}

  /// Whether the question of an earlier life is still open. Once, when the record has
  /// been taken up.
  void TakeUp();
  /// A point has become uncertain.
  void NoteUncertain();
  /// Takes consent that comes with the inputs' grant, once for each grant. `settling`:
  /// points that are armed now and become uncertain are covered, too.
  void TakeConsent(const GrantInputs& inputs, bool settling);
  /// Opens what is covered; with nothing armed. False: the journal's ring is full, go on
  /// in a later turn. `reopened_any` is set when a point was opened.
  bool Reopen(const GrantInputs& inputs, bool& reopened_any);

  /// A question is open, whether asked or not.
  bool asks() const { return asks_; }
  bool was_asked() const { return asked_; }
  /// The question has to be asked now: a grant is known that the question spends, and it
  /// was not answered before it came up.
  bool MustAsk(const GrantInputs& inputs) const;
  void NoteAsked() { asked_ = true; }
  /// A run begins: the question has been answered.
  void BeginRun() { asks_ = asked_ = false; }
  /// First and last of the uncertain points, for the question; {0, 0} without any.
  std::pair<std::uint32_t, std::uint32_t> UncertainRange() const;
  /// Covered points or an open question keep the job from being over. Only a grant that
  /// came after the question is an answer to it.
  bool KeepsJobOpen(const GrantInputs& inputs) const;

 private:
  bool IsOf(const Grant& grant) const {
    return grant_number_ > 0 && grant.number == grant_number_;
  }
  bool IsUncertain(std::uint32_t point) const {
    return record_.ledger().state(point) == PointState::kUncertain;
  }
  bool Holds(const GrantInputs& inputs) const;
  bool AnswersAll(const GrantInputs& inputs) const;

  const ConsentTerms terms_;
  UncertainPoints& record_;
  const PermissionChain& chain_;
  bool asks_ = false;
  bool asked_ = false;
  std::uint64_t grant_number_;          // greatest whose consent was taken
  std::vector<std::uint32_t> covered_;  // and not open yet
};

}  // namespace intaglio::cell
