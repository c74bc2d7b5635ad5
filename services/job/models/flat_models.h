#pragma once

// Drawings, texts and pictures of a job, placed, as sources of points by their method.
// `job` with its defaults filled in; errors do not name the model's file but where its
// reader does.

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/font_source.h"
#include "services/job/methods/point_maker.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

enum class SizeCheck { kDone, kLeftOut };

/// Of the kind that the name's ending says: .dxf, .svg, else HPGL. The texts of a DXF are
/// set in `text_font`, where there is one. What it holds that is no curve is added to
/// `warnings`. `unit_mm` replaces the unit of the file.
Result<drawing::Drawing> ReadDrawing(
    const std::string& name, std::string_view file, const drawing::DrawingLimits& limits,
    Warnings& warnings, const std::optional<drawing::FontSource>& text_font = {},
    std::optional<double> unit_mm = {});

/// What a file holds that is not engraved, and an implausible size (model_checks.h), is
/// added to `warnings`. `font`: the bytes of text.font of the model, if it has one.
/// `input` gets the unit of the file, unless the job has one.
MadePoints MakeDrawing(const Method& method, MethodInput& input, std::string_view file,
                       std::string_view font, const ReadLimits& limits,
                       SizeCheck size_check, Warnings& warnings);

/// A text of the model (text_model.h).
MadePoints MakeLetters(const Method& method, const MethodInput& input,
                       const drawing::Drawing& outline);

/// A code of the model: its dark modules, filled.
MadePoints MakeCodePoints(const Method& method, const MethodInput& input);

/// A picture of one even grey, such as a white logo on transparent ground, is added to
/// `warnings`.
MadePoints MakePicture(const Method& method, const MethodInput& input,
                       std::string_view file, const ReadLimits& limits,
                       Warnings& warnings);

/// The corners of a box around the picture's points and, where it is fitted, its frame:
/// dark borders have no points and count in the size that it is fitted to.
MadePoints ExtentOfPicture(const Method& method, const MethodInput& input,
                           std::string_view file, const ReadLimits& limits);

}  // namespace intaglio
