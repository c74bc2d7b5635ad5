#pragma once

// Whose block is in each machine, as far as a job service can know: the rule that a
// program arms no job for a block that is another one's.
//
// clang-format off
//   no piece --a job is granted--> in work --it ends--> made --key or door open--> opened
//                                    ^                   |                            |
//                                    +--granted (*)------+--------- granted ----------+
// clang-format on
//
// 1. A machine's piece is the job that was granted a permission there last: its block may
//    have cracks.
// 2. An arm by a program counts when there is no piece, or once the piece was made the
//    key or the door was open and both are closed again. What was open while the piece
//    was in work changes nothing.
// 3. (*) It also counts for another station of the same loading: one that was not granted
//    since the last opening, for a block of the same size.
// 4. An arm by a loader counts for a block that no other job of the machine had.
// 5. A person's statement counts without these, and so does every arm of the piece
// itself. A state of key and door that is not known opens nothing and closes nothing.
// Used from one thread; keeps its changes through JobActions before they have an effect.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "services/job_service/records/job_actions.h"

namespace intaglio::job_service {

/// Key and door of a machine, as its laser controller reports them.
enum class DoorState : std::uint8_t { kUnknown, kOpen, kClosed };

/// The place of a serialized FrozenJob; one that is not readable is nowhere.
JobPlace PlaceOf(const std::string& frozen_job);

class PieceBook {
 public:
  explicit PieceBook(JobActions& actions) : actions_(actions) {}

  /// Restores those of an earlier run of the job service.
  void Restore(const std::vector<PieceRecord>& pieces,
               const std::vector<LoadedBlock>& blocks);
  void SetDoor(const std::string& cell, DoorState state) { doors_[cell] = state; }
  /// Once a turn: of every machine whose piece is made. `is_open`: the job has not ended.
  template <typename IsOpen>
  void Turn(const IsOpen& is_open) {
    for (auto& [cell, piece] : pieces_) {
      if (!piece.opened && !is_open(piece.job_uid) && DoorOf(cell) == DoorState::kOpen)
        Open(piece);
    }
  }

  /// A program's arm of this job does not count now.
  bool Awaits(const JobRecord& job) const;
  /// Whether the arm counts, by what it is based on; else why not, and what to do.
  CommandAnswer Check(const JobRecord& job, const CommandView& command) const;
  /// A loader's block belongs to this job from now on.
  void NoteArmed(const JobRecord& job, const CommandView& command);
  /// The first permission for this job, before it is handed out.
  void NoteGranted(const JobRecord& job);

 private:
  DoorState DoorOf(const std::string& cell) const;
  void Open(PieceRecord& piece);
  static bool IsAtAnotherStation(const JobRecord& job, const PieceRecord& piece);
  CommandAnswer CheckLoader(const JobRecord& job, const CommandView& command) const;
  std::string WhyNot(const JobRecord& job) const;

  JobActions& actions_;
  std::map<std::string, PieceRecord> pieces_;                         // by cell
  std::map<std::string, DoorState> doors_;                            // by cell
  std::map<std::string, std::map<std::string, std::string>> loaded_;  // cell, block: job
};

}  // namespace intaglio::job_service
