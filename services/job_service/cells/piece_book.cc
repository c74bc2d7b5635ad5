#include "services/job_service/cells/piece_book.h"

#include <fmt/format.h>

#include <algorithm>

#include "proto/task.pb.h"

namespace intaglio::job_service {

JobPlace PlaceOf(const std::string& frozen_job) {
  FrozenJob frozen;
  if (frozen_job.empty() || !frozen.ParseFromString(frozen_job)) return {};
  JobPlace place;
  if (frozen.machine().has_loading())
    place.station = std::max(1u, frozen.job().station());
  if (!frozen.job().has_block()) return place;
  const Vector3& size_mm = frozen.job().block().size_mm();
  place.block = fmt::format("{} x {} x {}", size_mm.x(), size_mm.y(), size_mm.z());
  return place;
}

void PieceBook::Restore(const std::vector<PieceRecord>& pieces,
                        const std::vector<LoadedBlock>& blocks) {
  for (const PieceRecord& piece : pieces) pieces_[piece.cell] = piece;
  for (const LoadedBlock& block : blocks)
    loaded_[block.cell][block.block_id] = block.job_uid;
}

DoorState PieceBook::DoorOf(const std::string& cell) const {
  const auto door = doors_.find(cell);
  return door == doors_.end() ? DoorState::kUnknown : door->second;
}

void PieceBook::Open(PieceRecord& piece) {
  piece.opened = true;
  actions_.PieceChanged(piece);
}

bool PieceBook::IsAtAnotherStation(const JobRecord& job, const PieceRecord& piece) {
  return job.place.station > 0 && job.place.block == piece.block &&
         std::ranges::find(piece.stations, job.place.station) == piece.stations.end();
}

bool PieceBook::Awaits(const JobRecord& job) const {
  const auto found = pieces_.find(job.cell);
  if (found == pieces_.end() || found->second.job_uid == job.uid) return false;
  const PieceRecord& piece = found->second;
  if (piece.opened) return DoorOf(job.cell) != DoorState::kClosed;
  return !IsAtAnotherStation(job, piece);
}

CommandAnswer PieceBook::Check(const JobRecord& job, const CommandView& command) const {
  if (command.basis == intaglio_ARM_BY_LOADER) return CheckLoader(job, command);
  // What is not known is no statement of a person.
  const bool by_person =
      command.basis == intaglio_ARM_BY_PERSON || command.basis == intaglio_ARM_SAME_BLOCK;
  if (by_person || !Awaits(job)) return {};
  return {intaglio_ANSWER_SAME_BLOCK, WhyNot(job)};
}

std::string PieceBook::WhyNot(const JobRecord& job) const {
  const PieceRecord& piece = pieces_.at(job.cell);
  if (!piece.opened) {
    return fmt::format(
        "no program arms job {0}: neither the key nor the door of {1} was opened since "
        "job {2} was made, so its {3} may still be in the machine: open the door, "
        "change the {3} and close it; or, if the right {3} is in, intaglio arm {0}",
        job.number, job.cell, piece.job_number, job.workpiece());
  }
  if (DoorOf(job.cell) == DoorState::kOpen) {
    return fmt::format(
        "no program arms job {} while the key or the door of {} is open: put its {} in "
        "and close it",
        job.number, job.cell, job.workpiece());
  }
  return fmt::format(
      "no program arms job {0}: it is not known whether key and door of {1} are closed: "
      "check the line to its controller; or, if the right {2} is in, intaglio arm {0}",
      job.number, job.cell, job.workpiece());
}

CommandAnswer PieceBook::CheckLoader(const JobRecord& job,
                                     const CommandView& command) const {
  if (command.block_id.empty()) {
    return {intaglio_ANSWER_SAME_BLOCK,
            fmt::format("a loader arms job {} with the identity of the block that it has "
                        "put into {}: block_id is empty",
                        job.number, job.cell)};
  }
  const auto machine = loaded_.find(job.cell);
  if (machine == loaded_.end()) return {};
  const auto owner = machine->second.find(command.block_id);
  if (owner == machine->second.end() || owner->second == job.uid) return {};
  return {intaglio_ANSWER_SAME_BLOCK,
          fmt::format("the block {} was put into {} for job {} before: load another one "
                      "for job {}",
                      command.block_id, job.cell, owner->second, job.number)};
}

void PieceBook::NoteArmed(const JobRecord& job, const CommandView& command) {
  if (command.basis != intaglio_ARM_BY_LOADER) return;
  loaded_[job.cell][command.block_id] = job.uid;
  actions_.BlockLoaded({job.cell, command.block_id, job.uid});
}

void PieceBook::NoteGranted(const JobRecord& job) {
  PieceRecord& piece = pieces_[job.cell];
  if (piece.job_uid == job.uid) return;
  if (!IsAtAnotherStation(job, piece) || piece.opened) piece.stations.clear();
  piece.cell = job.cell;
  piece.job_uid = job.uid;
  piece.job_number = job.number;
  piece.opened = false;
  piece.block = job.place.block;
  if (job.place.station > 0) piece.stations.push_back(job.place.station);
  actions_.PieceChanged(piece);
}

}  // namespace intaglio::job_service
