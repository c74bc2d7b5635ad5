#pragma once

// Board files of a stage: protobuf text format of proto/stage_board.proto.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/stage_board.pb.h"
#include "services/reference_controller/board_file.h"
#include "services/reference_controller/stage_controller.h"

namespace intaglio::reference_controller {

/// Every wrong value, each with the path of its field, the value and what is allowed.
std::vector<Error> CheckStageBoard(const StageBoard& board);

/// As ReadBoardFile and ParseBoard.
Result<StageBoard> ReadStageBoardFile(const std::filesystem::path& file);
Result<StageBoard> ParseStageBoard(std::string_view text, const std::string& name);

/// A line of the stage that is one of the laser's, too: kInvalidValue names both signals.
Status CheckLinesApart(const LaserBoard& laser, const StageBoard& stage);

/// `board` is checked; `power_up` is not 0.
StageControllerOptions OptionsOf(const StageBoard& board, std::uint32_t power_up);

}  // namespace intaglio::reference_controller
