#pragma once

// Program templates: what a controller's program consists of, as text with variables, so
// that a new controller needs a file and no code. Variables and fragments after Siwiec
// 2016, ch. 4 (drilling and milling templates), with the line number @N@ added.
//
//   #- a comment
//   #extension ncp
//   #line-end crlf                       lf (default) or crlf
//   #number X Y Z scale=1000 decimals=0  how these variables are written; trim=1 leaves
//                                        zeros out that end the decimals
//   #parameter BASE 31                   text for @BASE@, which a person may replace
//   #fragment begin
//   IMF_PBL_V1.0
//   #fragment point
//   N@N@ FASTABS X@X@ Y@Y@ Z@Z@
//
// A line that begins with '#' is a setting; "##" at its beginning is a '#' of the
// program,
// "@@" anywhere an '@'. Lines behind `#fragment NAME` belong to that fragment.

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::post {

/// How a number is written: value * scale, rounded to `decimals`.
struct NumberFormat {
  double scale = 1;   ///< 1e-6..1e9
  int decimals = 3;   ///< 0..9
  bool trim = false;  ///< without zeros at the end of the decimals

  bool operator==(const NumberFormat&) const = default;
};

/// A piece of a fragment: text as it is, then a variable; the last has none (-1).
struct Piece {
  std::string text;
  int variable = -1;  ///< place in FragmentRule::variables
};

struct Fragment {
  std::vector<Piece> pieces;  ///< empty: the template does not have it
};

/// A fragment that a kind of program knows.
struct FragmentRule {
  std::string_view name;
  bool required = false;
  /// The variables that it may use. "N" is the number of the line, counted by Expander.
  std::span<const std::string_view> variables;
  /// Those that it has to use: a template without them would lose what they hold.
  std::span<const std::string_view> needed = {};
};

/// A setting with one number that a kind of program knows.
struct SettingRule {
  std::string_view name;
  double min = 0;
  double max = 0;
};

/// What the templates of one kind of program (points, holes, contours) may contain.
struct TemplateRules {
  std::span<const FragmentRule> fragments;
  std::span<const SettingRule> settings;
};

struct Template {
  std::string file;       ///< for messages
  std::string extension;  ///< without the dot, "" when not given
  std::string line_end = "\n";
  std::vector<Fragment> fragments;  ///< in the order of the rules
  std::map<std::string, NumberFormat, std::less<>> numbers;  ///< by variable
  std::map<std::string, double, std::less<>> settings;       ///< those that are given
  std::vector<std::string> parameters;  ///< names, in the order of the file

  NumberFormat FormatOf(std::string_view variable) const;
  /// Of a setting that is not given: `otherwise`.
  double SettingOf(std::string_view name, double otherwise) const;
};

/// Whether fragment `fragment` uses the variable.
bool UsesVariable(const Template& program, const TemplateRules& rules,
                  std::size_t fragment, std::string_view variable);
/// Whether a fragment from this one on uses it.
bool AnyFragmentUses(const Template& program, const TemplateRules& rules,
                     std::string_view variable, std::size_t from = 0);

/// Texts of parameters by their name, in place of those in the template: of one line, 1
/// to 200 characters; a number where the template has one.
using Parameters = std::map<std::string, std::string, std::less<>>;

/// Every mistake is an error that names file and line: an unknown setting, fragment or
/// variable; one that is given twice; a fragment or a variable that is needed and absent;
/// a #number of a variable or a #parameter that no fragment uses; a number outside its
/// range; a text of `given` that is none; an '@' without its second one. `text` up to 1
/// MiB. What `given` has and the template has not is not used (RequireParameters).
Result<Template> ParseTemplate(std::string_view text, std::string_view file,
                               const TemplateRules& rules, const Parameters& given = {});

/// kInvalidValue, with those that there are: one of `given` that no template has.
Status RequireParameters(std::span<const Template> programs, const Parameters& given);

/// The value of a variable: a number that is written by its NumberFormat, a count, or
/// text without line breaks.
using Value = std::variant<double, std::uint64_t, std::string_view>;

/// Writes fragments one after the other and counts the lines that have a number.
class Expander {
 public:
  /// Both outlive it.
  Expander(const Template& program, const TemplateRules& rules)
      : program_(program), rules_(rules) {}

  /// Appends the fragment with these values, one for each variable of its rule, in its
  /// order; that of "N" is not used. Numbers have to be finite.
  void Append(std::size_t fragment, std::span<const Value> values, std::string& text);

 private:
  const Template& program_;
  const TemplateRules& rules_;
  std::uint64_t lines_ = 0;
};

/// Decimals without an exponent and without a minus before zero.
void AppendNumber(double value, const NumberFormat& format, std::string& text);

}  // namespace intaglio::post
