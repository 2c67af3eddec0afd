#include "api/study/study_page.h"

#include <cmath>

#include "api/study/markup.h"

namespace morphograph {
namespace {

// Colours are named once, so that a dark page is the same page. System fonts only.
constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --page: #fcfcfb; --text: #1c1e21; --quiet: #5c626b; --line: #d9dce0; --panel: #f2f3f4; --link: #0b57a8;
  --good: #14663a; --good-back: #dcf1e3; --bad: #8f1d1d; --bad-back: #f9dfdc; }
@media (prefers-color-scheme: dark) {
  :root { --page: #16181b; --text: #e4e6e9; --quiet: #9aa1ab; --line: #363b42; --panel: #1f2327; --link: #7db7f5;
    --good: #8fdcad; --good-back: #173a26; --bad: #f5aaa1; --bad-back: #4a1f1c; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--text); font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif; }
main { max-width: 78rem; margin: 0 auto; padding: 1.5rem 1.25rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: .5rem 0 .25rem; }
h2 { font-size: 1.4rem; margin: 3rem 0 .5rem; padding-top: .75rem; border-top: 1px solid var(--line); }
p, li { max-width: 46rem; }
.lead, .quiet { color: var(--quiet); }
a { color: var(--link); }
nav ul { display: flex; flex-wrap: wrap; gap: .25rem 1.25rem; list-style: none; margin: 1rem 0; padding: 0; }
.scroll { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-size: .9rem; line-height: 1.4; }
th, td { text-align: left; vertical-align: top; padding: .4rem .75rem .4rem 0; border-bottom: 1px solid var(--line); }
thead th { color: var(--quiet); font-weight: 600; border-bottom: 2px solid var(--line); white-space: nowrap; }
tbody th { font-weight: 500; min-width: 15rem; }
tbody.part th { color: var(--quiet); font-weight: 600; padding-top: 1rem; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; padding-right: 1.25rem; }
td.value { font-weight: 650; }
td.source, td.aim { white-space: nowrap; }
td.note { color: var(--quiet); min-width: 14rem; max-width: 26rem; }
.holds, .fails { border-radius: .25rem; padding: .05rem .45rem; white-space: nowrap; }
.holds { color: var(--good); background: var(--good-back); }
.fails { color: var(--bad); background: var(--bad-back); }
.warning { background: var(--panel); border-left: 4px solid var(--quiet); padding: .6rem 1rem; max-width: 46rem; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.25rem; margin: 1rem 0; font-size: .95rem; }
dt { color: var(--quiet); }
dd { margin: 0; }
.drawings { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 27rem), 1fr)); gap: 2rem 2.5rem; margin: 1.5rem 0; }
figure { margin: 0; min-width: 0; max-width: 40rem; }
figure > div { overflow-x: auto; }
figure h3 { font-size: 1.05rem; line-height: 1.35; margin: 0 0 .5rem; }
figcaption { color: var(--quiet); font-size: .9rem; line-height: 1.45; margin-top: .5rem; }
@media (max-width: 40rem) { dl { grid-template-columns: 1fr; } dd { margin-bottom: .4rem; } }
@media print { nav { display: none; } figure { break-inside: avoid; } }
)css";

std::string Tag(const std::string& name, const std::string& text, const std::string& kind = "") {
  return "<" + name + (kind.empty() ? "" : " class=\"" + kind + "\"") + ">" + Escaped(text) + "</" + name + ">";
}

// Thousands apart, by thin spaces.
std::string Counted(std::int64_t count, const std::string& one, const std::string& many) {
  const std::string digits = std::to_string(count);
  std::string apart;
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) apart += " ";
    apart += digits[i];
  }
  return apart + " " + (count == 1 ? one : many);
}

std::string Joined(const std::vector<std::string>& parts, const std::string& between) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : between) + part;
  return text;
}

std::string Paragraphs(const std::string& text) {
  std::string html;
  for (size_t from = 0; from < text.size();) {
    size_t to = text.find("\n\n", from);
    if (to == std::string::npos) to = text.size();
    if (to > from) html += Tag("p", text.substr(from, to - from)) + "\n";
    from = to + 2;
  }
  return html;
}

std::string NoiseText(const NoiseOptions& noise) {
  constexpr double kDegrees = 180 / 3.14159265358979323846;
  return "jitter of " + ShortNumber(kDegrees * noise.leaf_jitter_rad, 2) + "° on feet, hands and head and the joints that move them (knees, elbows, neck), of " +
         ShortNumber(100 * noise.root_jitter_m, 2) + " cm and " + ShortNumber(kDegrees * noise.root_jitter_rad, 2) + "° on the root; " +
         ShortNumber(noise.slips_per_s) + " slips a second of each limb (" + ShortNumber(kDegrees * noise.slip_rad, 2) + "°, root " +
         ShortNumber(100 * noise.slip_m, 2) + " cm, " + ShortNumber(noise.slip_s) + " s); " + ShortNumber(noise.dropouts_per_s) +
         " dropouts (" + ShortNumber(noise.dropout_s) + " s), as of cameras of " + ShortNumber(noise.camera_hz) + " Hz";
}

std::string WhatWasRun(const StudyReport& report) {
  int clips = 0;
  std::int64_t frames = 0;
  double duration_s = 0, all_s = 0;
  std::vector<std::string> styles, times;
  for (const StudiedStyle& style : report.styles) {
    clips += style.clips;
    frames += style.frames;
    duration_s += style.duration_s;
    if (!style.name.empty()) styles.push_back(style.name + " (" + std::to_string(style.clips) + ")");
  }
  for (const auto& [part, seconds] : report.times_s) {
    all_s += seconds;
    times.push_back(part + " " + ShortNumber(seconds, 2) + " s");
  }
  std::string html = "<dl>\n";
  const auto fact = [&](const std::string& name, const std::string& value) {
    html += Tag("dt", name) + Tag("dd", value) + "\n";
  };
  fact("data", Joined(report.data, ", "));
  fact("clips", Counted(clips, "clip", "clips") + (clips < report.clips_read ? " of the " + std::to_string(report.clips_read) + " read" : "") +
                    ", " + Counted(frames, "frame", "frames") + ", " + ShortNumber(duration_s / 60, 2) + " minutes");
  if (!styles.empty()) fact("styles (clips)", Joined(styles, ", "));
  fact("labelled key frames", report.labelled_clips > 0 ? Counted(report.labelled_clips, "clip has", "clips have") + " labels" : "none");
  fact("noisy copies", NoiseText(report.noise));
  fact("seed", std::to_string(report.seed));
  fact("version", "Morphograph " MORPHOGRAPH_VERSION);
  fact("time", ShortNumber(all_s, 2) + " s on " + Counted(report.jobs, "thread", "threads") + " (" + Joined(times, ", ") + ")");
  return html + "</dl>\n";
}

std::string Drawings(const StudySection& section) {
  if (section.drawings.empty()) return "";
  std::string html = "<div class=\"drawings\">\n";
  for (const std::variant<Chart, HeatMap>& drawing : section.drawings) {
    const auto figure = [&](const auto& drawn, const std::string& svg) {
      html += "<figure>" + Tag("h3", drawn.title) + "<div>" + svg + "</div>" + Tag("figcaption", drawn.caption) + "</figure>\n";
    };
    if (const Chart* chart = std::get_if<Chart>(&drawing)) {
      figure(*chart, ChartSvg(*chart));
    } else {
      figure(std::get<HeatMap>(drawing), HeatMapSvg(std::get<HeatMap>(drawing)));
    }
  }
  return html + "</div>\n";
}

std::string AimText(const StudyFigure& figure) {
  if (figure.at_least && figure.at_most) return ShortNumber(*figure.at_least) + " to " + ShortNumber(*figure.at_most);
  if (figure.at_least) return "≥ " + ShortNumber(*figure.at_least);
  return figure.at_most ? "≤ " + ShortNumber(*figure.at_most) : "";
}

std::string FigureRow(const StudyFigure& figure) {
  const auto number = [&](const std::optional<double>& value) {
    return value ? ShortNumber(*value) + (figure.unit.empty() ? "" : " " + figure.unit) : std::string();
  };
  std::string row = "<tr><th scope=\"row\">" + Escaped(figure.what) + "</th>";
  row += Tag("td", figure.value ? number(figure.value) : "–", "number value");
  row += Tag("td", number(figure.published), "number") + Tag("td", figure.source, "source") + Tag("td", AimText(figure), "number") + "<td class=\"aim\">";
  if (figure.at_least || figure.at_most) {
    row += !figure.value ? "not measured" : figure.Holds() ? "<span class=\"holds\">✓ holds</span>" : "<span class=\"fails\">✗ misses</span>";
  }
  return row + "</td>" + Tag("td", figure.note, "note") + "</tr>\n";
}

// "12 of 19 aims hold; 2 could not be measured."
std::string AimsText(const StudyReport& report) {
  int aims = 0, hold = 0, absent = 0;
  for (const StudySection& section : report.sections) {
    for (const StudyFigure& figure : section.figures) {
      if (!figure.at_least && !figure.at_most) continue;
      ++aims;
      hold += figure.Holds();
      absent += !figure.value;
    }
  }
  if (aims == 0) return "";
  return std::to_string(hold) + " of " + std::to_string(aims) + " aims hold" +
         (absent > 0 ? "; " + std::to_string(absent) + " could not be measured on these data." : ".");
}

std::string FigureTable(const StudyReport& report) {
  std::string html =
      "<div class=\"scroll\"><table>\n<thead><tr><th>what</th><th>this study</th><th>published</th><th>source</th><th>aim</th><th>holds</th>"
      "<th>note</th></tr></thead>\n";
  for (const StudySection& section : report.sections) {
    if (section.figures.empty()) continue;
    html += "<tbody class=\"part\"><tr><th colspan=\"7\" scope=\"rowgroup\"><a href=\"#" + Escaped(section.id) + "\">" +
            Escaped(section.title) + "</a></th></tr></tbody>\n<tbody>";
    for (const StudyFigure& figure : section.figures) html += FigureRow(figure);
    html += "</tbody>\n";
  }
  return html + "</table></div>\n";
}

}  // namespace

std::string StudyPage(const StudyReport& report) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n" + Tag("title", "Morphograph study: " + Joined(report.data, ", ")) + "\n<style>" + kStyle + DrawingCss() + "</style>\n</head>\n<body>\n<main>\n";
  html += "<h1>The study</h1>\n<p class=\"lead\">How the motion that a model makes compares with the motion that it was learned from, "
          "measured as in the published evaluation (Du, 2014, chapter 4) and beyond it.</p>\n";
  if (report.quick) {
    html += "<p class=\"warning\">A quick run, on few clips and with few repetitions. It shows that every part works; its figures mean "
            "little.</p>\n";
  }
  html += WhatWasRun(report) + "<nav><ul>";
  for (const StudySection& section : report.sections)
    html += "<li><a href=\"#" + Escaped(section.id) + "\">" + Escaped(section.title) + "</a></li>";
  html += "</ul></nav>\n<h2 id=\"table\">Beside the published figures</h2>\n<p>Published figures were measured on other recordings, so that "
          "ratios compare and absolute values hardly do. An aim is what this project asks of itself. " + AimsText(report) + "</p>\n" + FigureTable(report);
  if (!report.notes.empty()) {
    html += "<details><summary>Notes on the data (" + std::to_string(report.notes.size()) + ")</summary>\n<ul>";
    for (const std::string& note : report.notes) html += Tag("li", note);
    html += "</ul></details>\n";
  }
  for (const StudySection& section : report.sections) {
    html += "<section id=\"" + Escaped(section.id) + "\">\n" + Tag("h2", section.title) + "\n" + Paragraphs(section.text) + Drawings(section) + "</section>\n";
  }
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace morphograph
