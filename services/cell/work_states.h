#pragma once

// What the states of a job at a machine have in common, be it one of points or of marks:
// how the permission chain, another device at a line and the question about uncertain
// points act on it, and how a halt is explained. Engraving and Marking add the states of
// their own; CellTask sees a job through this alone.
//
// Once a turn the maker calls, in this order: TurnChain (what it returns halts the run),
// RefuseArms, ReceiveConsent, AskOverUncertain.
//
// Used from one thread; no waits.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/cell/consent.h"
#include "services/cell/grant_inputs.h"
#include "services/cell/permission_chain.h"
#include "services/cell/point_ledger.h"

namespace intaglio::cell {

class WorkStates {
 public:
  enum class Activity : std::uint8_t {
    kIdle,     ///< before, between or behind runs: nothing is armed
    kRuns,     ///< from the shutter that opens for a run to its end
    kSettles,  ///< a halt: what was armed is settled
    kDone,
  };

  virtual ~WorkStates() = default;

  /// Nothing more is fired or marked; what is armed is settled over the next turns, or
  /// left open in the journal when the line stays down. For cancelled jobs and the end of
  /// the process; `lamp_stays` for a job that will be taken up again.
  void Stop(const std::string& why, bool lamp_stays = false);

  virtual Activity activity() const = 0;
  virtual const PointLedger& ledger() const = 0;
  virtual std::uint32_t run_count() const = 0;
  /// Made ones that are known from the controller's memory, not from a report.
  virtual std::uint64_t settled_by_memory_count() const = 0;
  /// Makes nothing until a person or an event outside allows it.
  virtual bool waits() const = 0;

  /// What it waits for or why it halted; empty while all is well.
  const std::string& message() const { return message_; }
  /// Why it makes no progress, though nothing halts it for good; empty: it does.
  const std::string& alarm() const { return alarm_; }
  /// Halted by a fault, not by a withdrawn permission: the grant is spent.
  bool faulted() const { return chain_.has_spent(); }
  /// A line or a neighbouring process was lost, not the machine's safety: it may be
  /// resumed without a person at the machine.
  bool lost_a_line() const { return lost_a_line_; }
  /// It asks about uncertain points, and has no answer yet.
  bool asks() const { return consent_.asks(); }
  bool started() const { return run_count() > 0 || taken_up_; }

 protected:
  /// `chain` has begun the job, and is turned by this from now on. Both outlive this, or
  /// are members of the class that derives from it.
  WorkStates(PermissionChain& chain, Consent& consent);

  /// Key, door and stop latch also before and between runs. Returns what was not seen and
  /// halts a run, or kNothing: an interlock that is open now halts it by itself.
  Missing TurnChain(ChainLinks links, std::chrono::nanoseconds now);
  /// Each arm is spent while `why` is not empty. A line that leads to another machine is
  /// not a lost line: a person is changing cables, and has to arm when that is done. So
  /// is a zero that is not the job's.
  void RefuseArms(const std::string& why);
  void ReceiveConsent(const GrantInputs& inputs);
  /// Nothing but a fresh permission, or a state that is late (ChainLinks), is missing for
  /// a run. A machine that can wait without harm (a spindle that goes on turning, a
  /// machine whose time is simulated) rests then and goes on when it comes: it is handed
  /// nothing meanwhile. Any other halts.
  bool IsOnlyLate(ChainLinks links, bool with_shutters) const;
  /// Also when nothing is open any more: the question spends the grant, as a fault does,
  /// and the answer is a newer grant. Before any grant was received, there is none that
  /// could be spent.
  void AskOverUncertain(const GrantInputs& inputs);
  /// A halt. `fault`: the grant it ran with is spent, or its renewal alone when only a
  /// line was lost, by what was `missing`.
  void Explain(Missing missing, const std::string& text, bool lost_a_line, bool fault,
               bool starts_again = false);

  /// stopping_ from now on.
  virtual void NoteStop(bool /*lamp_stays*/) {}
  /// With the number and the places of what is uncertain, and both answers.
  virtual std::string Question() const = 0;
  virtual std::string TextFor(Missing missing) const = 0;

  static const char kLatePermission[], kLateState[];

  PermissionChain& chain_;
  std::string message_, alarm_;
  bool starts_again_ = false;  ///< by itself, after a run that was broken off
  bool lost_a_line_ = false;
  bool stopping_ = false;
  bool taken_up_ = false;  ///< from an earlier life

 private:
  Consent& consent_;
};

}  // namespace intaglio::cell
