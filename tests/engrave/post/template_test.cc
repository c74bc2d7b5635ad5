#include "engrave/post/template.h"

#include <gtest/gtest.h>

namespace intaglio::post {
namespace {

constexpr std::string_view kVariables[] = {"X", "NAME", "N"};
constexpr std::string_view kNeeded[] = {"X"};
constexpr FragmentRule kFragments[] = {{"head", false, kVariables},
                                       {"body", true, kVariables, kNeeded}};
constexpr SettingRule kSettings[] = {{"mark", 0.5, 2}};
constexpr TemplateRules kRules{kFragments, kSettings};

std::string ErrorOf(std::string_view text) {
  const auto parsed = ParseTemplate(text, "a.post", kRules);
  return parsed ? "no error" : parsed.error().message;
}

TEST(Template, WritesTextNumbersAndLineNumbers) {
  const auto parsed = ParseTemplate(
      "#- a comment\n"
      "#line-end crlf\n"
      "#number X scale=1000 decimals=0\n"
      "#mark 2\n"
      "#fragment head\n"
      "(@NAME@ at 5@@)\n"
      "##1=2\n"
      "#fragment body\r\n"
      "N@N@ X@X@ again @X@\n"
      "N@N@ M2",
      "a.post", kRules);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(parsed->settings.at("mark"), 2);
  Expander expander(*parsed, kRules);
  std::string text;
  const std::vector<Value> values = {-0.0004, std::string_view("vase"), std::uint64_t{0}};
  expander.Append(0, values, text);
  expander.Append(1, values, text);
  expander.Append(1, values, text);
  EXPECT_EQ(text,
            "(vase at 5@)\r\n#1=2\r\n"
            "N1 X0 again 0\r\nN2 M2\r\n"
            "N3 X0 again 0\r\nN4 M2\r\n");
}

TEST(Template, AParameterIsItsTextOrWhatIsGiven) {
  constexpr std::string_view kText =
      "#parameter BASE 31\n#parameter LEAVE X 300, Y 3\n#fragment body\n"
      "Base[@BASE@] @X@ { @LEAVE@ }\n";
  const auto written = [&](const Parameters& given) {
    const auto parsed = ParseTemplate(kText, "a.post", kRules, given);
    if (!parsed) return parsed.error().message;
    std::string text;
    Expander(*parsed, kRules)
        .Append(1, std::vector<Value>{1.0, std::string_view(), std::uint64_t{0}}, text);
    return text;
  };
  EXPECT_EQ(written({}), "Base[31] 1.000 { X 300, Y 3 }\n");
  EXPECT_EQ(written({{"BASE", "4"}, {"LEAVE", "Z 9"}}), "Base[4] 1.000 { Z 9 }\n");
  EXPECT_EQ(written({{"BASE", "four"}}),
            "a.post: line 1: parameter BASE is four, has to be a number as 31");
  EXPECT_EQ(written({{"LEAVE", "Z 9\nHALT"}}),
            "a.post: line 2: parameter LEAVE has to be a text of one line, 1 to 200 "
            "characters");
  const auto parsed = ParseTemplate(kText, "a.post", kRules);
  EXPECT_TRUE(RequireParameters({&*parsed, 1}, {{"BASE", "4"}}));
  EXPECT_EQ(RequireParameters({&*parsed, 1}, {{"TOOL", "4"}}).error().message,
            "parameter TOOL: no template of this program has it; they have BASE, LEAVE");
}

TEST(Template, NamesFileAndLineOfParametersThatCannotBe) {
  EXPECT_EQ(ErrorOf("#parameter BASE 1\n#fragment body\n@X@\n"),
            "a.post: line 1: #parameter: no fragment uses @BASE@; remove it");
  EXPECT_EQ(
      ErrorOf("#parameter X 1\n"),
      "a.post: line 1: #parameter X: has to be capital letters, digits and '_', and "
      "no variable");
  EXPECT_EQ(ErrorOf("#parameter BASE\n"),
            "a.post: line 1: #parameter needs a name and a text");
}

TEST(Template, KeepsEmptyLinesOfFragments) {
  const auto parsed = ParseTemplate("#fragment body\n\n@X@\n", "a.post", kRules);
  ASSERT_TRUE(parsed);
  std::string text;
  Expander(*parsed, kRules)
      .Append(1, std::vector<Value>{1.5, std::string_view(), std::uint64_t{0}}, text);
  EXPECT_EQ(text, "\n1.500\n");
}

TEST(Template, NamesFileAndLineOfEveryMistake) {
  EXPECT_EQ(ErrorOf("\n#fragment body\n@Y@\n"),
            "a.post: line 3: unknown variable @Y@; fragment 'body' has X, NAME, N");
  EXPECT_EQ(ErrorOf("#fragment body\nX@X\n"),
            "a.post: line 2: an '@' without its second one; write @@ for an '@' of the "
            "program");
  EXPECT_EQ(ErrorOf("#fragment tail\n"),
            "a.post: line 1: unknown fragment 'tail'; known: head, body");
  EXPECT_EQ(ErrorOf("#fragment head\n"),
            "a.post: line 1: the file ends without '#fragment body'");
  EXPECT_EQ(ErrorOf("#fragment body\n@NAME@\n"),
            "a.post: line 2: fragment 'body' does not use @X@, which would be lost");
  EXPECT_EQ(ErrorOf("#fragment body\n@X@\n#fragment body\n"),
            "a.post: line 3: fragment 'body' is given twice");
  EXPECT_EQ(
      ErrorOf("#speed 3\n"),
      "a.post: line 1: unknown setting #speed; known: fragment, extension, line-end, "
      "number, parameter, mark");
  EXPECT_EQ(ErrorOf("#mark 3\n"),
            "a.post: line 1: #mark is 3, has to be a number from 0.5 to 2");
  EXPECT_EQ(ErrorOf("#mark 1\n#mark 1\n"), "a.post: line 2: #mark is given twice");
  EXPECT_EQ(ErrorOf("#mark\n"), "a.post: line 1: #mark needs one value, got 0");
  EXPECT_EQ(ErrorOf("G21\n"),
            "a.post: line 1: text before the first #fragment; comments begin with #-");
  EXPECT_EQ(ErrorOf("#number Q decimals=3\n"),
            "a.post: line 1: #number: unknown variable 'Q'");
  EXPECT_EQ(ErrorOf("#number X decimals=3.5\n"),
            "a.post: line 1: #number: 'decimals=3.5'; allowed are scale=1e-6..1e9, "
            "decimals=0..9 and trim=0..1");
  EXPECT_EQ(ErrorOf("#number X\n#number X\n"),
            "a.post: line 2: #number: 'X' is given twice");
  EXPECT_EQ(ErrorOf("\n#number N decimals=0\n#fragment body\n@X@\n"),
            "a.post: line 2: #number: no fragment uses @N@; remove the variable here, or "
            "use it");
  EXPECT_EQ(ErrorOf("#line-end cr\n"),
            "a.post: line 1: #line-end is lf or crlf, not 'cr'");
  EXPECT_EQ(ErrorOf("#\n"),
            "a.post: line 1: a lone '#'; write ## for a '#' of the program");
}

TEST(Template, RefusesAFileThatIsTooLarge) {
  EXPECT_EQ(ErrorOf(std::string((1 << 20) + 1, '\n')),
            "a.post: 1048577 bytes; a template has at most 1048576");
}

TEST(AppendNumber, HasNoExponentAndNoMinusBeforeZero) {
  const auto text = [](double value, NumberFormat format) {
    std::string out;
    AppendNumber(value, format, out);
    return out;
  };
  EXPECT_EQ(text(-1e-9, {}), "0.000");
  EXPECT_EQ(text(-0.0005, {1, 3}), "-0.001");
  EXPECT_EQ(text(-0.2, {1, 3, true}), "-0.2");
  EXPECT_EQ(text(500, {1, 3, true}), "500");
  EXPECT_EQ(text(-0.0001, {1, 3, true}), "0");
  EXPECT_EQ(text(100, {1, 0, true}), "100");
  EXPECT_EQ(text(1e6, {40, 0}), "40000000");
  EXPECT_EQ(text(12.0000005, {1, 6}), "12.000001");
}

}  // namespace
}  // namespace intaglio::post
