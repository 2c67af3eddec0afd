// Charts, page and JSON of the study, from values made up here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>
#include <sstream>

#include "api/study/chart_axis.h"
#include "api/study/markup.h"
#include "api/study/study_json.h"
#include "api/study/study_page.h"

namespace morphograph {
namespace {

using boost::property_tree::ptree;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Throws where the text is no well-formed XML.
ptree Parsed(const std::string& svg) {
  std::istringstream in(svg);
  ptree tree;
  boost::property_tree::read_xml(in, tree);
  return tree;
}

void CollectTexts(const ptree& tree, std::vector<std::string>* texts) {
  for (const auto& [name, child] : tree) {
    if (name == "text") texts->push_back(child.data());
    CollectTexts(child, texts);
  }
}

std::vector<std::string> TextsOf(const std::string& svg) {
  std::vector<std::string> texts;
  CollectTexts(Parsed(svg), &texts);
  return texts;
}

// Attribute `d` of the paths whose class begins with `kind`.
std::vector<std::string> PathsOf(const std::string& svg, const std::string& kind) {
  // std::regex recurses once a character: long paths overflow the stack of a build with sanitizers.
  std::vector<std::string> paths;
  const std::string begin = "<path class=\"" + kind, data = "\" d=\"";
  for (std::size_t at = svg.find(begin); at != std::string::npos; at = svg.find(begin, at + 1)) {
    const std::size_t quote = svg.find('"', at + begin.size());
    if (quote == std::string::npos || svg.compare(quote, data.size(), data) != 0) continue;
    const std::size_t from = quote + data.size();
    paths.push_back(svg.substr(from, svg.find('"', from) - from));
  }
  return paths;
}

std::vector<std::pair<double, double>> PointsOf(const std::string& path) {
  std::vector<std::pair<double, double>> points;
  for (std::size_t at = path.find_first_of("ML"); at != std::string::npos; at = path.find_first_of("ML", at + 1)) {
    double x = 0, y = 0;
    if (std::sscanf(path.c_str() + at + 1, "%lf,%lf", &x, &y) == 2) points.emplace_back(x, y);
  }
  return points;
}

Chart LineChart(std::vector<double> x, std::vector<double> y) {
  Chart chart;
  chart.title = "Error";
  chart.x_label = "components";
  chart.y_label = "error, m²";
  chart.series.push_back({"weighted", std::move(x), std::move(y)});
  return chart;
}

double Leading(double value) { return value / std::pow(10, std::floor(std::log10(value) + 1e-9)); }

TEST(ChartAxis, TicksAreRoundDistinctAndInside) {
  std::mt19937_64 rng(3);
  boost::random::uniform_real_distribution<double> power(-8, 8), place(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10, power(rng)), from = place(rng) * size;
    const ChartAxis axis{from, from + std::pow(10, power(rng) / 8) * size};
    const std::vector<ChartTick> ticks = TicksOf(axis, 6);
    ASSERT_GE(ticks.size(), 2u) << axis.from << " " << axis.to;
    ASSERT_LE(ticks.size(), 9u) << axis.from << " " << axis.to;
    std::set<std::string> texts;
    for (size_t t = 0; t < ticks.size(); ++t) {
      EXPECT_GE(axis.Place(ticks[t].value), -1e-5);
      EXPECT_LE(axis.Place(ticks[t].value), 1 + 1e-5);
      texts.insert(ticks[t].text);
    }
    EXPECT_EQ(texts.size(), ticks.size()) << axis.from << " " << axis.to << " " << ticks.front().text;
    const double lead = Leading(ticks[1].value - ticks[0].value);
    EXPECT_TRUE(std::abs(lead - 1) < 1e-6 || std::abs(lead - 2) < 1e-6 || std::abs(lead - 5) < 1e-6) << lead;
  }
}

TEST(ChartAxis, LogTicksAreDecades) {
  std::vector<std::string> texts;
  for (const ChartTick& tick : TicksOf({0.005, 2000, true}, 6)) texts.push_back(tick.text);
  EXPECT_THAT(texts, ::testing::ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  EXPECT_GE(TicksOf({2, 7, true}, 5).size(), 2u);
  EXPECT_GE(TicksOf({1e-12, 1e12, true}, 6).size(), 3u);
  EXPECT_LE(TicksOf({1e-12, 1e12, true}, 6).size(), 8u);
}

TEST(ChartAxis, RangeHoldsWhatCanBeDrawn) {
  const ChartAxis some = AxisOver({3, kNaN, 5, kInfinity}, {});
  EXPECT_EQ(some.from, 3);
  EXPECT_EQ(some.to, 5);
  EXPECT_EQ(AxisOver({3, 5}, {.from_zero = true, .margin_below = 0.1}).from, 0);
  EXPECT_EQ(AxisOver({-3, -5}, {.from_zero = true, .margin_above = 0.1}).to, 0);
  const ChartAxis single = AxisOver({7}, {});
  EXPECT_LT(single.from, 7);
  EXPECT_GT(single.to, 7);
  const ChartAxis positive = AxisOver({0, -1, 0.01, 100}, {.log = true});
  EXPECT_NEAR(positive.from, 0.01, 1e-9);
  EXPECT_NEAR(positive.to, 100, 1e-6);
  for (const bool log : {false, true}) {
    const ChartAxis empty = AxisOver({kNaN}, {.log = log});
    EXPECT_LT(empty.from, empty.to);
  }
}

TEST(ShortNumber, IsForPeople) {
  EXPECT_EQ(ShortNumber(0.44), "0.44");
  EXPECT_EQ(ShortNumber(1.0), "1");
  EXPECT_EQ(ShortNumber(123456), "123456");
  EXPECT_EQ(ShortNumber(0.0123456), "0.0123");
  EXPECT_EQ(ShortNumber(-2.5e-9), "-2.5e-9");
  EXPECT_EQ(ShortNumber(1e-9), "1e-9");
  EXPECT_EQ(ShortNumber(-0.0), "0");
  EXPECT_EQ(ShortNumber(kNaN), "–");
}

TEST(Chart, IsWellFormedWhateverItHolds) {
  std::vector<Chart> charts(1);  // the first is empty
  charts.push_back(LineChart({}, {}));
  charts.push_back(LineChart({1}, {2}));
  charts.push_back(LineChart({1, 1, 1}, {0, 0, 0}));
  charts.push_back(LineChart({kNaN, 2}, {1, kInfinity}));
  charts.push_back(LineChart({1, 2, 3}, {1e300, -1e300, 0}));
  charts.push_back(LineChart({1, 2, 3}, {1, 2}));  // one y too few
  for (const auto form : {ChartSeries::Form::kPoints, ChartSeries::Form::kBars, ChartSeries::Form::kBand}) {
    charts.push_back(LineChart({1, 2, kNaN, 4}, {1, kNaN, 3, -4}));
    charts.back().series[0].form = form;
    charts.back().series[0].y_low = {0, 1};
    charts.back().marks = {{"published", 2}, {"chosen", 3, true}, {"nowhere", kNaN}};
  }
  const size_t linear = charts.size();
  for (size_t i = 0; i < linear; ++i) {
    charts.push_back(charts[i]);
    charts.back().log_x = charts.back().log_y = true;
    charts.push_back(charts[i]);
    charts.back().x_names = {"clean", "noisy"};
    charts.back().better = "lower";
  }
  for (const Chart& chart : charts) {
    const std::string svg = ChartSvg(chart);
    EXPECT_NO_THROW(Parsed(svg)) << svg;
    EXPECT_THAT(svg, Not(::testing::ContainsRegex("[^a-z](nan|inf)[^a-z]"))) << svg;
  }
  EXPECT_THAT(ChartSvg(charts[0]), HasSubstr("no data"));
}

TEST(Chart, TextStaysText) {
  const std::string nasty = "<script>alert(\"a & b\")</script> 'x' m²";
  Chart chart = LineChart({0, 1}, {0, 1});
  chart.title = chart.caption = chart.y_label = nasty;
  chart.series[0].name = nasty;
  chart.marks = {{nasty, 0.5}};
  const std::string svg = ChartSvg(chart);
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(TextsOf(svg), ::testing::Contains(nasty));
  EXPECT_EQ(Parsed(svg).get<std::string>("svg.title"), nasty);
  chart.title = std::string("bell \x07 and \xff");
  EXPECT_EQ(Parsed(ChartSvg(chart)).get<std::string>("svg.title"), "bell   and ÿ");
}

TEST(Chart, SaysWhatIsBetterAndNamesMarksAndSeries) {
  Chart chart = LineChart({0, 1}, {0, 1});
  chart.better = "lower";
  chart.marks = {{"Du Fig. 4.12", 0.5}};
  EXPECT_THAT(TextsOf(ChartSvg(chart)), ::testing::IsSupersetOf({"↓ lower is better", "Du Fig. 4.12", "weighted", "components", "error, m²"}));
}

TEST(Chart, NamesThatDoNotFitSideBySideAreSlanted) {
  Chart chart = LineChart({0, 1, 2}, {1, 2, 3});
  chart.series[0].form = ChartSeries::Form::kBars;
  chart.x_names = {"one", "two", "three"};
  EXPECT_THAT(ChartSvg(chart), Not(HasSubstr("rotate")));
  chart.x_names = {"the first kind of weights that was tried", "two", "three"};
  const std::string slanted = ChartSvg(chart);
  EXPECT_THAT(slanted, HasSubstr("rotate"));
  // There is room for them: the drawing is higher than with short names.
  const auto height = [](const std::string& svg) { return std::stod(svg.substr(svg.find("viewBox=\"0 0 520 ") + 17)); };
  chart.x_names = {"one", "two", "three"};
  EXPECT_GT(height(slanted), height(ChartSvg(chart)) + 80);
}

TEST(Chart, CurvesBreakWhereValuesAreMissing) {
  EXPECT_EQ(std::ranges::count(PathsOf(ChartSvg(LineChart({0, 1, 2, 3, 4}, {1, 2, 3, 2, 1})), "l ").back(), 'M'), 1);
  EXPECT_EQ(std::ranges::count(PathsOf(ChartSvg(LineChart({0, 1, 2, 3, 4}, {1, 2, kNaN, 2, 1})), "l ").back(), 'M'), 2);
  Chart log = LineChart({0, 1, 2, 3, 4}, {1, 2, 0, 2, 1});
  log.log_y = true;
  EXPECT_EQ(std::ranges::count(PathsOf(ChartSvg(log), "l ").back(), 'M'), 2);
}

TEST(Chart, HigherValuesAreDrawnHigher) {
  const auto points = PointsOf(PathsOf(ChartSvg(LineChart({0, 1, 2}, {1, 3, 2})), "l ").back());
  ASSERT_EQ(points.size(), 3u);
  EXPECT_LT(points[1].second, points[2].second);  // y runs downwards in SVG
  EXPECT_LT(points[2].second, points[0].second);
  EXPECT_NEAR(points[1].first - points[0].first, points[2].first - points[1].first, 0.11);
}

TEST(Chart, LongCurvesKeepTheirPeaksAndStaySmall) {
  std::vector<double> x, y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(i == 54321 ? 10 : std::sin(0.3 * i));
  }
  const std::string svg = ChartSvg(LineChart(x, y));
  EXPECT_LT(svg.size(), 60000u);
  double highest = 1e9, middle = 0;
  for (const auto& [px, py] : PointsOf(PathsOf(svg, "l ").back())) highest = std::min(highest, py), middle = std::max(middle, py);
  EXPECT_LT(highest, middle - 150);  // the spike, of a plot 230 high
}

TEST(Chart, CoordinatesHaveFewDecimals) {
  Chart chart = LineChart({0, 1.0 / 3, 2.0 / 3, 1}, {0.1234567, 1e-7, 0.7654321, 0.5});
  for (const auto form : {ChartSeries::Form::kBars, ChartSeries::Form::kBand, ChartSeries::Form::kPoints}) {
    chart.series.push_back(chart.series[0]);
    chart.series.back().form = form;
    chart.series.back().y_low = {0, 0, 0, 0};
  }
  for (const std::string& path : PathsOf(ChartSvg(chart), "")) EXPECT_THAT(path, Not(::testing::ContainsRegex("\\.[0-9][0-9][0-9]"))) << path;
}

TEST(Chart, EqualNamesShareAColourAndOneEntryOfTheKey) {
  Chart chart = LineChart({0, 1}, {0, 1});
  chart.series.push_back({"weighted", {0, 1}, {1, 0}});
  chart.series.push_back({"plain", {0, 1}, {1, 1}});
  const std::string svg = ChartSvg(chart);
  EXPECT_EQ(std::ranges::count(TextsOf(svg), "weighted"), 1);
  EXPECT_EQ(PathsOf(svg, "l k0").size(), 3u);  // two curves and their entry
  EXPECT_EQ(PathsOf(svg, "l k1").size(), 2u);
}

TEST(HeatMap, NeighboursOfOneValueShareARectangle) {
  HeatMap map;
  map.title = "Distance <matrix>";
  map.values = Eigen::MatrixXd::Zero(4, 5);
  map.values(1, 2) = 1;
  map.values(3, 0) = kNaN;
  const std::string svg = HeatMapSvg(map);
  EXPECT_EQ(Parsed(svg).get<std::string>("svg.title"), "Distance <matrix>");
  // Rows 0 and 2 in one piece each, row 1 around the one, row 3 without its first cell; the first 'h' of the paths of the colour scale follow.
  const std::string cells = svg.substr(svg.find("<g class=\"cells\">"), svg.find("</g>") - svg.find("<g class=\"cells\">"));
  EXPECT_EQ(std::ranges::count(cells, 'M'), 6);
}

TEST(HeatMap, IsWellFormedAndSmallWhateverItHolds) {
  HeatMap map;
  EXPECT_THAT(HeatMapSvg(map), HasSubstr("no data"));
  map.values = Eigen::MatrixXd::Constant(3, 3, kNaN);
  EXPECT_NO_THROW(Parsed(HeatMapSvg(map)));
  map.values = Eigen::MatrixXd::Constant(1, 1, 5);
  map.x_to = map.x_from;  // no range at all
  map.equal_scales = true;
  EXPECT_NO_THROW(Parsed(HeatMapSvg(map)));
  std::mt19937_64 rng(1);
  boost::random::uniform_real_distribution<double> any(0, 1);
  map.values.resize(700, 500);
  for (double& value : map.values.reshaped()) value = any(rng);
  map.over = {{"path", {0, 1}, {0, 1}}};
  const std::string svg = HeatMapSvg(map);
  EXPECT_NO_THROW(Parsed(svg));
  EXPECT_LT(svg.size(), 600000u);  // white noise, the worst there is
}

StudyReport SmallReport() {
  StudyReport report;
  report.data = {"walks <of> a & b"};
  report.clips_read = 20;
  report.styles = {{"brisk", 4, 1200, 40}, {"slow", 3, 12345, 411.5}};
  report.notes = {"clip <1> left out"};
  report.times_s = {{"reading", 0.5}, {"alignment", 2}};
  StudySection section;
  section.id = "alignment";
  section.title = "Alignment & path";
  section.text = "First <b>paragraph</b>.\n\nSecond.";
  section.drawings = {LineChart({0, 1}, {0, 1}), HeatMap{.title = "map", .x_label = "", .y_label = "", .value_label = "", .caption = "",
                                                         .values = Eigen::MatrixXd::Identity(3, 3), .over = {}}};
  section.figures = {{"ratio", 0.3, "", 0.44, "Du Table 4.3", {}, 0.44, "other data"},
                     {"too large", 0.9, "", 0.44, "", {}, 0.5, ""},
                     {"nothing told", std::nullopt, "s", {}, "", 0.9, {}, "no labels"},
                     {"no aim", 12.5, "s"}};
  section.data = {{"curve", {1.0, kNaN, kInfinity}}};
  report.sections = {section, {"mixture", "Mixture", "Left out.", {}, {}, nullptr}};
  return report;
}

TEST(StudyPage, NeedsNothingElseAndKeepsTextText) {
  const std::string page = StudyPage(SmallReport());
  EXPECT_THAT(page, HasSubstr("First &lt;b&gt;paragraph&lt;/b&gt;."));
  EXPECT_THAT(page, HasSubstr("walks &lt;of&gt; a &amp; b"));
  EXPECT_THAT(page, HasSubstr("clip &lt;1&gt; left out"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("src=")));
  EXPECT_THAT(page, Not(HasSubstr("@import")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
  // Addresses are of places on the page; the only other one names SVG and is never fetched.
  EXPECT_THAT(std::regex_replace(page, std::regex("http://www.w3.org/2000/svg"), ""), Not(HasSubstr("http")));
  EXPECT_THAT(page, Not(::testing::ContainsRegex("href=\"[^#]")));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme: dark"));
}

TEST(StudyPage, TableComesBeforeTheSectionsAndTellsWhatHolds) {
  const StudyReport report = SmallReport();
  const std::string page = StudyPage(report);
  EXPECT_LT(page.find("id=\"table\""), page.find("id=\"alignment\""));
  EXPECT_LT(page.find("id=\"alignment\""), page.find("id=\"mixture\""));
  const auto row = [&](const std::string& what) {
    const size_t from = page.find("<tr><th scope=\"row\">" + what);
    return page.substr(from, page.find("</tr>", from) - from);
  };
  EXPECT_THAT(row("ratio"), ::testing::AllOf(HasSubstr("0.3"), HasSubstr("0.44"), HasSubstr("Du Table 4.3"), HasSubstr("✓"), HasSubstr("other data")));
  EXPECT_THAT(row("too large"), HasSubstr("✗"));
  EXPECT_THAT(row("nothing told"), ::testing::AllOf(HasSubstr("not measured"), HasSubstr("≥ 0.9"), HasSubstr("no labels")));
  EXPECT_THAT(row("no aim"), ::testing::AllOf(HasSubstr("12.5 s"), Not(HasSubstr("✓")), Not(HasSubstr("✗"))));
  EXPECT_THAT(page, HasSubstr("1 of 3 aims hold; 1 could not be measured"));
  EXPECT_THAT(page, HasSubstr("7 clips of the 20 read"));
  EXPECT_THAT(page, Not(HasSubstr("quick run")));
  StudyReport quick = report;
  quick.quick = true;
  EXPECT_THAT(StudyPage(quick), HasSubstr("quick run"));
}

TEST(StudyJson, HoldsTheSameWithFiniteNumbersAndTimesApart) {
  StudyReport report = SmallReport();
  const json study = json::parse(StudyJson(report));
  EXPECT_EQ(study["sections"]["alignment"]["data"]["curve"], (json{1.0, nullptr, nullptr}));
  ASSERT_EQ(study["table"].size(), 4u);
  EXPECT_EQ(study["table"][0]["section"], "alignment");
  EXPECT_EQ(study["table"][0]["published"], 0.44);
  EXPECT_EQ(study["table"][0]["holds"], true);
  EXPECT_EQ(study["table"][1]["holds"], false);
  EXPECT_EQ(study["table"][2]["value"], nullptr);
  EXPECT_EQ(study["table"][3]["holds"], nullptr);
  EXPECT_EQ(study["data"]["clips"], 7);
  EXPECT_EQ(study["data"]["frames"], 13545);
  EXPECT_EQ(study["times"]["seconds"]["all"], 2.5);
  // Another machine, other times: nothing else differs.
  report.jobs = 7;
  report.times_s[0].second = 99;
  json later = json::parse(StudyJson(report));
  EXPECT_NE(later, study);
  later["times"] = study["times"];
  EXPECT_EQ(later, study);
}

}  // namespace
}  // namespace morphograph
