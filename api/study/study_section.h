#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/study/chart.h"

namespace morphograph {

/// A line of the table beside the published figures.
struct StudyFigure {
  std::string what;                  // "contact distance, synthesised / captured, clean"
  std::optional<double> value;       // absent where the data do not allow it; `note` then says why
  std::string unit = {};                  // "" for ratios
  std::optional<double> published = {};   // the figure to beat
  std::string source = {};                // of the published figure: "Du Table 4.4"
  std::optional<double> at_least = {}, at_most = {};  // what this project asks of itself
  std::string note = {};                  // what differs from the published setting
  bool is_time = false;              // measured with a clock: goes with the times in study.json, as it is never twice the same
  bool Holds() const {
    return value && (!at_least || *value >= *at_least) && (!at_most || *value <= *at_most);
  }
};

/// A part of the study: text, charts, and the figures that it adds to the table.
struct StudySection {
  std::string id;     // of the member in study.json and of the anchor on the page: "alignment"
  std::string title;
  std::string text = {};   // plain paragraphs, a blank line between them: what was done, how it is read
  std::vector<std::variant<Chart, HeatMap>> drawings = {};
  std::vector<StudyFigure> figures = {};
  nlohmann::ordered_json data = {};  // everything behind the drawings, and more
};

inline std::optional<double> RatioTo(double value, double to) { return to > 0 ? std::optional(value / to) : std::nullopt; }

/// JSON of a value that may be absent.
template <typename T>
nlohmann::ordered_json OrNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace morphograph
