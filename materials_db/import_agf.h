#pragma once

// Zemax glass catalogs (AGF): text, one line a kind of value, a glass from its NM line to
// the next. Read are
//   CC  comment of the catalog            GC  comment of the glass
//   NM  name, formula number 1..13, ..., nd (the 4th value)
//   ED  expansion -30..70 C in 1e-6/K, ..., density in g/cm3 (the 3rd value)
//   CD  coefficients                      LD  wavelength range, um
//   MD  Young's modulus in GPa, Poisson's ratio, hardness, specific heat in J/(g K),
//       conductivity in W/(m K), as in SCHOTT's data sheets
//   IT  wavelength in um, internal transmittance, thickness in mm
// and nothing else. Values of 0 or less are unknown, as is "-"; coefficients that lack
// are 0.

#include <cstddef>
#include <string_view>

#include "materials_db/import_result.h"

namespace intaglio::materials_db {

/// The largest catalogs known have about 1 MB.
inline constexpr std::size_t kMaxAgfBytes = 16 * 1024 * 1024;

/// After this many errors the reading of the file ends.
inline constexpr std::size_t kMaxAgfErrors = 100;

/// `bytes`: ASCII, UTF-8, Latin-1, or UTF-16 with a byte order mark. `catalog`: the
/// file's name without its ending; it becomes the manufacturer.
Imported ImportAgf(std::string_view bytes, std::string_view catalog);

}  // namespace intaglio::materials_db
