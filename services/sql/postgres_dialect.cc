// The dialect of connection.h in the words of PostgreSQL.

#include <array>
#include <cctype>
#include <cstdint>
#include <utility>

#include "services/sql/postgres_connection.h"

namespace intaglio::sql {
namespace {

/// `replace` of every word outside quotes; what is quoted stays.
template <typename Replace>
std::string WithNames(const std::string& sql, const Replace& replace) {
  std::string out;
  for (std::size_t i = 0; i < sql.size();) {
    const auto letter = static_cast<unsigned char>(sql[i]);
    if (sql[i] == '\'') {
      const auto end = sql.find('\'', i + 1);
      const std::size_t next = end == std::string::npos ? sql.size() : end + 1;
      out.append(sql, i, next - i);
      i = next;
    } else if (std::isalpha(letter) != 0) {
      std::size_t end = i;
      while (end < sql.size() &&
             (std::isalnum(static_cast<unsigned char>(sql[end])) != 0 || sql[end] == '_'))
        ++end;
      out += replace(sql.substr(i, end - i));
      i = end;
    } else {
      out += sql[i++];
    }
  }
  return out;
}

std::string TypeOf(const std::string& word) {
  constexpr std::array<std::pair<const char*, const char*>, 5> kTypes{
      {{"INTEGER", "BIGINT"},
       {"REAL", "DOUBLE PRECISION"},
       {"TEXT", "TEXT COLLATE \"C\""},
       {"BLOB", "BYTEA"},
       {"x", ""}}};
  for (const auto& [ours, theirs] : kTypes) {
    if (word == ours) return theirs;
  }
  return word;
}

std::string WithoutPragmas(const std::string& script) {
  std::string out;
  for (std::size_t begin = 0; begin < script.size();) {
    const auto end = script.find('\n', begin);
    const std::size_t next = end == std::string::npos ? script.size() : end + 1;
    if (script.compare(begin, 6, "PRAGMA") != 0) out.append(script, begin, next - begin);
    begin = next;
  }
  return out;
}

/// The bytes of the character that begins here; 0: it is none (RFC 3629, chapter 4).
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const auto follows = [&](std::size_t i, unsigned low = 0x80, unsigned high = 0xbf) {
    return byte(i) >= low && byte(i) <= high;
  };
  const unsigned first = byte(0);
  if (first == 0) return 0;
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return follows(1) ? 2 : 0;
  if (first >= 0xe0 && first <= 0xef) {
    const unsigned low = first == 0xe0 ? 0xa0 : 0x80, high = first == 0xed ? 0x9f : 0xbf;
    return follows(1, low, high) && follows(2) ? 3 : 0;
  }
  if (first >= 0xf0 && first <= 0xf4) {
    const unsigned low = first == 0xf0 ? 0x90 : 0x80, high = first == 0xf4 ? 0x8f : 0xbf;
    return follows(1, low, high) && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string PostgresStatement(const std::string& sql) {
  std::string out;
  bool quoted = false;
  int parameters = 0;
  for (std::size_t i = 0; i < sql.size(); ++i) {
    quoted ^= sql[i] == '\'';
    if (sql[i] != '?' || quoted) {
      out += sql[i];
      continue;
    }
    out += '$';
    const bool numbered =
        i + 1 < sql.size() && std::isdigit(static_cast<unsigned char>(sql[i + 1])) != 0;
    if (!numbered) out += std::to_string(++parameters);
  }
  return WithNames(out, [](const std::string& word) {
    return word == "instr" ? std::string("strpos") : word;
  });
}

std::string PostgresScript(const std::string& script) {
  return WithNames(WithoutPragmas(script), TypeOf);
}

std::string ValidUtf8(std::string_view text) {
  constexpr std::string_view kReplacement = "\xef\xbf\xbd";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = CharacterLength(text);
    out += length > 0 ? text.substr(0, length) : kReplacement;
    text.remove_prefix(length > 0 ? length : 1);
  }
  return out;
}

}  // namespace intaglio::sql
