#pragma once

// Marks as lists of a BJJCZ board, each so short that the board, which plays what it has
// to the end, is dark kMaxListSeconds behind the last that it was given. A mark that
// takes longer is made in several, and the beam rests dark where one ends and the next
// goes on.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engrave/mark/mark.h"
#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_field.h"
#include "services/drivers/bjjcz/board_list.h"
#include "services/drivers/bjjcz/guide_outline.h"

namespace intaglio::drivers {

class MarkLists {
 public:
  /// `scan_head` has field_mm and jump_mm_s: CheckBjjczProfile.
  explicit MarkLists(const MachineSpec& machine);

  /// An error names the pen and what the board cannot.
  Status Begin(std::span<const mark::Pen> pens);
  /// Of a mark that it cannot make, by its number.
  Status Check(std::uint32_t number, const mark::Mark& mark) const;
  void Load(const mark::Mark& mark);
  bool has_more() const { return next_ < moves_.size(); }
  /// The next list of the mark; has_more().
  LmcList Next();
  /// Where the beam is when all lists were executed, mm.
  Vec2 at_mm() const { return field_.ToMm(at_); }
  const BoardField& field() const { return field_; }
  GuideJumps guide_jumps() const { return {head_.jump_mm_s(), head_.jump_delay_s()}; }
  /// The next of an outline; no list of a mark is on its way.
  LmcList TakeGuide(GuideOutline& outline) { return outline.Next(at_); }

 private:
  struct Move {
    double x = 0, y = 0;  ///< in places of the board
    bool is_lit = false;
  };
  void AddHeader(LmcList& list);
  /// False: it has no room for anything of the next move.
  bool AddMove(LmcList& list);
  std::uint16_t SpeedOf(double speed_mm_s) const;
  double SecondsOf(const Move& move, double distance) const;
  bool ends_stroke(std::size_t move) const;

  ScanHead head_;
  BjjczBoard board_;
  BoardField field_;
  std::vector<mark::Pen> pens_;
  const mark::Pen* pen_ = nullptr;
  std::vector<Move> moves_;
  std::size_t next_ = 0;
  BoardPlace at_;
  bool first_of_run_ = true;
};

}  // namespace intaglio::drivers
