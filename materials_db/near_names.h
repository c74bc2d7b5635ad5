#pragma once

// Names that are spelled alike, or nearly.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::materials_db {

/// What two spellings of one name have in common: no case, hyphens, underscores or
/// spaces.
std::string SpellingOf(std::string_view name);

/// The names a person may have meant, nearest first, at most `max_count`. Names are
/// compared without case, hyphens and spaces; a name is near if it is at most 2 edits
/// (io::EditDistance) away (1 for names of up to 3 characters), or if it contains the
/// requested name or is contained in it.
std::vector<std::string> NearNames(std::string_view asked,
                                   std::span<const std::string> names,
                                   std::size_t max_count = 3);

}  // namespace intaglio::materials_db
