#include "datasets/bvh_writer.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace morphograph {
namespace {

constexpr int kMaxDecimals = 15;
constexpr int kLongestNumber = 340;  // digits of the greatest double, sign, point and decimals

// Prints doubles with a fixed number of decimals, rounded like std::to_chars: exact value, ties to even.
class FixedPrinter {
 public:
  explicit FixedPrinter(int decimals) : decimals_(decimals) {
    for (int i = 0; i < decimals; ++i) scale_ *= 10;
    scale_double_ = static_cast<double>(scale_);
  }

  // `out` has room for kLongestNumber characters. @return one past the last character.
  char* Print(double value, char* out) const {
    const double magnitude = std::abs(value);
    const double scaled = magnitude * scale_double_;
    // Above 2^51 the scaled value has no half steps left to round by.
    if (!(scaled < 0x1p51)) {
      return std::to_chars(out, out + kLongestNumber, value, std::chars_format::fixed, decimals_).ptr;
    }
    // Adding 1.5 * 2^52 rounds to the nearest whole number, ties to even.
    double whole = (scaled + 0x1.8p52) - 0x1.8p52;
    const double rest = scaled - whole;
    if (rest == 0.5 || rest == -0.5) {
      // The product itself was rounded: only its exact error tells on which side of the tie the value lies.
      const double error = std::fma(magnitude, scale_double_, -scaled);
      if (rest > 0 && error > 0) whole += 1;
      if (rest < 0 && error < 0) whole -= 1;
    }
    const auto digits = static_cast<std::uint64_t>(whole);
    if (value < 0 && digits != 0) *out++ = '-';
    out = std::to_chars(out, out + 20, digits / scale_).ptr;
    if (decimals_ == 0) return out;
    *out++ = '.';
    std::uint64_t fraction = digits % scale_;
    for (int i = decimals_ - 1; i >= 0; --i, fraction /= 10) out[i] = static_cast<char>('0' + fraction % 10);
    return out + decimals_;
  }

 private:
  int decimals_;
  std::uint64_t scale_ = 1;
  double scale_double_;
};

void CheckDocument(const BvhDocument& document, const BvhWriteOptions& options) {
  if (options.decimals < 0 || options.decimals > kMaxDecimals) {
    throw std::invalid_argument("WriteBvh: " + std::to_string(options.decimals) + " decimals; 0 to " +
                                std::to_string(kMaxDecimals) + " are possible");
  }
  if (document.nodes.empty()) throw std::invalid_argument("WriteBvh: no joints");
  if (!std::isfinite(document.frame_time_s) || !(document.frame_time_s > 0)) {
    throw std::invalid_argument("WriteBvh: frame time must be positive");
  }
  for (size_t i = 0; i < document.nodes.size(); ++i) {
    const BvhDocument::Node& node = document.nodes[i];
    if ((i == 0) != (node.parent < 0) || node.parent >= static_cast<int>(i)) {
      throw std::invalid_argument("WriteBvh: parent of joint '" + node.name + "' must precede it");
    }
    if (node.name.empty() || node.name.find_first_of("\n\r{") != std::string::npos) {
      throw std::invalid_argument("WriteBvh: joint " + std::to_string(i) + " has no name that BVH can hold");
    }
    const int end = node.first_channel + static_cast<int>(node.channels.size());
    if (node.first_channel < 0 || end > document.channel_count()) {
      throw std::invalid_argument("WriteBvh: channels of joint '" + node.name + "' are rows " +
                                  std::to_string(node.first_channel) + " to " + std::to_string(end - 1) + " of " +
                                  std::to_string(document.channel_count()));
    }
    if (!node.offset.allFinite() || (node.end_site && !node.end_site->allFinite())) {
      throw std::invalid_argument("WriteBvh: offset of joint '" + node.name + "' is not finite");
    }
  }
  if (!document.values.allFinite()) throw std::invalid_argument("WriteBvh: a value is not finite");
}

class Writer {
 public:
  Writer(const BvhDocument& document, const BvhWriteOptions& options)
      : document_(document), printer_(options.decimals), children_(document.nodes.size()) {
    for (size_t i = 1; i < document.nodes.size(); ++i) {
      children_[document.nodes[i].parent].push_back(static_cast<int>(i));
    }
  }

  std::string Write() {
    text_ = "HIERARCHY\n";
    WriteHierarchy();
    WriteMotion();
    return std::move(text_);
  }

 private:
  void WriteHierarchy() {
    struct Open {
      int node;
      size_t next_child = 0;
    };
    std::vector<Open> open;
    OpenNode(0, 0);
    open.push_back({0});
    while (!open.empty()) {
      const int node = open.back().node;
      if (open.back().next_child < children_[node].size()) {
        const int child = children_[node][open.back().next_child++];
        OpenNode(child, open.size());
        open.push_back({child});
        continue;
      }
      const std::string indent(open.size() - 1, '\t');
      if (const auto& site = document_.nodes[node].end_site) {
        text_ += indent + "\tEnd Site\n" + indent + "\t{\n" + indent + "\t\t";
        WriteOffset(*site);
        text_ += indent + "\t}\n";
      }
      text_ += indent + "}\n";
      open.pop_back();
    }
  }

  void OpenNode(int index, size_t depth) {
    const BvhDocument::Node& node = document_.nodes[index];
    const std::string indent(depth, '\t');
    text_ += indent + (index == 0 ? "ROOT " : "JOINT ") + node.name + "\n" + indent + "{\n" + indent + "\t";
    WriteOffset(node.offset);
    text_ += indent + "\tCHANNELS " + std::to_string(node.channels.size());
    for (const Channel channel : node.channels) {
      text_ += " ";
      text_ += kBvhChannelWords[static_cast<int>(channel)];
    }
    text_ += "\n";
    for (size_t i = 0; i < node.channels.size(); ++i) rows_.push_back(node.first_channel + static_cast<int>(i));
  }

  void WriteOffset(const Eigen::Vector3d& offset) {
    std::array<char, kLongestNumber> number;
    text_ += "OFFSET";
    for (int i = 0; i < 3; ++i) {
      text_ += " ";
      text_.append(number.data(), printer_.Print(offset[i], number.data()));
    }
    text_ += "\n";
  }

  void WriteMotion() {
    text_ += "MOTION\nFrames: " + std::to_string(document_.frame_count()) + "\nFrame Time: ";
    // Shortest digits that read back exactly, at least 7 decimals.
    std::array<char, kLongestNumber> number;
    char* end = std::to_chars(number.data(), number.data() + number.size(), document_.frame_time_s,
                              std::chars_format::fixed).ptr;
    const std::string_view shortest(number.data(), static_cast<size_t>(end - number.data()));
    const size_t point = shortest.find('.');
    if (point == std::string_view::npos || shortest.size() - point - 1 < 7) {
      end = std::to_chars(number.data(), number.data() + number.size(), document_.frame_time_s,
                          std::chars_format::fixed, 7).ptr;
    }
    text_.append(number.data(), end);
    text_ += "\n";
    const size_t start = text_.size();
    const size_t expected = static_cast<size_t>(document_.frame_count()) * rows_.size() * 12;
    text_.reserve(start + expected);
    std::string row;
    for (int frame = 0; frame < document_.frame_count(); ++frame) {
      const double* const values = document_.values.data() + static_cast<std::ptrdiff_t>(frame) * document_.channel_count();
      row.resize(rows_.size() * (kLongestNumber + 1));
      char* out = row.data();
      for (const int channel : rows_) {
        out = printer_.Print(values[channel], out);
        *out++ = ' ';
      }
      if (out != row.data()) out[-1] = '\n';
      text_.append(row.data(), out);
    }
  }

  const BvhDocument& document_;
  const FixedPrinter printer_;
  std::vector<std::vector<int>> children_;
  std::vector<int> rows_;  // rows of `values` in the order in which the hierarchy lists the channels
  std::string text_;
};

}  // namespace

std::string WriteBvh(const BvhDocument& document, const BvhWriteOptions& options) {
  CheckDocument(document, options);
  return Writer(document, options).Write();
}

}  // namespace morphograph
