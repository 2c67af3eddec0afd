#include "datasets/manifest.h"

#include <fnmatch.h>
#include <re2/re2.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "datasets/errors.h"
#include "datasets/file_text.h"

namespace morphograph {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 16;

// Reads members of one object and remembers which, so that what is left over can be refused.
class ObjectReader {
 public:
  ObjectReader(const json& object, std::string pointer, const std::string& file)
      : object_(object), pointer_(std::move(pointer)), file_(file) {
    if (!object.is_object()) Fail("", "expected an object");
  }

  [[noreturn]] void Fail(const std::string& member, const std::string& reason) const {
    const std::string pointer = Pointer(member);
    throw DatasetError(file_, (pointer.empty() ? "the whole document" : pointer) + ": " + reason);
  }

  std::string Pointer(const std::string& member) const {
    if (member.empty()) return pointer_;
    std::string escaped;
    for (const char c : member) escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    return pointer_ + "/" + escaped;
  }

  const json* Find(const std::string& member) {
    known_.insert(member);
    const auto found = object_.find(member);
    return found == object_.end() ? nullptr : &*found;
  }

  void Read(const std::string& member, std::string* text) {
    if (const json* value = Find(member)) {
      if (!value->is_string()) Fail(member, "expected a string");
      *text = value->get<std::string>();
    }
  }

  void Read(const std::string& member, bool* flag) {
    if (const json* value = Find(member)) {
      if (!value->is_boolean()) Fail(member, "expected true or false");
      *flag = value->get<bool>();
    }
  }

  void Read(const std::string& member, std::vector<std::string>* texts) {
    if (const json* value = Find(member)) {
      if (!value->is_array()) Fail(member, "expected an array of strings");
      for (size_t i = 0; i < value->size(); ++i) {
        if (!(*value)[i].is_string()) {
          throw DatasetError(file_, Pointer(member) + "/" + std::to_string(i) + ": expected a string");
        }
        texts->push_back((*value)[i].get<std::string>());
      }
    }
  }

  void Read(const std::string& member, std::optional<int>* frame) {
    if (const json* value = Find(member)) {
      if (!value->is_number_integer() || *value < 0 || *value > std::numeric_limits<int>::max()) {
        Fail(member, "expected a frame number, 0 or more");
      }
      *frame = value->get<int>();
    }
  }

  void RefuseUnknown() const {
    for (const auto& [member, value] : object_.items()) {
      if (!known_.contains(member)) Fail(member, "unknown field");
    }
  }

 private:
  const json& object_;
  const std::string pointer_;
  const std::string& file_;
  std::set<std::string> known_;
};

[[noreturn]] void FailAtByte(std::string_view text, size_t byte, const std::string& file, const std::string& reason) {
  const std::string_view before = text.substr(0, byte);
  const int line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  const size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  throw DatasetError(file, line, static_cast<int>(before.size() - line_start) + 1, reason);
}

json ParseJson(std::string_view text, const std::string& file) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::set<std::string>> open;  // member names of every open object
  const auto check = [&](int depth, json::parse_event_t event, json& value) {
    if (depth > kMaxDepth) throw DatasetError(file, "nested deeper than " + std::to_string(kMaxDepth));
    if (event == json::parse_event_t::object_start) {
      open.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      open.pop_back();
    } else if (event == json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second) {
      throw DatasetError(file, "member \"" + value.get<std::string>() + "\" stands twice in one object");
    }
    return true;
  };
  try {
    return json::parse(text, check);
  } catch (const json::parse_error& error) {
    FailAtByte(text, error.byte > 0 ? error.byte - 1 : 0, file, "not valid JSON");
  } catch (const json::exception&) {
    throw DatasetError(file, "holds a number past the range of a double");
  }
}

void ReadImport(ObjectReader* manifest, const std::string& file, ClipImportOptions* import) {
  if (const json* value = manifest->Find("metres_per_unit")) {
    if (!value->is_number() || !(value->get<double>() > 0) || !std::isfinite(value->get<double>())) {
      manifest->Fail("metres_per_unit", "expected a positive number");
    }
    import->metres_per_unit = value->get<double>();
  }
  if (const json* value = manifest->Find("up_axis")) {
    if (*value == "Y") {
      import->up_axis = UpAxis::kY;
    } else if (*value == "Z") {
      import->up_axis = UpAxis::kZ;
    } else {
      manifest->Fail("up_axis", "expected \"Y\" or \"Z\"");
    }
  }
  if (const json* value = manifest->Find("roles")) {
    ObjectReader roles(*value, manifest->Pointer("roles"), file);
    for (const auto& [role, joint] : value->items()) {
      if (!RoleFromName(role)) roles.Fail(role, "no such joint role");
      roles.Read(role, &import->roles[role]);
    }
  }
}

void ReadClips(ObjectReader* manifest, const std::string& file, std::map<std::string, ClipSelection>* clips) {
  const json* value = manifest->Find("clips");
  if (!value) return;
  const ObjectReader names(*value, manifest->Pointer("clips"), file);
  for (const auto& [stem, entry] : value->items()) {
    ObjectReader reader(entry, names.Pointer(stem), file);
    ClipSelection& selection = (*clips)[stem];
    reader.Read("from", &selection.from);
    reader.Read("to", &selection.to);
    reader.Read("exclude", &selection.exclude);
    if (entry.contains("style")) {
      selection.style.emplace();
      reader.Read("style", &*selection.style);
    }
    reader.Find("style");
    reader.RefuseUnknown();
    if (selection.from && selection.to && *selection.from > *selection.to) {
      reader.Fail("to", "lies before \"from\"");
    }
  }
}

void ReadActions(ObjectReader* manifest, const std::string& file, DatasetManifest* read) {
  const json* value = manifest->Find("actions");
  if (!value) return;
  ObjectReader actions(*value, manifest->Pointer("actions"), file);
  for (const auto& [action, patterns] : value->items()) {
    actions.Read(action, &read->actions[action]);
    if (action.empty() || action == read->action) actions.Fail(action, "must name another action than \"action\"");
    if (patterns.empty()) actions.Fail(action, "has no pattern of files");
  }
}

// RE2, because it takes linear time and bounded memory and stack, whatever the pattern and the name are.
void CheckStylePattern(const ObjectReader& manifest, const std::string& text) {
  const RE2 pattern(text, RE2::Quiet);
  if (!pattern.ok()) manifest.Fail("style", "not a regular expression: " + pattern.error().substr(0, 200));
  if (pattern.NumberOfCapturingGroups() < 1) manifest.Fail("style", "has no group (...) that would hold the style");
}

}  // namespace

DatasetManifest ParseManifest(std::string_view text, const std::string& file) {
  const json document = ParseJson(text, file);
  ObjectReader reader(document, "", file);
  DatasetManifest manifest;
  manifest.file = file;
  reader.Read("name", &manifest.name);
  reader.Read("action", &manifest.action);
  ReadActions(&reader, file, &manifest);
  reader.Read("source", &manifest.source);
  reader.Read("licence", &manifest.licence);
  reader.Read("attribution", &manifest.attribution);
  ReadImport(&reader, file, &manifest.import);
  reader.Read("style", &manifest.style_pattern);
  if (reader.Find("style")) CheckStylePattern(reader, manifest.style_pattern);
  reader.Read("include", &manifest.include);
  reader.Read("exclude", &manifest.exclude);
  ReadClips(&reader, file, &manifest.clips);
  reader.Read("mirror", &manifest.mirror);
  reader.Read("bend", &manifest.bend);
  reader.Read("keyframes", &manifest.keyframes);
  reader.RefuseUnknown();
  if (manifest.action.empty()) reader.Fail("action", "is empty");
  if (manifest.keyframes.ends_with(".json")) {
    manifest.keyframe_examples = std::filesystem::path(file).parent_path() / manifest.keyframes;
    manifest.keyframes.clear();
  } else if (manifest.keyframes != "walking") {
    reader.Fail("keyframes", "expected \"walking\" or a file of labelled examples (*.json)");
  }
  return manifest;
}

DatasetManifest ReadManifest(const std::filesystem::path& path) {
  return ParseManifest(ReadFileText(path), path.string());
}

namespace {

bool FitsAny(const std::vector<std::string>& patterns, const std::filesystem::path& relative_path) {
  const std::string name = relative_path.filename().string();
  const std::string path = relative_path.generic_string();
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0 || ::fnmatch(pattern.c_str(), path.c_str(), 0) == 0;
  });
}

}  // namespace

bool Includes(const DatasetManifest& manifest, const std::filesystem::path& relative_path) {
  if (FitsAny(manifest.exclude, relative_path)) return false;
  return manifest.include.empty() || FitsAny(manifest.include, relative_path);
}

std::string OtherAction(const DatasetManifest& manifest, const std::filesystem::path& relative_path) {
  for (const auto& [action, patterns] : manifest.actions) {
    if (FitsAny(patterns, relative_path)) return action;
  }
  return "";
}

}  // namespace morphograph
