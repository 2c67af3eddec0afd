#include "datasets/bvh_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v'; }
bool IsLineEnd(char c) { return c == '\n' || c == '\r'; }
char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return Lower(x) == Lower(y); });
}

// What a message may quote: short, printable ASCII.
std::string Quoted(std::string_view text) {
  constexpr size_t kLongest = 40;
  std::string quoted = "'";
  for (const char c : text.substr(0, kLongest)) quoted += c >= ' ' && c < 127 ? c : '?';
  quoted += text.size() > kLongest ? "...'" : "'";
  return quoted;
}

// Walks over the text token by token. Line and column are counted only when an error needs them.
class Scanner {
 public:
  Scanner(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  size_t offset() const { return at_; }
  size_t remaining() const { return text_.size() - at_; }
  std::string_view text() const { return text_; }

  [[noreturn]] void Fail(size_t offset, const std::string& reason) const {
    int line = 1;
    size_t line_start = 0;
    for (size_t i = 0; i < offset && i < text_.size(); ++i) {
      const bool lone_return = text_[i] == '\r' && (i + 1 >= text_.size() || text_[i + 1] != '\n');
      if (text_[i] == '\n' || lone_return) {
        ++line;
        line_start = i + 1;
      }
    }
    throw DatasetError(source_, line, static_cast<int>(offset - line_start) + 1, reason);
  }

  // Returns whether a line end was crossed.
  bool SkipSpace() {
    bool crossed = false;
    while (at_ < text_.size() && IsSpace(text_[at_])) crossed |= IsLineEnd(text_[at_++]);
    return crossed;
  }

  bool AtEnd() {
    SkipSpace();
    return at_ == text_.size();
  }

  // The next word up to white space or a brace; a brace is a word of its own. Empty at the end of the text.
  std::string_view Next() {
    SkipSpace();
    start_ = at_;
    if (at_ < text_.size() && IsBrace(text_[at_])) {
      ++at_;
    } else {
      while (at_ < text_.size() && !IsSpace(text_[at_]) && !IsBrace(text_[at_])) ++at_;
    }
    return text_.substr(start_, at_ - start_);
  }
  // Where the last word or number began.
  size_t start() const { return start_; }

  std::string_view Peek() {
    const size_t at = at_;
    const std::string_view word = Next();
    at_ = at;
    return word;
  }

  // The rest of the line without the blanks around it, ending before an opening brace: names may hold blanks.
  std::string_view RestOfLine() {
    while (at_ < text_.size() && IsSpace(text_[at_]) && !IsLineEnd(text_[at_])) ++at_;
    start_ = at_;
    while (at_ < text_.size() && !IsLineEnd(text_[at_]) && text_[at_] != '{') ++at_;
    size_t end = at_;
    while (end > start_ && IsSpace(text_[end - 1])) --end;
    return text_.substr(start_, end - start_);
  }

  void Expect(std::string_view word) {
    const std::string_view found = Next();
    if (EqualsIgnoringCase(found, word)) return;
    Fail(start_, "expected '" + std::string(word) + "', found " + Found(found));
  }

  static std::string Found(std::string_view word) { return word.empty() ? "the end of the file" : Quoted(word); }

  double Number(const char* what) {
    SkipSpace();
    start_ = at_;
    double value = 0;
    const char* begin = text_.data() + at_;
    const char* const end = text_.data() + text_.size();
    const bool plus = begin + 1 < end && *begin == '+' && begin[1] != '-' && begin[1] != '+';
    const auto [stop, status] = std::from_chars(begin + plus, end, value);
    if (status == std::errc() && (stop == end || IsSpace(*stop) || IsBrace(*stop)) && std::isfinite(value)) {
      at_ += static_cast<size_t>(stop - begin);
      return value;
    }
    FailNumber(what, status == std::errc::result_out_of_range);
  }

  std::int64_t Integer(const char* what) {
    const std::string_view word = Next();
    const size_t plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    std::int64_t value = 0;
    const char* const end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(word.data() + plus, end, value);
    if (word.empty() || stop != end || status != std::errc()) {
      Fail(start_, std::string(what) + ": expected a whole number, found " + Found(word));
    }
    return value;
  }

  // "Frames:", "Frames :", "Frame Time:" ... : the words, then an optional colon that may stick to what follows.
  void ExpectLabel(std::initializer_list<std::string_view> words) {
    std::string wanted;
    for (const std::string_view word : words) wanted += std::string(wanted.empty() ? "" : " ").append(word);
    SkipSpace();
    const size_t label_start = at_;
    for (const std::string_view word : words) {
      SkipSpace();
      if (text_.size() - at_ < word.size() || !EqualsIgnoringCase(text_.substr(at_, word.size()), word)) {
        Fail(label_start, "expected '" + wanted + ":', found " + Found(Peek()));
      }
      at_ += word.size();
    }
    SkipSpace();
    if (at_ < text_.size() && text_[at_] == ':') ++at_;
  }

 private:
  static bool IsBrace(char c) { return c == '{' || c == '}'; }

  [[noreturn]] void FailNumber(const char* what, bool out_of_range) {
    const std::string_view word = Next();
    std::string reason = std::string(what) + ": ";
    std::string_view digits = word;
    if (!digits.empty() && (digits[0] == '+' || digits[0] == '-')) digits.remove_prefix(1);
    if (word.empty()) {
      reason += "expected a number, found the end of the file";
    } else if (EqualsIgnoringCase(digits.substr(0, 3), "nan") || EqualsIgnoringCase(digits.substr(0, 3), "inf")) {
      reason += Quoted(word) + " is not a finite number";
    } else if (out_of_range) {
      reason += Quoted(word) + " is out of the range of a double";
    } else if (word.find(',') != std::string_view::npos) {
      reason += Quoted(word) + " is not a number (decimals need a point, not a comma)";
    } else {
      reason += "expected a number, found " + Quoted(word);
    }
    Fail(start_, reason);
  }

  std::string_view text_;
  const std::string& source_;
  size_t at_ = 0;
  size_t start_ = 0;
};

std::optional<Channel> ChannelFromWord(std::string_view word) {
  for (size_t i = 0; i < kBvhChannelWords.size(); ++i) {
    if (EqualsIgnoringCase(word, kBvhChannelWords[i])) return static_cast<Channel>(i);
  }
  return std::nullopt;
}

class Parser {
 public:
  Parser(std::string_view text, std::string source, const BvhLimits& limits)
      : limits_(limits), source_(std::move(source)), scan_(text, source_) {}

  BvhDocument Parse() {
    if (scan_.AtEnd()) scan_.Fail(0, "the file is empty");
    scan_.Expect("HIERARCHY");
    ParseHierarchy();
    ParseMotion();
    MakeNamesUnique();
    document_.source = source_;
    return std::move(document_);
  }

 private:
  void ParseHierarchy() {
    scan_.Expect("ROOT");
    OpenJoint(-1);
    while (!open_.empty()) {
      const int index = open_.back();
      const std::string_view word = scan_.Next();
      if (word == "}") {
        CloseJoint(index);
      } else if (EqualsIgnoringCase(word, "OFFSET")) {
        if (has_offset_[index]) scan_.Fail(scan_.start(), "a second OFFSET in joint " + Quoted(Name(index)));
        has_offset_[index] = true;
        document_.nodes[index].offset = ParseVector();
      } else if (EqualsIgnoringCase(word, "CHANNELS")) {
        ParseChannels(index);
      } else if (EqualsIgnoringCase(word, "JOINT")) {
        OpenJoint(index);
      } else if (EqualsIgnoringCase(word, "End")) {
        ParseEndSite(index);
      } else if (ChannelFromWord(word)) {
        scan_.Fail(scan_.start(), "joint " + Quoted(Name(index)) + " names more channels than CHANNELS counts");
      } else {
        scan_.Fail(scan_.start(), "expected OFFSET, CHANNELS, JOINT, End Site or '}' in joint " +
                                      Quoted(Name(index)) + ", found " + Scanner::Found(word));
      }
    }
  }

  const std::string& Name(int index) const { return document_.nodes[index].name; }

  void OpenJoint(int parent) {
    const size_t keyword = scan_.start();
    BvhDocument::Node node;
    const std::string_view name = scan_.RestOfLine();
    node.name = Utf8FromUnknown(name);
    document_.names_transcoded |= node.name != name;
    if (node.name.empty()) scan_.Fail(keyword, "a joint without a name");
    node.parent = parent;
    if (static_cast<int>(document_.nodes.size()) >= limits_.max_joints) {
      scan_.Fail(keyword, "more than " + std::to_string(limits_.max_joints) + " joints");
    }
    if (static_cast<int>(open_.size()) >= limits_.max_depth) {
      scan_.Fail(keyword, "joints nested deeper than " + std::to_string(limits_.max_depth));
    }
    scan_.Expect("{");
    open_.push_back(static_cast<int>(document_.nodes.size()));
    document_.nodes.push_back(std::move(node));
    has_offset_.push_back(false);
    has_channels_.push_back(false);
  }

  void CloseJoint(int index) {
    if (!has_offset_[index]) scan_.Fail(scan_.start(), "joint " + Quoted(Name(index)) + " has no OFFSET");
    open_.pop_back();
  }

  Eigen::Vector3d ParseVector() {
    Eigen::Vector3d vector;
    for (int i = 0; i < 3; ++i) vector[i] = scan_.Number("OFFSET");
    return vector;
  }

  void ParseChannels(int index) {
    BvhDocument::Node& node = document_.nodes[index];
    if (has_channels_[index]) scan_.Fail(scan_.start(), "a second CHANNELS in joint " + Quoted(node.name));
    has_channels_[index] = true;
    const std::int64_t count = scan_.Integer("CHANNELS");
    if (count < 0 || count > 6) {
      scan_.Fail(scan_.start(), "CHANNELS: " + std::to_string(count) + " channels; a joint has 0 to 6");
    }
    for (int i = 0; i < count; ++i) {
      const std::string_view word = scan_.Next();
      const std::optional<Channel> channel = ChannelFromWord(word);
      if (!channel) {
        scan_.Fail(scan_.start(), "CHANNELS of joint " + Quoted(node.name) + " says " + std::to_string(count) +
                                      " but channel " + std::to_string(i + 1) + " is " + Scanner::Found(word));
      }
      if (std::find(node.channels.begin(), node.channels.end(), *channel) != node.channels.end()) {
        scan_.Fail(scan_.start(), "joint " + Quoted(node.name) + " names channel " + Quoted(word) + " twice");
      }
      node.channels.push_back(*channel);
    }
  }

  void ParseEndSite(int index) {
    scan_.RestOfLine();  // "Site", "Effector" or a name of its own
    scan_.Expect("{");
    bool found = false;
    for (std::string_view word = scan_.Next(); word != "}"; word = scan_.Next()) {
      if (!EqualsIgnoringCase(word, "OFFSET") || found) {
        scan_.Fail(scan_.start(), "expected one OFFSET and '}' in the End Site of joint " + Quoted(Name(index)) +
                                      ", found " + Scanner::Found(word));
      }
      const Eigen::Vector3d offset = ParseVector();
      // A joint is modelled with one end site; exporters that write several mean the first.
      if (!document_.nodes[index].end_site) document_.nodes[index].end_site = offset;
      found = true;
    }
    if (!found) scan_.Fail(scan_.start(), "the End Site of joint " + Quoted(Name(index)) + " has no OFFSET");
  }

  void ParseMotion() {
    // File order is depth first, which is the order in which MOTION rows list the channels.
    for (BvhDocument::Node& node : document_.nodes) {
      node.first_channel = channels_;
      channels_ += static_cast<int>(node.channels.size());
    }
    if (channels_ == 0) scan_.Fail(scan_.offset(), "no joint has channels");
    if (EqualsIgnoringCase(scan_.Peek(), "ROOT")) {
      scan_.Next();
      scan_.Fail(scan_.start(), "a second ROOT: only one figure a file can be read");
    }
    scan_.Expect("MOTION");
    scan_.ExpectLabel({"Frames"});
    const std::int64_t frames = scan_.Integer("Frames");
    const size_t frames_at = scan_.start();
    if (frames < 0) scan_.Fail(frames_at, "Frames: " + std::to_string(frames) + " is negative");
    if (frames > limits_.max_frames) {
      scan_.Fail(frames_at, "Frames: " + std::to_string(frames) + " claimed; at most " +
                                std::to_string(limits_.max_frames) + " are read");
    }
    if (frames * channels_ > limits_.max_values) {
      scan_.Fail(frames_at, "Frames: " + std::to_string(frames) + " frames of " + std::to_string(channels_) +
                                " channels claimed; at most " + std::to_string(limits_.max_values) +
                                " values are read");
    }
    const auto joints = static_cast<std::int64_t>(document_.nodes.size());
    if (frames * joints > limits_.max_joint_frames) {
      scan_.Fail(frames_at, "Frames: " + std::to_string(frames) + " frames of " + std::to_string(joints) +
                                " joints claimed; at most " + std::to_string(limits_.max_joint_frames) +
                                " rotations are read");
    }
    scan_.ExpectLabel({"Frame", "Time"});
    document_.frame_time_s = scan_.Number("Frame Time");
    if (!(document_.frame_time_s > 0)) scan_.Fail(scan_.start(), "Frame Time must be positive");
    ParseValues(static_cast<int>(frames));
  }

  void ParseValues(int frames) {
    // A value takes at least a digit and a blank, so the text bounds what is worth allocating.
    const size_t possible = scan_.remaining() / 2 / static_cast<size_t>(channels_) + 1;
    document_.values.resize(channels_, static_cast<int>(std::min<size_t>(possible, static_cast<size_t>(frames))));
    scan_.SkipSpace();
    for (int frame = 0; frame < frames; ++frame) {
      for (int channel = 0; channel < channels_; ++channel) {
        const bool new_line = scan_.SkipSpace();
        if (new_line != (channel == 0) && irregular_.empty() && frame + channel > 0) NoteIrregular(frame, channel);
        if (scan_.remaining() == 0) {
          scan_.Fail(scan_.offset(), "the file ends in frame " + std::to_string(frame + 1) + " of " +
                                         std::to_string(frames) + " after " + std::to_string(channel) + " of " +
                                         std::to_string(channels_) + " values" + irregular_);
        }
        document_.values(channel, frame) = scan_.Number("frame value");
      }
    }
    if (scan_.AtEnd()) return;
    const std::string_view word = scan_.Next();
    if (EqualsIgnoringCase(word, "MOTION")) {
      scan_.Fail(scan_.start(), "a second MOTION section: only one a file can be read");
    }
    scan_.Fail(scan_.start(), "expected the end of the file after " + std::to_string(frames) + " frames of " +
                                  std::to_string(channels_) + " values, found " + Scanner::Found(word) + irregular_);
  }

  // Rows may be wrapped; only when the total is wrong does the first odd row tell where to look.
  void NoteIrregular(int frame, int channel) {
    if (channel > 0) {
      irregular_ = "; the line of frame " + std::to_string(frame + 1) + " ends after " + std::to_string(channel) +
                   " of " + std::to_string(channels_) + " values";
    } else {
      irregular_ = "; the line of frame " + std::to_string(frame) + " holds more than " +
                   std::to_string(channels_) + " values";
    }
  }

  void MakeNamesUnique() {
    std::unordered_set<std::string> taken;
    for (const BvhDocument::Node& node : document_.nodes) taken.insert(node.name);
    std::unordered_set<std::string> seen;
    std::unordered_map<std::string, int> last_suffix;
    for (BvhDocument::Node& node : document_.nodes) {
      if (seen.insert(node.name).second) continue;
      int& suffix = last_suffix.try_emplace(node.name, 1).first->second;
      std::string name;
      do {
        name = node.name + "_" + std::to_string(++suffix);
      } while (!taken.insert(name).second);
      seen.insert(name);
      node.name = std::move(name);
    }
  }

  const BvhLimits limits_;
  const std::string source_;
  Scanner scan_;
  BvhDocument document_;
  std::vector<int> open_;  // joints whose brace is open: a stack of our own, so depth costs no call stack
  std::vector<char> has_offset_, has_channels_;
  int channels_ = 0;
  std::string irregular_;
};

}  // namespace

BvhDocument ParseBvh(std::string_view text, std::string source, const BvhLimits& limits) {
  if (text.starts_with("\xEF\xBB\xBF")) {
    text.remove_prefix(3);
  } else if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw DatasetError(std::move(source), 1, 1, "the text is UTF-16; BVH is read as ASCII or UTF-8");
  }
  return Parser(text, std::move(source), limits).Parse();
}

BvhDocument ReadBvhFile(const std::filesystem::path& path, const BvhLimits& limits) {
  return ParseBvh(ReadFileText(path), path.string(), limits);
}

}  // namespace morphograph
