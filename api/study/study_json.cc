#include "api/study/study_json.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;

Json FigureJson(const StudyFigure& figure) {
  return {{"what", figure.what},
          {"value", OrNull(figure.value)},
          {"unit", figure.unit},
          {"published", OrNull(figure.published)},
          {"source", figure.source},
          {"at_least", OrNull(figure.at_least)},
          {"at_most", OrNull(figure.at_most)},
          {"holds", figure.at_least || figure.at_most ? Json(figure.Holds()) : Json(nullptr)},
          {"note", figure.note}};
}

Json NoiseJson(const NoiseOptions& noise) {
  return {{"leaf_jitter_rad", noise.leaf_jitter_rad}, {"root_jitter_m", noise.root_jitter_m}, {"root_jitter_rad", noise.root_jitter_rad},
          {"slips_per_s", noise.slips_per_s},         {"slip_rad", noise.slip_rad},           {"slip_m", noise.slip_m},
          {"slip_s", noise.slip_s},                   {"dropouts_per_s", noise.dropouts_per_s}, {"dropout_s", noise.dropout_s},
          {"camera_hz", noise.camera_hz}};
}

}  // namespace

std::string StudyJson(const StudyReport& report) {
  Json styles = Json::array(), table = Json::array(), sections = Json::object();
  std::int64_t frames = 0;
  int clips = 0;
  for (const StudiedStyle& style : report.styles) {
    styles.push_back({{"name", style.name}, {"clips", style.clips}, {"frames", style.frames}, {"seconds", style.duration_s}});
    frames += style.frames;
    clips += style.clips;
  }
  Json clocked = Json::array();
  for (const StudySection& section : report.sections) {
    Json figures = Json::array();
    for (const StudyFigure& figure : section.figures) {
      if (figure.is_time) {
        clocked.push_back(FigureJson(figure));
        clocked.back()["section"] = section.id;
        continue;
      }
      figures.push_back(FigureJson(figure));
      table.push_back(figures.back());
      table.back()["section"] = section.id;
    }
    sections[section.id] = {{"title", section.title}, {"figures", std::move(figures)}, {"data", section.data}};
  }
  Json times = {{"jobs", report.jobs}, {"seconds", Json::object()}};
  double all_s = 0;
  for (const auto& [part, seconds] : report.times_s) {
    times["seconds"][part] = seconds;
    all_s += seconds;
  }
  times["seconds"]["all"] = all_s;
  times["figures"] = std::move(clocked);
  const Json json = {{"version", MORPHOGRAPH_VERSION},
                     {"quick", report.quick},
                     {"seed", report.seed},
                     {"noise", NoiseJson(report.noise)},
                     {"data",
                      {{"paths", report.data},
                       {"clips_read", report.clips_read},
                       {"clips", clips},
                       {"frames", frames},
                       {"labelled_clips", report.labelled_clips},
                       {"styles", std::move(styles)}}},
                     {"notes", report.notes},
                     {"table", std::move(table)},
                     {"sections", std::move(sections)},
                     {"times", std::move(times)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace morphograph
