#pragma once

// Board files: protobuf text format of proto/laser_board.proto.

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/result.h"
#include "proto/laser_board.pb.h"
#include "services/reference_controller/controller.h"

namespace intaglio::reference_controller {

/// A board file has below 2 kB; this leaves room for comments.
inline constexpr std::size_t kMaxBoardFileBytes = 1 << 20;

/// A line, as its field names it ("shutters[2]"), with the chip that it is on.
struct NamedLine {
  std::string name;
  BoardLine line;
};
/// All that a board has, of a message with BoardLines and a chip: a LaserBoard, or one
/// with axes that have some, too ("x.step").
std::vector<NamedLine> BoardLines(const google::protobuf::Message& board);

/// What is wrong with a board, collected.
class BoardFaults {
 public:
  /// Begins with the numbers that are out of their range.
  explicit BoardFaults(const google::protobuf::Message& board);

  void Add(std::string what, ErrorCode code = ErrorCode::kInvalidValue);
  /// `why`: what a signal that is not given is for.
  void Need(bool given, const std::string& field, const char* why);
  void CheckSerialNumber(const std::string& text);
  /// Two signals on one line would switch each other.
  void CheckLines(const std::vector<NamedLine>& lines);
  std::vector<Error> Errors() && { return std::move(errors_); }

 private:
  std::vector<Error> errors_;
};
/// kInvalidValue with every fault, one a line, of the file `name`.
Status JoinFaults(const std::string& name, const std::vector<Error>& faults);
/// Size and text alone; `what` the file should be. kTooLarge, kUnreadable.
Status ParseBoardText(std::string_view text, const std::string& name, const char* what,
                      google::protobuf::Message& board);

/// Every wrong value, each with the path of its field, the value and what is allowed.
std::vector<Error> CheckBoard(const LaserBoard& board);

/// Checked. kNotFound, kIo, kTooLarge; kUnreadable with "file:line:column: what";
/// kInvalidValue with every wrong value, one a line.
Result<LaserBoard> ReadBoardFile(const std::filesystem::path& file);
/// The same from memory; `name` is given for the file in errors.
Result<LaserBoard> ParseBoard(std::string_view text, const std::string& name);

/// `board` is checked; `power_up` is not 0.
ControllerOptions OptionsOf(const LaserBoard& board, std::uint32_t power_up);

}  // namespace intaglio::reference_controller
