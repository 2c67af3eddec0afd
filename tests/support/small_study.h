#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "api/study/study_context.h"
#include "api/study/study_section.h"
#include "tests/support/body_size.h"
#include "tests/support/small_model.h"

namespace morphograph::testing {

/// A quick study's context over the first few of SmallWalks().
/// @param other_size  every other clip is of a body this many times the size
inline StudyContext SmallContext(size_t most, int jobs = 2, LabelledClips labels = {}, double other_size = 1) {
  std::vector<LoadedClip> clips;
  for (auto& [name, clip] : SmallWalks()) {
    if (clips.size() == most) break;
    const bool other = other_size != 1 && clips.size() % 2 == 1;
    clips.push_back({other ? OfSize(clip, other_size) : std::move(clip), name + ".bvh", 0, ""});
  }
  StudyOptions options;
  options.quick = true;
  options.jobs = jobs;
  return StudyContext(std::move(clips), std::move(labels), std::move(options));
}

/// What must hold of any section: it says something, numbers are finite, and a figure without a value says why.
inline void ExpectSound(const StudySection& section) {
  EXPECT_FALSE(section.text.empty());
  EXPECT_FALSE(section.figures.empty() && section.drawings.empty());
  for (const StudyFigure& figure : section.figures) {
    if (figure.value) {
      EXPECT_TRUE(std::isfinite(*figure.value)) << figure.what;
    } else {
      EXPECT_FALSE(figure.note.empty()) << figure.what;
    }
  }
  for (const auto& drawing : section.drawings) {
    if (const Chart* chart = std::get_if<Chart>(&drawing)) {
      for (const ChartSeries& series : chart->series) EXPECT_EQ(series.x.size(), series.y.size()) << chart->title;
    } else {
      EXPECT_TRUE(std::get<HeatMap>(drawing).values.allFinite());
    }
  }
}

}  // namespace morphograph::testing
