#pragma once

// Board files: protobuf text format of proto/laser_board.proto.

#include <filesystem>
#include <string>
#include <string_view>
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
/// All that the board has.
std::vector<NamedLine> BoardLines(const LaserBoard& board);

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
