#pragma once

// Codes of a job (Data Matrix, QR), whether they are marked or engraved in a block.

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"
#include "engrave/matrix_code/matrix_code.h"
#include "proto/mark.pb.h"

namespace intaglio {

/// The modules of the code, with its rim where bright and dark are exchanged. `code` with
/// its defaults filled in. Errors: those of MakeCode, of the field code.text.
Result<matrix_code::ModuleGrid> GridOf(const MarkCode& code);

/// Its dark areas as closed curves, x to the right, y up, mm, the lower left corner of
/// the code at the origin. `inset_mm`: how far inside they lie, so that what is made
/// along them, a crack or a line, ends where the module does; 0 to half a module.
Result<drawing::Drawing> OutlineCode(const MarkCode& code, double inset_mm);

}  // namespace intaglio
