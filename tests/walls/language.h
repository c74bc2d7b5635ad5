#pragma once

// The language of names: identifiers use the field's words. docs/glossary.md has the
// retired ones with what replaced them.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::walls {

/// The retired word that is a part of this identifier (CamelCase or snake_case); empty:
/// there is none. `path` from the root: in engrave/mesh vertices are welded.
std::string RetiredPartOf(std::string_view identifier, std::string_view path);

/// Whether identifiers contain this character.
bool IsOfName(char c);

/// A source of the same size with blanks in place of comments and literals.
std::string WithoutText(std::string_view source);

/// The identifiers of a source, in order, without those of comments and literals.
std::vector<std::string> IdentifiersOf(std::string_view source);

/// One sentence for each identifier with a retired word and the first file that has it.
/// Reads every .h, .cc, .idl and .proto of the product and of its tests.
std::vector<std::string> RetiredNames(const std::filesystem::path& root);

/// One sentence for each line of a comment that begins with "Of": a comment is a sentence
/// with subject and verb. Reads every .h and .cc below folders that are not excepted in
/// language.cc.
std::vector<std::string> CommentsThatBeginWithOf(const std::filesystem::path& root);

}  // namespace intaglio::walls
