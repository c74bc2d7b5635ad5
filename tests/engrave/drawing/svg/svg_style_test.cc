#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <optional>

#include "engrave/drawing/svg/svg_read.h"
#include "tests/engrave/drawing/lengths.h"
#include "tests/sanitizers.h"

namespace intaglio::drawing {
namespace {

Drawing StyledDrawing(const std::string& content) {
  auto drawing = ReadSvg("<svg xmlns='http://www.w3.org/2000/svg'>" + content + "</svg>");
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  return drawing ? std::move(*drawing) : Drawing{};
}
std::string Styled(const std::string& css, const std::string& content) {
  return "<style>" + css + "</style>" + content;
}
/// The strokes of the lines that are drawn, in order.
std::string Strokes(const std::string& content) {
  const Drawing drawing = StyledDrawing(content);
  std::string strokes;
  for (const Curve& curve : drawing.curves) strokes += drawing.names[curve.color] + " ";
  return strokes;
}

// The examples of CSS 2.1, 6.4.3, and further cases under its rules: which of two rules
// wins must not depend on the order unless the specificities are the same.
TEST(SvgStyle, MoreSpecificRulesWinAndThenLaterOnes) {
  const std::string line = "<line id='i' class='a b' x2='1' stroke='attribute'/>";
  struct Case {
    std::string weak, strong;
  };
  const Case cases[] = {{"*", "line"},        {"line", ".a"},       {".a", "line.a"},
                        {".a", ".b.a"},       {".a.b", "#i"},       {"#i", "line#i"},
                        {"line.a.b", "#i"},   {"#i", "#i.a"},       {"line.a", ".a.b"},
                        {"rect, .a", "#i,g"}, {"*", "\n.a\t,rect"}, {"*.a", "line.a"}};
  for (const Case& c : cases) {
    const std::string weak = c.weak + "{stroke:weak}";
    const std::string strong = c.strong + "{stroke:strong}";
    EXPECT_EQ(Strokes(Styled(weak + strong, line)), "strong ") << weak << strong;
    EXPECT_EQ(Strokes(Styled(strong + weak, line)), "strong ") << strong << weak;
    EXPECT_EQ(Strokes(Styled(weak + c.weak + "{ stroke : later ; }", line)), "later ");
    EXPECT_EQ(Strokes(Styled(strong + c.weak + "{stroke:must!important}", line)),
              "must ");
  }
  EXPECT_EQ(Strokes(Styled("*{stroke:sheet}", line)), "sheet ");
  EXPECT_EQ(Strokes(Styled(".c,#j,rect,.A,LINE,.ab,line.c,#i.c{stroke:sheet}", line)),
            "attribute ");
}

TEST(SvgStyle, TheStyleAttributeWinsOverSheetsButNotOverImportantOnes) {
  const std::string line = "<line id='i' x2='1' style='stroke:1; stroke : own;fill:x'/>";
  EXPECT_EQ(Strokes(Styled("#i{stroke:sheet}", line)), "own ");
  EXPECT_EQ(Strokes(Styled("line{stroke:sheet ! IMPORTANT}", line)), "sheet ");
  EXPECT_EQ(Strokes("<line x2='1' style='stroke:a!important;stroke:b'/>"), "a ");
  EXPECT_EQ(Strokes("<line x2='1' style='/*stroke:a*/STROKE/**/:b'/>"), "b ");
}

TEST(SvgStyle, DisplayIsFinalVisibilityIsInherited) {
  const std::string lines =
      "<g class='h'><line class='s' x2='1' stroke='1'/><line x2='1' stroke='2'/></g>"
      "<g class='n'><line class='s' x2='1' stroke='3'/></g><line x2='1' stroke='4'/>";
  const std::string css =
      ".h{visibility:hidden}.s{visibility:visible;display:inline}.n{display:none}";
  EXPECT_EQ(Strokes(Styled(css, lines)), "1 4 ");
  // The second line and the group that is not displayed.
  EXPECT_EQ(StyledDrawing(Styled(css, lines)).findings.CountOf("invisible"), 2U);
  EXPECT_EQ(Strokes(Styled("svg{display:NONE}", lines)), "");
  EXPECT_EQ(Strokes(Styled("svg{visibility:collapse}", lines)), "");
  EXPECT_EQ(Strokes(Styled("svg{stroke:all}", "<line x2='1'/>")), "all ");
}

TEST(SvgStyle, StylesGoThroughReferences) {
  EXPECT_EQ(Strokes("<defs><line class='a' id='l' x2='1'/><symbol id='s' class='b'>"
                    "<line x2='1'/></symbol></defs>"
                    "<use class='b' href='#l'/><use href='#s'/><use class='c' "
                    "href='#s'/><style>.a{stroke:1}.b{stroke:2}.c{visibility:hidden}"
                    "</style>"),
            "1 2 ");
}

TEST(SvgStyle, CommentsStringsAtRulesAndOtherSelectors) {
  const std::string css =
      "<![CDATA[<!-- @charset 'x'; @media print { .a{stroke:1} .b{stroke:2} }\n"
      "/* .a{stroke:3} */ .b > .a, .a:hover, [x='}'], g .a{stroke:4}\n"
      ".a:hover{cursor:none} .a{content:\"}/*\";stroke:/**/5;&:hover{stroke:6}}\n"
      ".q{d:\"\\\"\"} .c{stroke:'7' -->]]>";
  const std::string lines =
      "<line class='a' x2='1'/><line class='b' x2='1'/><line class='c' x2='1'/>";
  EXPECT_EQ(Strokes(Styled(css, lines)), "5  '7' --> ");
  const auto findings = StyledDrawing(Styled(css, lines)).findings;
  EXPECT_EQ(findings.CountOf("@media"), 1U);
  EXPECT_EQ(findings.CountOf("@charset"), 1U);
  EXPECT_EQ(findings.CountOf("style rule not by class, id or element"), 4U);
  const Drawing other = StyledDrawing(
      "<style media='print'>*{stroke:1}</style><style type='text/x'>*{stroke:2}</style>"
      "<style media='screen' type='text/css'>*{stroke:3}</style><line x2='1'/>");
  EXPECT_EQ(other.names[other.curves.at(0).color], "3");
  EXPECT_EQ(other.findings.CountOf("style sheet of another kind"), 2U);
}

// What drawing programs write by default: classes of a sheet in defs.
TEST(SvgStyle, SheetsAndAttributesGiveTheSameDrawing) {
  const auto drawing = [](const std::string& head, const std::string& hidden,
                          const std::string& cut) {
    return StyledDrawing("<defs>" + head + "</defs><rect " + hidden +
                         " width='9' height='9'/><circle " + cut + " r='5'/>");
  };
  const Drawing by_sheet = drawing(
      "<style>.cls-1, .cls-2 { fill: none; } .cls-1 { display: none; } .cls-2 { stroke: "
      "#f00; stroke-width: .25px; }</style>",
      "class='cls-1'", "class='cls-2'");
  const Drawing by_attribute = drawing("", "display='none'", "stroke='#f00'");
  ASSERT_EQ(by_sheet.curves.size(), 1U);
  EXPECT_EQ(by_sheet.names, by_attribute.names);
  EXPECT_EQ(by_sheet.findings, by_attribute.findings);
  EXPECT_EQ(Flatten(by_sheet)->curves[0].points_mm,
            Flatten(by_attribute)->curves[0].points_mm);
}

std::string Repeated(const std::string& part, int count) {
  std::string whole;
  for (int i = 0; i < count; ++i) whole += part;
  return whole;
}

TEST(SvgStyle, SheetsWithoutEndAreRefusedOrReadSoon) {
  const auto code_of = [](const std::string& content) -> std::optional<ErrorCode> {
    // The processor's time counts: others may be busy, and the host may take some.
    // Without a bound on the work each of these takes minutes.
    const std::clock_t begin = std::clock();
    const auto drawing = ReadSvg("<svg>" + content + "</svg>");
    EXPECT_LT(std::clock() - begin, 10 * test::kSanitizersTake * CLOCKS_PER_SEC)
        << content.substr(0, 50);
    if (drawing) return std::nullopt;
    return drawing.error().code;
  };
  std::string rules;
  for (int i = 0; i < 5'000; ++i) rules += fmt::format(".a.b{}{{stroke:b}}", i);
  EXPECT_EQ(code_of(Styled(rules, Repeated("<line class='a'/>", 100'000))),
            ErrorCode::kTooLarge);
  EXPECT_EQ(code_of(Styled(Repeated("a,", 200'000) + "a{stroke:b}", "")),
            ErrorCode::kTooLarge);
  EXPECT_EQ(code_of("<g id='a' style='" + Repeated(";", 100'000) + "'><line/></g>" +
                    Repeated("<use href='#a'/>", 100'000)),
            ErrorCode::kTooLarge);
  // Without elements of their own, which no other limit counts.
  EXPECT_EQ(code_of("<g id='a'>" + Repeated("<g/>", 10'000) + "</g>" +
                    Repeated("<use href='#a'/>", 100'000)),
            ErrorCode::kTooLarge);
  EXPECT_EQ(code_of(Styled(Repeated("a{", 500'000), "<a/>")), std::nullopt);
  EXPECT_EQ(code_of(Styled("a{" + Repeated("([", 500'000), "<a/>")), std::nullopt);
  EXPECT_EQ(code_of(Styled("." + std::string(2'000'000, 'x') + "{stroke:a}", "")),
            std::nullopt);
  EXPECT_EQ(code_of(Styled("a{stroke:\"", "<a/>")), std::nullopt);
  EXPECT_EQ(code_of(Styled("a{stroke:\\", "<a/>")), std::nullopt);
  EXPECT_EQ(code_of(Styled("@", "") + Styled("/*", "") + Styled(",{stroke:a}", "")),
            std::nullopt);
}

}  // namespace
}  // namespace intaglio::drawing
