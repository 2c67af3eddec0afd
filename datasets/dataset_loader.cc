#include "datasets/dataset_loader.h"

#include <re2/re2.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <set>

#include "datasets/bvh_reader.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

// A file and its path below the folder in which it was found.
struct FoundFile {
  fs::path file;
  fs::path relative;
};

std::string StemOf(const fs::path& file) { return Utf8FromUnknown(file.stem().string()); }

bool IsBvhName(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension == ".bvh" && path.filename().string().front() != '.';
}

void SearchFolder(const fs::path& folder, std::vector<FoundFile>* found) {
  try {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_directory() && IsBvhName(entry.path())) {
        found->push_back({entry.path(), entry.path().lexically_relative(folder)});
      }
    }
  } catch (const fs::filesystem_error& error) {
    throw DatasetError(error.path1().empty() ? folder.string() : error.path1().string(),
                       "cannot be searched: " + error.code().message());
  }
}

std::vector<FoundFile> FindFiles(const std::vector<fs::path>& paths) {
  std::vector<FoundFile> files;
  std::set<fs::path> seen;
  for (const fs::path& path : paths) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) throw DatasetError(path.string(), "no such file or folder");
    std::vector<FoundFile> found;
    if (fs::is_directory(status)) {
      SearchFolder(path, &found);
      std::sort(found.begin(), found.end(), [](const FoundFile& a, const FoundFile& b) {
        return a.relative.generic_string() < b.relative.generic_string();
      });
    } else {
      found.push_back({path, path.filename()});
    }
    for (FoundFile& file : found) {
      const fs::path canonical = fs::weakly_canonical(file.file, error);
      if (seen.insert(error ? file.file : canonical).second) files.push_back(std::move(file));
    }
  }
  if (files.empty()) {
    std::string places;
    for (const fs::path& path : paths) places += (places.empty() ? "" : ", ") + path.string();
    throw DatasetError(places.empty() ? "data" : places, "no *.bvh file found");
  }
  return files;
}

std::string StyleByPattern(const RE2& pattern, const std::string& stem) {
  std::string style;
  return RE2::PartialMatch(stem, pattern, &style) ? style : std::string();
}

// The word of `<anything>_<word>_<number>`, else nothing.
std::optional<std::string> WordBeforeNumber(const std::string& stem) {
  const size_t number = stem.rfind('_');
  if (number == std::string::npos || number == 0 || number + 1 == stem.size()) return std::nullopt;
  const size_t word = stem.rfind('_', number - 1);
  if (word == std::string::npos || word == 0 || word + 1 == number) return std::nullopt;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-'; };
  const std::string style = stem.substr(word + 1, number - word - 1);
  if (!std::all_of(stem.begin() + static_cast<std::ptrdiff_t>(number) + 1, stem.end(), is_digit)) return std::nullopt;
  if (!std::all_of(style.begin(), style.end(), is_letter)) return std::nullopt;
  return style;
}

std::vector<std::string> FindStyles(const std::vector<FoundFile>& files, const DatasetManifest& manifest) {
  std::vector<std::string> styles(files.size());
  if (!manifest.style_pattern.empty()) {
    const RE2 pattern(manifest.style_pattern, RE2::Quiet);
    for (size_t i = 0; i < files.size(); ++i) styles[i] = StyleByPattern(pattern, StemOf(files[i].file));
    return styles;
  }
  for (size_t i = 0; i < files.size(); ++i) {
    const std::optional<std::string> word = WordBeforeNumber(StemOf(files[i].file));
    if (!word) return std::vector<std::string>(files.size());
    styles[i] = *word;
  }
  return styles;
}

LoadedClip LoadClip(const fs::path& file, const ClipSelection& selection, const ClipImportOptions& options,
                    const BvhLimits& limits) {
  LoadedClip loaded;
  loaded.file = file;
  ClipImportReport report;
  loaded.clip = ImportClip(ReadBvhFile(file, limits), options, &report);
  loaded.first_frame = report.dropped_frames;
  loaded.note = report.note;
  const int file_frames = loaded.clip.frame_count() + report.dropped_frames;
  for (const std::optional<int>& frame : {selection.from, selection.to}) {
    if (frame && *frame >= file_frames) {
      throw DatasetError(file.string(), "the manifest asks for frame " + std::to_string(*frame) + " of " +
                                            std::to_string(file_frames));
    }
  }
  const int first = std::max(selection.from.value_or(0), report.dropped_frames);
  const int last = selection.to.value_or(file_frames - 1);
  if (first > last) throw DatasetError(file.string(), "the manifest leaves nothing but leading rest frames");
  if (first != report.dropped_frames || last != file_frames - 1) {
    loaded.clip = loaded.clip.Slice(first - report.dropped_frames, last - first + 1);
  }
  loaded.first_frame = first;
  return loaded;
}

// All of them are named at once, so that a large set need not be tried again and again.
void ThrowIfBroken(const std::vector<FoundFile>& files, const std::vector<std::optional<DatasetError>>& broken) {
  constexpr int kMostNamed = 10;
  const DatasetError* first = nullptr;
  std::string others;
  int count = 0;
  for (size_t i = 0; i < files.size(); ++i) {
    if (!broken[i]) continue;
    if (++count == 1) {
      first = &*broken[i];
    } else if (count <= kMostNamed) {
      others += (others.empty() ? "" : ", ") + files[i].file.filename().string();
    }
  }
  if (!first) return;
  if (count == 1) throw *first;
  const std::string text = first->what();  // "file:line:column: reason"
  const std::string reason = text.substr(text.find(": ", first->file().size()) + 2);
  throw DatasetError(first->file(), first->line(), first->column(),
                     reason + " (" + std::to_string(count) + " files are broken, also: " + others +
                         (count > kMostNamed ? ", ..." : "") + ")");
}

}  // namespace

std::vector<fs::path> FindBvhFiles(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (FoundFile& found : FindFiles(paths)) files.push_back(std::move(found.file));
  return files;
}

Dataset LoadDataset(const std::vector<fs::path>& paths, const DatasetManifest& manifest, int jobs,
                    const DatasetLimits& limits) {
  Dataset dataset;
  std::vector<FoundFile> files;
  std::set<std::string> stems;
  for (FoundFile& found : FindFiles(paths)) {
    const std::string stem = StemOf(found.file);
    stems.insert(stem);
    const auto selection = manifest.clips.find(stem);
    if (!Includes(manifest, found.relative)) {
      dataset.skipped.push_back({found.file, "left out by the manifest's patterns"});
    } else if (selection != manifest.clips.end() && selection->second.exclude) {
      dataset.skipped.push_back({found.file, "excluded by the manifest"});
    } else {
      files.push_back(std::move(found));
    }
  }
  for (const auto& [stem, selection] : manifest.clips) {
    if (!stems.contains(stem)) dataset.notes.push_back("the manifest names clip '" + stem + "', which is not there");
  }
  if (files.empty()) throw DatasetError(manifest.file, "leaves none of the files to use");

  const std::vector<std::string> styles = FindStyles(files, manifest);
  dataset.clips.resize(files.size());
  std::atomic<std::int64_t> joint_frames = 0;
  std::vector<std::optional<DatasetError>> broken(files.size());
  ParallelFor(jobs, static_cast<int>(files.size()), [&](int i) {
    const auto found = manifest.clips.find(StemOf(files[i].file));
    const ClipSelection selection = found == manifest.clips.end() ? ClipSelection() : found->second;
    try {
      dataset.clips[i] = LoadClip(files[i].file, selection, manifest.import, limits.file);
    } catch (const DatasetError& error) {
      broken[i] = error;
      return;
    }
    dataset.clips[i].other_action = OtherAction(manifest, files[i].relative);
    dataset.clips[i].clip.style = selection.style.value_or(styles[i]);
    const MotionClip& clip = dataset.clips[i].clip;
    if ((joint_frames += std::int64_t{clip.joint_count()} * clip.frame_count()) > limits.max_joint_frames) {
      throw DatasetError(files[i].file.string(), "the set is too large: more than " +
                                                     std::to_string(limits.max_joint_frames) + " rotations with this clip");
    }
  });
  ThrowIfBroken(files, broken);
  return dataset;
}

}  // namespace morphograph
